#include "proto/rigs/slimevr/hid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "proto/rigs/result_name.h"

namespace styled::slimevr {
namespace {

using Bytes = std::span<const std::byte, kRecordSize>;
using Out = std::span<std::byte, kRecordSize>;

constexpr float kQ15 = 32768, kQ10 = 1024, kQ7 = 128;
constexpr int kBatteryTold = 0x80;

std::uint8_t U8(Bytes bytes, std::size_t at) noexcept {
  return std::to_integer<std::uint8_t>(bytes[at]);
}

template <typename T>
T Little(Bytes bytes, std::size_t at, std::size_t size = sizeof(T)) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= std::uint64_t{U8(bytes, at + i)} << (8 * i);
  }
  return static_cast<T>(value);
}

void Put(Out out, std::size_t at, std::uint64_t value, std::size_t size = 1) noexcept {
  for (std::size_t i = 0; i < size; ++i) {
    out[at + i] = static_cast<std::byte>((value >> (8 * i)) & 0xFFU);
  }
}

std::array<float, 3> Fixed3(Bytes bytes, std::size_t at, float one) noexcept {
  std::array<float, 3> v;
  for (std::size_t i = 0; i < 3; ++i) {
    v[i] = static_cast<float>(Little<std::int16_t>(bytes, at + 2 * i)) / one;
  }
  return v;
}

void PutFixed(Out out, std::size_t at, std::span<const float> values, float one) noexcept {
  for (const float value : values) {
    const float scaled = std::isfinite(value) ? std::round(value * one) : 0.0F;
    const auto fixed = static_cast<std::int16_t>(std::clamp(scaled, -32768.0F, 32767.0F));
    Put(out, at, static_cast<std::uint16_t>(fixed), 2);
    at += 2;
  }
}

Orientation Full(Bytes bytes) noexcept {
  std::array<float, 4> q;
  for (std::size_t i = 0; i < 4; ++i) {
    q[i] = static_cast<float>(Little<std::int16_t>(bytes, 2 + 2 * i)) / kQ15;
  }
  return MakeOrientation(q[0], q[1], q[2], q[3]);
}

Motion Packed(Bytes bytes) noexcept {
  return {{Unpack(Little<std::uint32_t>(bytes, 5)), true}, Fixed3(bytes, 9, kQ7)};
}

void PutPacked(Out out, const Motion& motion) noexcept {
  Put(out, 5, Pack(motion.orientation.rotation), 4);
  PutFixed(out, 9, motion.acceleration_mps2, kQ7);
}

Battery ReadBattery(Bytes bytes) noexcept {
  Battery battery;
  const int level = U8(bytes, 2);
  if ((level & kBatteryTold) != 0) battery.percent = level & ~kBatteryTold;
  battery.volts = static_cast<float>(U8(bytes, 3) + 245) / 100.0F;
  const int temperature = U8(bytes, 4);
  if (temperature != 0) battery.temperature_c = static_cast<float>(temperature) / 2.0F - 39.0F;
  return battery;
}

void PutBattery(Out out, const Battery& battery) noexcept {
  if (battery.percent >= 0) {
    Put(out, 2, static_cast<std::uint64_t>(kBatteryTold | std::min(battery.percent, 127)));
  }
  const float volts = std::round(battery.volts * 100.0F) - 245.0F;
  Put(out, 3, static_cast<std::uint64_t>(std::clamp(volts, 0.0F, 255.0F)));
  if (!std::isnan(battery.temperature_c)) {
    const float temperature = std::round((battery.temperature_c + 39.0F) * 2.0F);
    Put(out, 4, static_cast<std::uint64_t>(std::clamp(temperature, 1.0F, 255.0F)));
  }
}

Info ReadInfo(Bytes bytes) noexcept {
  Info info;
  info.battery = ReadBattery(bytes);
  info.board = U8(bytes, 5);
  info.mcu = U8(bytes, 6);
  info.imu = U8(bytes, 8);
  info.magnetometer = U8(bytes, 9);
  const unsigned date = Little<std::uint16_t>(bytes, 10);
  info.firmware_year = static_cast<std::uint16_t>(2020U + (date >> 9U));
  info.firmware_month = static_cast<std::uint8_t>((date >> 5U) & 15U);
  info.firmware_day = static_cast<std::uint8_t>(date & 31U);
  info.firmware_version = {U8(bytes, 12), U8(bytes, 13), U8(bytes, 14)};
  info.signal = U8(bytes, 15);
  return info;
}

