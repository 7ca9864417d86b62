#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "daemon/looks/places.h"
#include "daemon/looks/refusal.h"
#include "daemon/looks/runtime_config.h"
#include "model/net/styles.h"

// Styles that are made while the daemon runs, among those of a configuration's network. Any thread;
// allocates; not the pipeline's thread. Pinned by tests/e2e/style_library_test.cpp.
namespace styled::pipeline {

// Where a style goes among those of the network.
struct Place {
  int number = -1;
  int replaced = -1;  // the style that had the name, or -1
};

// Refuses a name that a style of an earlier version may have, and a new one may not: one that looks
// like an option, and words of stylectl and OSC ("panic", "bypass"), in any case.
Refusal CheckNewName(const std::string& name);

// Refuses a name that is malformed, a preset's or one of the weights' styles; and any if there are
// net::kMaxAdded already.
Refusal FindPlace(const RuntimeConfig& config, const std::string& name, Place& place);

// The style that has this name, in any case, among those that were made.
Refusal FindMade(const RuntimeConfig& config, const std::string& name,
                 std::shared_ptr<const MadeStyle>& style);

// Puts the style into the configuration, in place of one of its name that was made: who moves in
// that fades over. Fills nearest and distance. Refused, with the configuration as it was: as
// FindPlace, weights without a space of styles, and a code that does not fit them.
Refusal PutStyle(MadeStyle style, RuntimeConfig& config);

// The places of the configuration's styles, with all in `fading` that are known.
Places PlacesOf(const RuntimeConfig& config);
// Whether the configuration's styles have these places already, and those of `fading` the codes.
bool HasPlaces(const RuntimeConfig& config, const Places& places);

// Gives the made styles these places: those of another daemon whose motions go on here, which name
// styles by their place. What that one has not is taken out, but not of the library. Refused, with
// the configuration as it was: a list with a style that was not made here, or with one twice. Who
// moves in one of them must be bound anew.
Refusal ArrangeStyles(const Places& places, RuntimeConfig& config);

// Gives a made style another name; performers that show it go on. Refuses as FindPlace and
// CheckNewName, a name that is taken, and a style that the configuration's presets, cues or [style]
// name.
Refusal RenameStyle(const MadeStyle& style, const std::string& to, RuntimeConfig& config);

// Takes the style of this number, one that was made, out of the list.
void RetireStyle(int number, RuntimeConfig& config);

// Takes a made style out; performers that show it fade. Refuses a style that the configuration
// names.
Refusal RemoveStyle(const MadeStyle& style, RuntimeConfig& config);

// The code, as far as the weights can be asked for it. Refuses one of another size, and numbers
// that are not finite or huge.
Refusal CheckCode(const net::StyleSpace& space, const net::StyleCode& code,
                  const std::string& what);

// "crc32c:" and eight digits.
std::string HashText(std::uint32_t crc);
std::string HashOfExample(const std::string& bytes);

}  // namespace styled::pipeline
