#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Xsens MVN's network streamer (MXTP): big-endian datagrams of a 24-byte header and a payload by
// type. Follows the vendor's "MVN real-time network streaming, protocol specification", rev. N,
// 2018. Where its text and real packets differ (metres in type 02), the packets are followed. Pure
// functions, any thread, no allocation. Pinned by tests/unit/mvn, fuzzed by tests/fuzz/mvn.
namespace styled::mvn {

inline constexpr std::size_t kHeaderSize = 24;
inline constexpr std::size_t kMaxDatagramSize = 65507;
inline constexpr int kBodySegments = 23;
inline constexpr int kMaxProps = 4;
// Body, props, twenty segments of each hand.
inline constexpr int kMaxSegments = kBodySegments + kMaxProps + 40;

enum class Type : std::uint8_t {
  kEuler = 1,       // poses: global, centimetres, +Y up, degrees
  kQuaternion = 2,  // poses: global, metres, +Z up, +X forward
  kMeta = 12,       // "key:value" lines
  kScale = 13,      // the T-pose
  kTimecode = 25
};

struct Header {
  Type type = Type::kQuaternion;  // any two-digit number; only those above are decoded
  std::uint32_t sample = 0;       // the same for all datagrams of one sample; may skip values
  std::uint8_t datagram = 0;      // index within the sample
  bool last = true;
  std::uint8_t items = 0;
  std::uint32_t time_ms = 0;  // since the recording or the application started
  std::uint8_t character = 0;
  std::uint8_t body_segments = kBodySegments, props = 0, finger_segments = 0;
  std::uint16_t payload_size = 0;  // 0 from old senders
};

struct Segment {
  std::uint32_t id = 0;                       // 1 .. 23 of the body
  std::array<float, 3> position{};            // space and unit of its Type
  std::array<float, 4> rotation{0, 0, 0, 1};  // x, y, z, w, as received: not normalized
};

// One datagram's part of a sample: consecutive segments in the order of the wire.
struct Pose {
  int count = 0;
  std::array<Segment, kMaxSegments> segments{};
};

// The T-pose: the segments' origins when all orientations are identity.
struct Scale {
  struct Row {
    std::string_view name;              // points into the decoded bytes
    std::array<float, 3> position_m{};  // +Z up
  };
  int count = 0;  // 0: the datagram holds points only
  std::array<Row, kMaxSegments> segments{};
};

struct Timecode {
  std::uint32_t hours = 0, minutes = 0, seconds = 0, milliseconds = 0;
};

enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kTooShort,        // fewer bytes than a header, or than its items require
  kBadMagic,        // not "MXTP" and two digits
  kLengthMismatch,  // more bytes than header and items require
  kTooManyItems,    // more than kMaxSegments
  kBadText,         // a string that exceeds its datagram, or an invalid timecode
  kNotThisType,     // the header names another type
  kCount
};
std::string_view Name(DecodeResult result) noexcept;

STYLED_REALTIME DecodeResult DecodeHeader(std::span<const std::byte> bytes, Header& out) noexcept;

// Decode the payload of a whole datagram, header included. Out parameters are unspecified unless
// kOk. DecodePose handles types 01 and 02. Type 01's angles become quaternions as R = Rz Ry Rx, the
// order of MotionBuilder, for whose plug-in the type was made; the specification does not state it.
STYLED_REALTIME DecodeResult DecodePose(std::span<const std::byte> bytes, Header& header,
                                        Pose& out) noexcept;
STYLED_REALTIME DecodeResult DecodeScale(std::span<const std::byte> bytes, Scale& out) noexcept;
// The value of "name:"; empty if there is none.
STYLED_REALTIME DecodeResult DecodeName(std::span<const std::byte> bytes,
                                        std::string_view& name) noexcept;
STYLED_REALTIME DecodeResult DecodeTimecode(std::span<const std::byte> bytes,
                                            Timecode& out) noexcept;

// Encoders write to the front of `out` and return the size; 0 if it does not fit. They set the
// header's type, items and payload_size. EncodePose writes kEuler if the header's type is that,
// which requires unit quaternions, else kQuaternion.
std::size_t EncodePose(Header header, std::span<const Segment> segments,
                       std::span<std::byte> out) noexcept;
std::size_t EncodeScale(Header header, std::span<const Scale::Row> segments,
                        std::span<std::byte> out) noexcept;
std::size_t EncodeName(Header header, std::string_view name, std::span<std::byte> out) noexcept;
std::size_t EncodeTimecode(Header header, const Timecode& timecode,
                           std::span<std::byte> out) noexcept;

// Segments in the order of the wire, with their parents (-1: the root).
struct SegmentRow {
  std::string_view name;
  int parent;
};
inline constexpr std::array<SegmentRow, kBodySegments> kSegments{{
    {"Pelvis", -1},
    {"L5", 0},
    {"L3", 1},
    {"T12", 2},
    {"T8", 3},
    {"Neck", 4},
    {"Head", 5},
    {"RightShoulder", 4},
    {"RightUpperArm", 7},
    {"RightForeArm", 8},
    {"RightHand", 9},
    {"LeftShoulder", 4},
    {"LeftUpperArm", 11},
    {"LeftForeArm", 12},
    {"LeftHand", 13},
    {"RightUpperLeg", 0},
    {"RightLowerLeg", 15},
    {"RightFoot", 16},
    {"RightToe", 17},
    {"LeftUpperLeg", 0},
    {"LeftLowerLeg", 19},
    {"LeftFoot", 20},
    {"LeftToe", 21},
}};

}  // namespace styled::mvn
