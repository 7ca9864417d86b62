#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "proto/rigs/qtm/packet.h"

namespace styled::qtm {

// Larger documents are refused: a real XML has some forty elements for each segment, at most about
// 30 deep. Room for as many skeletons as kMaxXmlSize has.
inline constexpr std::size_t kMaxElements = 200'000;
inline constexpr int kMaxDepth = 128;

// A segment of a skeleton in its T-pose.
struct SegmentDescription {
  std::string name;
  std::uint32_t id = 0;
  int parent = -1;  // index of an earlier segment; -1: a root
  // Relative to the parent, or in the capture volume if SkeletonDescription::global is set.
  std::array<double, 3> position_mm{};
  std::array<double, 4> rotation{0, 0, 0, 1};  // x, y, z, w
};
struct SkeletonDescription {
  std::string name;
  bool global = false;                       // before 1.21: every segment in the capture volume
  std::vector<SegmentDescription> segments;  // the first kMaxSegments of those found
  std::size_t segments_left_out = 0;         // found beyond them, not read
};

enum class Axis : std::uint8_t { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

// The content of an XML of GetParameters; parameters that it does not mention are empty.
struct Parameters {
  std::optional<double> frequency_hz;  // General
  std::optional<Axis> up;              // 3D: AxisUpwards
  // Skeleton, in the order of frames. Of those beyond kMaxSkeletons only the name is read.
  std::optional<std::vector<SkeletonDescription>> skeletons;
  std::vector<std::string> labels;  // 3D: written, never read
};

// Reads any of these parameters, found by their elements' names. T-poses are DefaultTransform's,
// else Transform's, else the segment's own. Errors state the place and what was expected: text that
// is not XML, more than kMaxElements or kMaxDepth, an invalid number, a segment whose Parent_ID is
// not that of an earlier segment. Allocates at most about 30 times the text. Pinned by
// tests/unit/qtm/parameters_test.cpp.
Result<Parameters> ReadParameters(std::string_view xml);

// Writes the XML of version 1.`minor`: nested segments from 1.21 on, for which positions are
// relative to the parents; else a flat list in the capture volume.
std::string WriteParameters(const Parameters& parameters, int minor);

// "+Z", as in the XML.
std::string_view Name(Axis axis) noexcept;

}  // namespace styled::qtm
