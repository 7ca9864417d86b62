#pragma once

#include <string>
#include <vector>

#include "proto/rigs/vrchat/vrchat.h"
#include "tests/unit/vmc/bytes.h"

// Datagrams for VRChat by hand, after its documentation: addresses, types and order of values. The
// unit test and the fuzzer's seeds share them.
namespace styled::vrchat::testing {

using vmc::testing::Bundle;
using vmc::testing::Bytes;
using vmc::testing::Floats;
using vmc::testing::S;

inline Bytes TrackerMessage(const std::string& index, const std::string& what,
                            const std::vector<float>& values) {
  return S("/tracking/trackers/" + index + "/" + what) + S(",fff") + Floats(values);
}
inline Bytes SystemMessage(const std::string& device, const std::vector<float>& values) {
  return S("/tracking/vrsystem/" + device + "/pose") + S(",ffffff") + Floats(values);
}

struct Case {
  std::string name;
  Bytes bytes;  // one message
  DecodeResult expected;
};

inline std::vector<Case> MessageCases() {
  using enum DecodeResult;
  const auto address = [](const std::string& text) {
    return S(text) + S(",fff") + Floats({1, 2, 3});
  };
  return {
      {"a position", TrackerMessage("1", "position", {0.5F, 1, -2}), kOk},
      {"a rotation", TrackerMessage("8", "rotation", {10, 20, 30}), kOk},
      {"the head's position", TrackerMessage("head", "position", {0, 1.5F, 0}), kOk},
      {"the head's heading", TrackerMessage("head", "rotation", {0, 90, 0}), kOk},
      {"a system's head", SystemMessage("head", {1, 2, 3, 4, 5, 6}), kOk},
      {"a system's wrist", SystemMessage("rightwrist", {1, 2, 3, 4, 5, 6}), kOk},
      {"more than needed", S("/tracking/trackers/2/position") + S(",ffff") + Floats({1, 2, 3, 4}),
       kOk},
      {"no index 0", address("/tracking/trackers/0/position"), kUnknownAddress},
      {"no index 9", address("/tracking/trackers/9/position"), kUnknownAddress},
      {"no index 10", address("/tracking/trackers/10/position"), kUnknownAddress},
      {"a longer address", address("/tracking/trackers/1/position/x"), kUnknownAddress},
      {"a shorter one", address("/tracking/trackers/1"), kUnknownAddress},
      {"other case", address("/tracking/trackers/Head/position"), kUnknownAddress},
      {"eyes", address("/tracking/eye/CenterVec"), kUnknownAddress},
      {"an avatar's parameter", S("/avatar/parameters/x") + S(",f") + Floats({1}), kUnknownAddress},
      {"too few", S("/tracking/trackers/1/position") + S(",ff") + Floats({1, 2}), kTooFewArguments},
      {"none", S("/tracking/trackers/1/position") + S(","), kTooFewArguments},
      {"a text", S("/tracking/trackers/1/position") + S(",sff") + S("a") + Floats({1, 2}),
       kWrongType},
      {"integers", S("/tracking/vrsystem/head/pose") + S(",fffiii") + Floats({1, 2, 3, 4, 5, 6}),
       kWrongType},
      {"a system's cut pose", S("/tracking/vrsystem/head/pose") + S(",fff") + Floats({1, 2, 3}),
       kTooFewArguments},
  };
}

}  // namespace styled::vrchat::testing
