#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "model/base/realtime.h"
#include "proto/arkit/shapes.h"
#include "proto/rigs/rokoko/joints.h"
#include "proto/rigs/rokoko/lz4.h"

// Rokoko Studio's custom streaming: a datagram is one frame of all actors as JSON, plain or in an
// LZ4 frame. Layouts 3 (everything in `scene`, joints in `body`) and 2 and 2.5 (everything at the
// top, joints in the actor). Follows Rokoko's plug-ins for Blender, Unity and Unreal; characters
// and newtons are skipped. Pinned by tests/unit/rokoko, fuzzed by tests/fuzz/rokoko.
namespace styled::rokoko {

inline constexpr int kMaxActors = 8;
inline constexpr int kMaxProps = 16;
inline constexpr std::size_t kMaxNameSize = 64;                    // bytes of UTF-8
inline constexpr std::size_t kMaxTextSize = std::size_t{1} << 20;  // of JSON, unpacked

// World space, left-handed, +Y up, +Z forward; metres; x, y, z, w, not normalized.
struct JointPose {
  std::array<float, 3> position_m{};
  std::array<float, 4> rotation{0, 0, 0, 1};
};

struct Named {
  std::array<char, kMaxNameSize> name_bytes{};
  std::size_t name_size = 0;  // cut at a whole character

  std::string_view name() const { return {name_bytes.data(), name_size}; }
  void set_name(std::string_view name) noexcept;
};

struct Actor : Named {
  float hip_height_m = 0, total_height_m = 0;  // 0: not sent
  std::bitset<kJoints> has;                    // the joints that are present
  std::array<JointPose, kJoints> joints;       // only those in `has` are valid
  bool has_face = false;                       // any of ARKit's expressions was sent
  std::array<float, arkit::kShapes> face{};    // 0 .. 1 as a rule; as received, not checked
};

// A tracked object of the scene. A number that is not a float is NaN.
struct Prop : Named {
  JointPose pose;
};

struct Frame {
  float version = 3;  // 2, 2.5, 3; the layout is detected, not derived from it
  double time_s = 0;  // on Studio's timeline; 0 to 1e10
  float fps = 0;      // 0: not sent
  int actor_count = 0;
  int actors_left_out = 0;  // number of actors beyond kMaxActors
  std::array<Actor, kMaxActors> actors;
  int prop_count = 0;
  int props_left_out = 0;  // number of props beyond kMaxProps or without a pose
  std::array<Prop, kMaxProps> props;
};

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kNotRokoko,   // begins neither as a JSON object nor as an LZ4 frame
  kBadLz4,      // damaged, truncated, or bytes after it
  kTooLong,     // more than kMaxTextSize of text
  kBadJson,     // not JSON; not UTF-8
  kTooDeep,     // nesting deeper than JsonReader::kMaxDepth
  kBadVersion,  // older than 2, or 4 and newer
  kBadValue,    // a member is of another type or out of range
  kMissing,     // no actors, or no timestamp
  kCount        // the number of results
};
// A word for counters and messages: "ok", "bad_lz4", ...
std::string_view Name(DecodeResult result) noexcept;

class JsonReader;

// Decodes frames. A joint is present if its position and rotation have all their numbers. An
// invalid prop does not make the frame invalid. A member that is null counts as absent; of members
// of the same name the last one counts. JsonReader reads the text, with its limits. Of several
// errors in a frame any one may be the result. `frame` is unspecified unless kOk. One thread; the
// constructor allocates (15 MB), the other functions do not.
class Decoder {
 public:
  Decoder();
  ~Decoder();
  // Decodes a datagram.
  STYLED_REALTIME DecodeResult Decode(std::span<const std::byte> bytes, Frame& frame) noexcept;
  // Decodes the JSON of one frame.
  STYLED_REALTIME DecodeResult DecodeText(std::string_view text, Frame& frame) noexcept;

 private:
  Lz4Unpacker unpacker_;
  std::unique_ptr<JsonReader> json_;
};

// Writes the frame as JSON in layout 3 to the front of `out` and returns its size; 0 if it does not
// fit or a number is not finite. Joints that are not in `has` are left out. Numbers have the
// shortest form that reads back as the same float. No allocation.
STYLED_REALTIME std::size_t EncodeText(const Frame& frame, std::span<char> out) noexcept;

}  // namespace styled::rokoko
