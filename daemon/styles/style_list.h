#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "daemon/looks/places.h"
#include "daemon/looks/refusal.h"
#include "daemon/looks/runtime_config.h"
#include "model/net/styles.h"

// Styles that are made while the daemon runs, in the list of a configuration's network. Any thread;
// allocates; not the pipeline's thread. Pinned by tests/e2e/style_library_test.cpp.
namespace styled::pipeline {

// The place of a new style in the network's list.
struct Place {
  int number = -1;
  int replaced = -1;  // the style that had the name before, or -1
};

// Refuses names that earlier versions allowed and new styles may not have: a name that looks like
// an option, and words of stylectl and OSC ("panic", "bypass"), in any case.
Status CheckNewName(const std::string& name);

// Refuses a name that is malformed, a preset's, or that of one of the weights' styles; and any name
// if there are net::kMaxAdded already.
Status FindPlace(const RuntimeConfig& config, const std::string& name, Place& place);

// The made style with this name, in any case.
Status FindMade(const RuntimeConfig& config, const std::string& name,
                std::shared_ptr<const MadeStyle>& style);

// Adds the style to the configuration, or replaces the made style of the same name; performers in
// that style fade over, or with `in_place` change at once. Fills nearest and distance. Refuses as
// FindPlace does, and refuses weights without a style encoder and a code that does not fit them;
// the configuration is then unchanged.
Status PutStyle(MadeStyle style, RuntimeConfig& config, bool in_place = false);

// The places of the configuration's styles, and those in `fading` that are known.
Places PlacesOf(const RuntimeConfig& config);
// Whether the configuration's styles already have these places, and those of `fading` the same
// codes.
bool HasPlaces(const RuntimeConfig& config, const Places& places);

// Gives the made styles these places. They are the places of another daemon whose motions continue
// here and refer to styles by place. Styles that the other daemon does not have are removed from
// the list, but not from the library. Refuses a list with a style that was not made here, or with
// one twice; the configuration is then unchanged. Performers in one of these styles must be bound
// again.
Status ArrangeStyles(const Places& places, RuntimeConfig& config);

// Renames a made style; performers that show it are not affected. Refuses as FindPlace and
// CheckNewName do, and refuses a name in use and a style that the configuration's presets, cues or
// [style] name.
Status RenameStyle(const MadeStyle& style, const std::string& to, RuntimeConfig& config);

// Removes the made style of this number from the list.
void RetireStyle(int number, RuntimeConfig& config);

// Removes a made style; performers that show it fade out. Refuses a style that the configuration
// names.
Status RemoveStyle(const MadeStyle& style, RuntimeConfig& config);

// The code, limited to what the weights support. Refuses a code of another size, and numbers that
// are not finite or are huge.
Status CheckCode(const net::StyleSpace& space, const net::StyleCode& code, const std::string& what);

// The refusal of an example or a variation by weights that make no styles; it names the keys of
// those that do.
Status NoEncoder(const net::Model& model);

// "crc32c:" and eight digits.
std::string HashText(std::uint32_t crc);
std::string HashOfExample(const std::string& bytes);

}  // namespace styled::pipeline
