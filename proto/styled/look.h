#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "model/base/status.h"
#include "model/body/parts.h"
#include "model/net/styles.h"
#include "proto/styled/v1/frame.pb.h"
#include "proto/styled/v1/look.pb.h"

// The fields of v1::Look as every format spells them. The configuration and the state file (TOML),
// stylectl (options and JSON) and OSC read and write a look by kLookFields, so that a new field of
// a known kind is one line of look.proto and one row here. Allocates; not for the hot path. Pinned
// by tests/unit/daemon/look_test.cpp.
namespace styled {

struct LookNumber {
  bool (v1::Look::*has)() const;
  float (v1::Look::*get)() const;
  void (v1::Look::*set)(float);
  float low, high, initial;  // in the unit of the name's suffix; the range is inclusive
  bool whole = false;        // whole numbers only
};
struct LookFlag {  // initially false
  bool (v1::Look::*has)() const;
  bool (v1::Look::*get)() const;
  void (v1::Look::*set)(bool);
};
struct LookName {  // of a style or a preset; initially ""
  bool (v1::Look::*has)() const;
  const std::string& (v1::Look::*get)() const;
  void (*set)(v1::Look&, const std::string&);
};
struct LookChoice {  // initially the first
  bool (v1::Look::*has)() const;
  int (*get)(const v1::Look&);
  void (*set)(v1::Look&, int);
  std::span<const std::string_view> words;  // by the number of the message's enum
};
struct LookMix {};    // styles and weights; initially empty
struct LookParts {};  // of the body, as body::FindParts reads them; initially all

struct LookField {
  std::string_view name;    // as in look.proto; the key in TOML and JSON
  std::string_view word;    // name of an option and in an OSC address: without the unit
  std::string_view former;  // a former name that is still read as key and word; "" = none
  std::string_view help;
  std::variant<LookNumber, LookFlag, LookName, LookChoice, LookMix, LookParts> kind;
};

inline constexpr float kMaxIdle = 1.5F;  // of Look.idle
inline constexpr auto kRootWords = std::to_array<std::string_view>({"follow", "stride"});

inline constexpr auto kLookFields = std::to_array<LookField>({
    {"mix", "mix", "", "styles and weights, at most 4, that sum to 1.5 at most", LookMix{}},
    {"strength", "strength", "", "of the style: 0 (bypass) to 1.5",
     LookNumber{&v1::Look::has_strength, &v1::Look::strength, &v1::Look::set_strength, 0,
                net::kMaxStrength, 1}},
    {"transition_ms", "transition", "", "fade of this and later changes, ms",
     LookNumber{&v1::Look::has_transition_ms, &v1::Look::transition_ms,
                &v1::Look::set_transition_ms, 0, net::kMaxTransition_s * 1000,
                net::kUsualTransition_s * 1000}},
    {"absolute", "absolute", "", "the network's pose as it is, not the performer's own detail",
     LookFlag{&v1::Look::has_absolute, &v1::Look::absolute, &v1::Look::set_absolute}},
    {"parts", "parts", "only", "the parts of the body that are styled, e.g. \"arms,head\"",
     LookParts{}},
    {"input_style", "input_style", "from", "the performer's own style, which is removed",
     LookName{&v1::Look::has_input_style, &v1::Look::input_style,
              [](v1::Look& look, const std::string& name) { look.set_input_style(name); }}},
    {"preset", "preset", "", "a mix of the daemon's configuration, by its name",
     LookName{&v1::Look::has_preset, &v1::Look::preset,
              [](v1::Look& look, const std::string& name) { look.set_preset(name); }}},
    {"root", "root", "",
     "where on the floor: \"follow\" the performer, or \"stride\", their path at the style's speed",
     LookChoice{&v1::Look::has_root, [](const v1::Look& look) { return int{look.root()}; },
                [](v1::Look& look, int root) { look.set_root(static_cast<v1::Root>(root)); },
                kRootWords}},
    {"vary", "vary", "", "the variation of the style: 1 to 99; 0: the style itself",
     LookNumber{&v1::Look::has_vary, &v1::Look::vary, &v1::Look::set_vary, 0, net::kVariations, 0,
                true}},
    {"vary_each", "vary_each", "", "each performer gets a different variation",
     LookFlag{&v1::Look::has_vary_each, &v1::Look::vary_each, &v1::Look::set_vary_each}},
    {"vary_amount", "amount", "", "of the variation: 0 (the style itself) to 1.5",
     LookNumber{&v1::Look::has_vary_amount, &v1::Look::vary_amount, &v1::Look::set_vary_amount, 0,
                net::kMaxStrength, 1}},
    {"drift_s", "drift", "", "the variation changes slowly: seconds to the next one; 0: constant",
     LookNumber{&v1::Look::has_drift_s, &v1::Look::drift_s, &v1::Look::set_drift_s, 0,
                net::kMaxDrift_s, 0}},
    {"mirror", "mirror", "", "left and right are exchanged, as in a mirror",
     LookFlag{&v1::Look::has_mirror, &v1::Look::mirror, &v1::Look::set_mirror}},
    {"idle", "idle", "", "how much the body breathes, sways and blinks by itself: 0 to 1.5",
     LookNumber{&v1::Look::has_idle, &v1::Look::idle, &v1::Look::set_idle, 0, kMaxIdle, 0}},
});

// Whether a look asks for variations of its styles.
bool RequestsVariations(const v1::Look& look);

// Whether the field can have this value (false for NaN); and the description of its range, e.g. "0
// to 1.5".
bool IsIn(const LookNumber& number, double value);
std::string Expected(const LookNumber& number);

// The field with this name, word or former name, or null.
const LookField* FindLookField(std::string_view name) noexcept;

// The number of a choice's word, empty if it has no such word; and all words, e.g. "a or b".
std::optional<int> FindChoice(const LookChoice& choice, std::string_view word);
std::string ChoiceWords(const LookChoice& choice);
// The word of the look's choice; that of an unknown number is the first.
std::string_view ChoiceWord(const LookChoice& choice, const v1::Look& look);

// v1::BodyPart and model/body/parts.h list the same parts in the same order, from 1; 0 means all.
body::Parts PartsOf(const v1::Look& look);
void SetParts(body::Parts parts, v1::Look& look);

// Every field at its initial value: the look of a performer without settings of its own.
v1::Look InitialLook();
bool Equal(const v1::Look& a, const v1::Look& b);
// Whether a change names no field, `clear` included.
bool IsEmpty(const v1::Look& change);
// Applies a change, which must have passed CheckLook, to a complete look. Of `preset` only the name
// is copied: the caller puts the preset's mix into the change. A mix without a preset clears the
// look's preset.
void Apply(const v1::Look& change, v1::Look& look);
// Whether all fields of a change are in range; the error names the field and what was expected.
// Names of styles and presets are not looked up, and weights are not summed.
Status CheckLook(const v1::Look& change);

}  // namespace styled
