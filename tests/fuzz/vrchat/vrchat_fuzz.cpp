// Fuzzes styled::vrchat: the input as one OSC datagram, read, decoded, written again. Seeds: the
// unit test's case table.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "proto/rigs/vrchat/vrchat.h"

namespace {

namespace vrchat = styled::vrchat;
namespace osc = styled::vrchat::osc;

void Require(bool condition) {
  if (!condition) std::abort();
}

template <typename Floats>
bool SameBits(const Floats& a, const Floats& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i])) return false;
  }
  return true;
}

// Any finite angles are a unit quaternion, and have angles of the same rotation.
void CheckAngles(const std::array<float, 3>& euler) {
  for (const float angle : euler) {
    if (!(std::abs(angle) < 1e6F)) return;
  }
  const auto q = vrchat::QuaternionOf(euler);
  const auto again = vrchat::QuaternionOf(vrchat::EulerOf(q));
  float norm = 0, dot = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    norm += q[i] * q[i];
    dot += q[i] * again[i];
  }
  Require(std::abs(norm - 1) < 1e-4F);
  Require(std::abs(dot) > 0.9999F);
}

void CheckMessage(const osc::Message& raw) {
  vrchat::Message message;
  if (Decode(raw, message) != vrchat::DecodeResult::kOk) return;
  std::vector<std::byte> buffer(128);
  osc::Writer writer(buffer);
  if (const auto* tracker = std::get_if<vrchat::Tracker>(&message)) {
    Require(tracker->index >= 0 && tracker->index <= vrchat::kTrackers);
    if (tracker->is_rotation) CheckAngles(tracker->values);
    Put(*tracker, writer);
  } else {
    CheckAngles(std::get<vrchat::SystemPose>(message).euler);
    Put(std::get<vrchat::SystemPose>(message), writer);
  }
  Require(writer.ok());
  osc::Reader reader({buffer.data(), writer.size()});
  osc::Message again_raw;
  Require(reader.Next(again_raw) == osc::Reader::Step::kMessage);
  Require(again_raw.address == raw.address);
  vrchat::Message again;
  Require(Decode(again_raw, again) == vrchat::DecodeResult::kOk);
  if (const auto* tracker = std::get_if<vrchat::Tracker>(&message)) {
    Require(SameBits(tracker->values, std::get<vrchat::Tracker>(again).values));
  } else {
    const auto& a = std::get<vrchat::SystemPose>(message);
    const auto& b = std::get<vrchat::SystemPose>(again);
    Require(a.device == b.device && SameBits(a.position, b.position) && SameBits(a.euler, b.euler));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  osc::Reader reader(std::as_bytes(std::span(data, size)));
  osc::Message message;
  while (reader.Next(message) == osc::Reader::Step::kMessage) CheckMessage(message);
  return 0;
}