// Each overload writes its type and its fields into 16 zeros.
struct Writer {
  Out out;

  void operator()(const Registration& r) const noexcept {
    Put(out, 0, 255);
    Put(out, 2, r.address, 6);
  }
  void operator()(const Info& r) const noexcept {
    PutBattery(out, r.battery);
    Put(out, 5, r.board);
    Put(out, 6, r.mcu);
    Put(out, 8, r.imu);
    Put(out, 9, r.magnetometer);
    const unsigned year = (r.firmware_year - 2020U) & 127U;
    Put(out, 10, year << 9U | (r.firmware_month & 15U) << 5U | (r.firmware_day & 31U), 2);
    for (std::size_t i = 0; i < 3; ++i) Put(out, 12 + i, r.firmware_version[i]);
    Put(out, 15, r.signal);
  }
  void operator()(const Motion& r) const noexcept {
    Put(out, 0, 1);
    PutFixed(out, 2, r.orientation.rotation, kQ15);
    PutFixed(out, 10, r.acceleration_mps2, kQ7);
  }
  void operator()(const MotionAndBattery& r) const noexcept {
    Put(out, 0, 2);
    PutBattery(out, r.battery);
    PutPacked(out, r.motion);
    Put(out, 15, r.signal);
  }
  void operator()(const Status& r) const noexcept {
    Put(out, 0, 3);
    std::size_t at = 2;
    for (const std::uint8_t value :
         {r.server_status, r.raw_status, r.received, r.lost, r.windows_hit, r.windows_missed}) {
      Put(out, at++, value);
    }
    Put(out, 15, r.signal);
  }
  void operator()(const MotionAndMagnetometer& r) const noexcept {
    Put(out, 0, 4);
    PutFixed(out, 2, r.orientation.rotation, kQ15);
    PutFixed(out, 10, r.magnetometer_gauss, kQ10);
  }
  void operator()(const Runtime& r) const noexcept {
    Put(out, 0, 5);
    Put(out, 2, static_cast<std::uint64_t>(r.remaining_us), 8);
    Put(out, 15, r.signal);
  }
  void operator()(const Button& r) const noexcept {
    Put(out, 0, 6);
    PutButton(r);
  }
  void operator()(const MotionAndButton& r) const noexcept {
    Put(out, 0, 7);
    PutPacked(out, r.motion);
    PutButton(r.button);
  }
  void PutButton(const Button& r) const noexcept {
    Put(out, 2, r.button);
    Put(out, 3, r.sleep_ms, 2);
    Put(out, 15, r.signal);
  }
};

Button ReadButton(Bytes bytes) noexcept {
  return {U8(bytes, 2), Little<std::uint16_t>(bytes, 3), U8(bytes, 15)};
}

// Returns false for an unknown type.
bool ReadRecord(Bytes bytes, Record& record) noexcept {
  record.tracker = U8(bytes, 1);
  switch (U8(bytes, 0)) {
    case 0:
      record.body = ReadInfo(bytes);
      return true;
    case 1:
      record.body = Motion{Full(bytes), Fixed3(bytes, 10, kQ7)};
      return true;
    case 2:
      record.body = MotionAndBattery{Packed(bytes), ReadBattery(bytes), U8(bytes, 15)};
      return true;
    case 3:
      record.body = Status{U8(bytes, 2), U8(bytes, 3), U8(bytes, 4), U8(bytes, 5),
                           U8(bytes, 6), U8(bytes, 7), U8(bytes, 15)};
      return true;
    case 4:
      record.body = MotionAndMagnetometer{Full(bytes), Fixed3(bytes, 10, kQ10)};
      return true;
    case 5:
      record.body = Runtime{Little<std::int64_t>(bytes, 2), U8(bytes, 15)};
      return true;
    case 6:
      record.body = ReadButton(bytes);
      return true;
    case 7:
      record.body = MotionAndButton{Packed(bytes), ReadButton(bytes)};
      return true;
    case 255:
      record.body = Registration{Little<std::uint64_t>(bytes, 2, 6)};
      return true;
    default:
      return false;
  }
}

}  // namespace

