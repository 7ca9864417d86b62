// Fuzzes styled::mvn: every decoder with the same bytes, and the splitting of the stream.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "proto/rigs/mvn/mvn.h"
#include "proto/rigs/mvn/stream.h"

namespace mvn = styled::mvn;

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

// Poses of type 02 encode to the bytes that they were decoded from, except for the header's
// reserved bytes and payload size.
void CheckPose(std::span<const std::byte> bytes) {
  mvn::Header header;
  static mvn::Pose pose;
  if (mvn::DecodePose(bytes, header, pose) != mvn::DecodeResult::kOk) return;
  Require(pose.count <= mvn::kMaxSegments && pose.count == header.items);
  if (header.type != mvn::Type::kQuaternion) return;
  std::vector<std::byte> again(bytes.size());
  const auto count = static_cast<std::size_t>(pose.count);
  Require(mvn::EncodePose(header, std::span(pose.segments).first(count), again) == bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    Require((i >= 20 && i < mvn::kHeaderSize) || again[i] == bytes[i]);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  CheckPose(bytes);
  static mvn::Scale scale;
  if (mvn::DecodeScale(bytes, scale) == mvn::DecodeResult::kOk) {
    for (int i = 0; i < scale.count; ++i) Require(scale.segments[i].name.size() < size);
  }
  std::string_view name;
  (void)mvn::DecodeName(bytes, name);
  mvn::Timecode timecode;
  (void)mvn::DecodeTimecode(bytes, timecode);
  for (auto rest = bytes; !rest.empty();) {
    std::size_t record = 0;
    if (mvn::CutRecord(rest, record) != mvn::Cut::kRecord) break;
    Require(record >= mvn::kHeaderSize && record <= rest.size());
    rest = rest.subspan(record);
  }
  return 0;
}
