#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

// Reads the names that tools of all kinds, in several languages, give to the joints of a body.
namespace styled::rig {

// A place in the body without its side.
enum class Part : std::uint8_t {
  kHips,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kShoulder,
  kUpperArm,
  kLowerArm,
  kHand,
  kUpperLeg,
  kLowerLeg,
  kFoot,
  kToes,
  kCount
};

struct NameReading {
  // Bits of Part. `words`: the name as a whole, less side, number and prefix, is a word for these
  // parts. `hints`: some word of it is.
  std::uint16_t words = 0, hints = 0;
  int side = 0;        // 1 left, -1 right, 0 the middle or unsaid
  bool other = false;  // a finger, hair, a skirt, a control: not of the humanoid
  bool end = false;    // "LeftToe_End": the end of a bone, if no joint is below it
  bool twist = false;  // turns about a bone that another joint begins

  bool Says(Part part) const { return (words >> static_cast<unsigned>(part) & 1U) != 0; }
  bool Hints(Part part) const { return (hints >> static_cast<unsigned>(part) & 1U) != 0; }
};

// Reads the names of a skeleton's joints. A prefix up to the last ':' or '|', a prefix that all
// names share, and numbers are ignored; words are separated by spaces, signs and capitals. Words
// are English, Latin (femur), Japanese (as in MMD) and Chinese. Allocates; any thread. Pinned by
// tests/unit/rig/name_reading_test.cpp.
std::vector<NameReading> ReadNames(const std::vector<std::string>& names);

}  // namespace styled::rig