const Orientation* OrientationOf(const Record& record) noexcept {
  if (const auto* r = std::get_if<Motion>(&record.body)) return &r->orientation;
  if (const auto* r = std::get_if<MotionAndBattery>(&record.body)) return &r->motion.orientation;
  if (const auto* r = std::get_if<MotionAndMagnetometer>(&record.body)) return &r->orientation;
  if (const auto* r = std::get_if<MotionAndButton>(&record.body)) return &r->motion.orientation;
  return nullptr;
}

std::string_view Name(ReportResult result) noexcept {
  return rigs::ResultName(result, {"ok", "empty", "ragged", "too_long"});
}

ReportResult DecodeReport(std::span<const std::byte> bytes, Report& report) noexcept {
  if (bytes.empty()) return ReportResult::kEmpty;
  if (bytes.size() % kRecordSize != 0) return ReportResult::kRagged;
  if (bytes.size() > kReportSize) return ReportResult::kTooLong;
  report.count = report.unknown = 0;
  for (; !bytes.empty(); bytes = bytes.subspan(kRecordSize)) {
    if (ReadRecord(bytes.first<kRecordSize>(), report.records[report.count])) {
      ++report.count;
    } else {
      ++report.unknown;
    }
  }
  return ReportResult::kOk;
}

void EncodeRecord(const Record& record, std::span<std::byte, kRecordSize> out) noexcept {
  std::ranges::fill(out, std::byte{0});
  std::visit(Writer{out}, record.body);
  Put(out, 1, record.tracker);
}

// The exponential map of M. Reynolds, "Quaternion quantization", part 1 (2017), as in firmware and
// server. The small constant only avoids a division by zero.
std::array<float, 4> Unpack(std::uint32_t packed) noexcept {
  const std::array<float, 3> v{static_cast<float>(packed & 1023U) / 512.0F - 1.0F,
                               static_cast<float>((packed >> 10U) & 2047U) / 1024.0F - 1.0F,
                               static_cast<float>((packed >> 21U) & 2047U) / 1024.0F - 1.0F};
  const float d = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  const float inverse_length = 1.0F / std::sqrt(d + 1e-6F);
  const float half_angle = std::numbers::pi_v<float> / 2 * d * inverse_length;
  const float k = std::sin(half_angle) * inverse_length;
  return MakeOrientation(k * v[0], k * v[1], k * v[2], std::cos(half_angle)).rotation;
}

std::uint32_t Pack(const std::array<float, 4>& rotation) noexcept {
  const Orientation unit = MakeOrientation(rotation[0], rotation[1], rotation[2], rotation[3]);
  const auto& [x, y, z, w] = unit.rotation;
  const float sine = std::sqrt(x * x + y * y + z * z);
  const float sign = w < 0 ? -1.0F : 1.0F;  // the shorter way round
  // The inverse of Unpack: axis * angle / pi, where angle = 2 atan2(sine, w).
  const float scale = 2 / std::numbers::pi_v<float> * std::atan2(sine, std::abs(w)) *
                      (sine > 0 ? sign / sine : 0.0F);
  const auto raw = [scale](float value, std::uint32_t steps) {
    const float scaled = std::round((value * scale + 1.0F) / 2.0F * static_cast<float>(steps));
    return static_cast<std::uint32_t>(std::clamp(scaled, 0.0F, static_cast<float>(steps - 1)));
  };
  return raw(x, 1024) | raw(y, 2048) << 10U | raw(z, 2048) << 21U;
}

Orientation MakeOrientation(float x, float y, float z, float w) noexcept {
  const float norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(norm > 1e-3F) || !std::isfinite(norm)) return {{0, 0, 0, 1}, false};
  return {{x / norm, y / norm, z / norm, w / norm}, true};
}

}  // namespace styled::slimevr
