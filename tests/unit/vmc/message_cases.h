#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proto/rigs/vmc/vmc.h"
#include "tests/unit/vmc/bytes.h"

// Every way to get a message of VMC wrong, one by one, and some right ones: all of them good OSC.
// Shared by the unit test and, as seeds, by the fuzzer.
namespace styled::vmc::testing {

struct MessageCase {
  std::string name;
  Bytes bytes;
  DecodeResult expected;
};

inline std::vector<MessageCase> MessageCases() {
  using R = DecodeResult;
  const std::vector<float> place{1, 2, 3, 0, 0, 0, 1};
  std::vector<MessageCase> cases;
  const auto add = [&cases](std::string name, R expected, Bytes bytes) {
    cases.push_back({std::move(name), std::move(bytes), expected});
  };
  // Right, with more than is known.
  add("T and more", R::kOk, S("/VMC/Ext/T") + S(",fi") + F(1) + I(2));
  add("a bone and more", R::kOk,
      S("/VMC/Ext/Bone/Pos") + S(",sfffffffs") + S("Hips") + Floats(place) + S("more"));
  add("OK and more", R::kOk, S("/VMC/Ext/OK") + S(",iiiii") + I(1) + I(1) + I(1) + I(1) + I(1));
  add("Apply with an argument", R::kOk, S("/VMC/Ext/Blend/Apply") + S(",i") + I(1));
  add("Apply without type tags", R::kOk, S("/VMC/Ext/Blend/Apply"));
  // Not ours.
  add("another protocol", R::kUnknownAddress, S("/foo/bar") + S(",i") + I(1));
  add("a MIDI note", R::kUnknownAddress,
      S("/VMC/Ext/Midi/Note") + S(",iiif") + I(0) + I(1) + I(60) + F(1));
  add("a camera", R::kUnknownAddress,
      S("/VMC/Ext/Cam") + S(",sffffffff") + S("Camera") + Floats(place) + F(60));
  add("a tracker", R::kUnknownAddress,
      S("/VMC/Ext/Tra/Pos") + S(",sfffffff") + S("LHR-1") + Floats(place));
  add("in lower case", R::kUnknownAddress, S("/vmc/ext/t") + S(",f") + F(1));
  add("an address that only begins like T", R::kUnknownAddress, S("/VMC/Ext/TT") + S(",f") + F(1));
  // Too little.
  add("T of nothing", R::kTooFewArguments, S("/VMC/Ext/T") + S(","));
  add("OK of nothing", R::kTooFewArguments, S("/VMC/Ext/OK") + S(","));
  add("a bone of nothing", R::kTooFewArguments, S("/VMC/Ext/Bone/Pos") + S(","));
  add("a bone without rotation", R::kTooFewArguments,
      S("/VMC/Ext/Bone/Pos") + S(",sfff") + S("Chest") + Floats({0, 1, 0}));
  add("a bone without w", R::kTooFewArguments,
      S("/VMC/Ext/Bone/Pos") + S(",sffffff") + S("Chest") + Floats({0, 1, 0, 0, 0, 0}));
  add("a root without w", R::kTooFewArguments,
      S("/VMC/Ext/Root/Pos") + S(",sffffff") + S("root") + Floats({0, 1, 0, 0, 0, 0}));
  add("an expression without value", R::kTooFewArguments,
      S("/VMC/Ext/Blend/Val") + S(",s") + S("Joy"));
  add("Thru of nothing", R::kTooFewArguments, S("/VMC/Thru/app/word") + S(","));
  // Of the wrong type.
  add("T as a whole number", R::kWrongType, S("/VMC/Ext/T") + S(",i") + I(12));
  add("T as a double", R::kWrongType, S("/VMC/Ext/T") + S(",d") + I(0) + I(0));
  add("T as a text", R::kWrongType, S("/VMC/Ext/T") + S(",s") + S("12"));
  add("OK as a float", R::kWrongType, S("/VMC/Ext/OK") + S(",f") + F(1));
  add("OK whose mode is a float", R::kWrongType, S("/VMC/Ext/OK") + S(",iif") + I(1) + I(3) + F(0));
  add("a bone by number", R::kWrongType,
      S("/VMC/Ext/Bone/Pos") + S(",ifffffff") + I(0) + Floats(place));
  add("a bone with a whole number", R::kWrongType,
      S("/VMC/Ext/Bone/Pos") + S(",sffffffi") + S("Hips") + Floats({0, 1, 0, 0, 0, 0}) + I(1));
  add("a root without name", R::kWrongType, S("/VMC/Ext/Root/Pos") + S(",fffffff") + Floats(place));
  add("an expression that is true", R::kWrongType, S("/VMC/Ext/Blend/Val") + S(",sT") + S("Joy"));
  add("Thru of a number", R::kWrongType, S("/VMC/Thru/app/word") + S(",i") + I(1));
  add("Thru of two texts", R::kWrongType, S("/VMC/Thru/a/b") + S(",ss") + S("x") + S("y"));
  return cases;
}

}  // namespace styled::vmc::testing
