#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/body/pose.h"
#include "proto/rigs/slimevr/hid.h"
#include "sim/rigs/rig.h"

namespace styled::support {

// The reports of a SlimeVR receiver about the thirteen trackers that a performer wears: the
// stand-in of sim/rigs/slimevr.h, its sensors' packets put into HID records. Each tracker's address
// is `first` and its number.
class WornTrackers {
 public:
  explicit WornTrackers(std::uint64_t first_address = 0x025356000100);

  static constexpr int kTrackers = 13;
  // The line `trackers = { ... }` of the daemon's source.
  std::string Config() const;

  using Report = std::array<std::byte, slimevr::kReportSize>;
  // The reports of the next instant, 100 a second: a record of each tracker, and registrations in
  // the slots that are left.
  std::vector<Report> Next(const body::Pose& pose);
  // A report of four registrations, round robin: what a receiver sends when it has nothing to say.
  Report KeepAlive();

 private:
  slimevr::Record Registration();

  std::uint64_t first_;
  std::unique_ptr<rigs::Rig> rig_;
  std::uint64_t frame_ = 0;
  int next_registration_ = 0;
};

}  // namespace styled::support
