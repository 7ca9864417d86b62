#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <variant>

#include "model/base/realtime.h"

// Input reports of the SlimeVR receiver (USB 1209:7690) and of a tracker on a cable (1209:7692): up
// to four little-endian records of 16 bytes. Records of different trackers are in no order of time,
// lost records leave no trace, empty slots are filled with registrations. Facts from SlimeVR's nRF
// firmware (which writes them) and its server's HIDCommon.kt (which reads them), both MIT; comments
// below note where they disagree. Pure functions, any thread, no allocation. Pinned by
// tests/unit/slimevr, fuzzed by tests/fuzz/slimevr.
namespace styled::slimevr {

inline constexpr std::size_t kRecordSize = 16;
inline constexpr std::size_t kRecordsPerReport = 4;
inline constexpr std::size_t kReportSize = kRecordSize * kRecordsPerReport;

// World (right-handed, +Z up, any heading) from sensor (lying face up: +X its right, +Z out of its
// face; worn upright: +Y up). x, y, z, w.
struct Orientation {
  std::array<float, 4> rotation{0, 0, 0, 1};  // unit length
  // False: the sent rotation was zero or not finite; `rotation` is identity then.
  bool usable = true;
};

// Each of these is one record. Signal strength is measured by the receiver; 0 if a tracker sends it
// itself.
struct Registration {         // type 255: binds the number to the tracker
  std::uint64_t address = 0;  // 48 bits
};
struct Battery {
  int percent = -1;                                               // -1: not sent
  float volts = 2.45F;                                            // 2.45 .. 5.00
  float temperature_c = std::numeric_limits<float>::quiet_NaN();  // -38.5 .. 88.5; NaN: not sent
};
struct Info {  // type 0
  Battery battery;
  std::uint8_t board = 0, mcu = 0, imu = 0;
  std::uint8_t magnetometer = 0;  // 0 none, 1 off, 2 on
  std::uint16_t firmware_year = 2020;
  std::uint8_t firmware_month = 0, firmware_day = 0;
  std::array<std::uint8_t, 3> firmware_version{};
  std::uint8_t signal = 0;  // -dBm, as in all records below
};
struct Motion {  // type 1
  Orientation orientation;
  std::array<float, 3> acceleration_mps2{};  // in the sensor's frame; +-256, steps of 1/128
};
struct MotionAndBattery {  // type 2, orientation packed to 0.4 degrees
  Motion motion;
  Battery battery;
  std::uint8_t signal = 0;
};
struct Status {                    // type 3
  std::uint8_t server_status = 1;  // 0 disconnected, 1 ok, 2 busy, 3 error, 4 occluded, 5 timed out
  std::uint8_t raw_status = 0;
  std::uint8_t received = 0, lost = 0, windows_hit = 0, windows_missed = 0;
  std::uint8_t signal = 0;
};
struct MotionAndMagnetometer {  // type 4
  Orientation orientation;
  std::array<float, 3> magnetometer_gauss{};  // +-32, steps of 1/1024
};
struct Runtime {                  // type 5
  std::int64_t remaining_us = 0;  // -1 unknown, 0 charging
  std::uint8_t signal = 0;
};
struct Button {  // type 6
  std::uint8_t button = 0;
  // 0 none, 65535 never. Little-endian, as the firmware writes it; the server reads it big-endian.
  std::uint16_t sleep_ms = 0;
  std::uint8_t signal = 0;
};
struct MotionAndButton {  // type 7, orientation packed
  Motion motion;
  Button button;
};

struct Record {
  std::uint8_t tracker = 0;  // the receiver's number for it
  std::variant<Registration, Info, Motion, MotionAndBattery, Status, MotionAndMagnetometer, Runtime,
               Button, MotionAndButton>
      body;
};

// The orientation that a record carries, or null.
STYLED_REALTIME const Orientation* OrientationOf(const Record& record) noexcept;

struct Report {
  std::size_t count = 0;
  std::array<Record, kRecordsPerReport> records{};
  std::size_t unknown = 0;  // records of unlisted types, left out
};

enum class [[nodiscard]] ReportResult : std::uint8_t {
  kOk,
  kEmpty,
  kRagged,   // size not a multiple of 16 bytes
  kTooLong,  // more than four records
  kCount
};
std::string_view Name(ReportResult result) noexcept;

// Writes `report` only on kOk. Only the first `count` records are valid.
STYLED_REALTIME ReportResult DecodeReport(std::span<const std::byte> bytes,
                                          Report& report) noexcept;
// Encodes one record as the firmware does; values beyond a field's range are saturated.
void EncodeRecord(const Record& record, std::span<std::byte, kRecordSize> out) noexcept;

// Types 2 and 7: the rotation's axis times its angle / pi, with 10 bits for x and 11 for y and z.
// The encoder rounds to the nearest step, while the firmware truncates, so it may be one step
// higher.
STYLED_REALTIME std::array<float, 4> Unpack(std::uint32_t packed) noexcept;
std::uint32_t Pack(const std::array<float, 4>& rotation) noexcept;

// Normalizes to unit length; not `usable` if that is impossible.
STYLED_REALTIME Orientation MakeOrientation(float x, float y, float z, float w) noexcept;

}  // namespace styled::slimevr
