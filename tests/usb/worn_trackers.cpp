#include "tests/usb/worn_trackers.h"

#include <algorithm>
#include <cstdio>
#include <variant>

#include "proto/rigs/slimevr/udp.h"
#include "sim/rigs/slimevr.h"

namespace styled::support {
namespace {

constexpr double kRate_hz = 100;
constexpr std::array<const char*, WornTrackers::kTrackers> kParts{
    "hips",          "chest",         "head",         "leftUpperArm", "leftLowerArm",
    "rightUpperArm", "rightLowerArm", "leftUpperLeg", "leftLowerLeg", "leftFoot",
    "rightUpperLeg", "rightLowerLeg", "rightFoot"};

}  // namespace

WornTrackers::WornTrackers(std::uint64_t first_address) : first_(first_address) {
  // They play at once: the test triggers the daemon's calibration.
  rig_ = std::move(rigs::MakeSlimeVr({{"sim"}, kRate_hz, 1, {"no-reset"}}).value());
}

std::string WornTrackers::Config() const {
  std::string line = "trackers = {";
  for (int i = 0; i < kTrackers; ++i) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%s \"%012llX\" = \"%s\"", i == 0 ? "" : ",",
                  static_cast<unsigned long long>(first_) + static_cast<unsigned long long>(i),
                  kParts[static_cast<std::size_t>(i)]);
    line += text.data();
  }
  return line + " }\n";
}

slimevr::Record WornTrackers::Registration() {
  const auto number = static_cast<std::uint8_t>(next_registration_);
  next_registration_ = (next_registration_ + 1) % kTrackers;
  return {number, slimevr::Registration{first_ + number}};
}

WornTrackers::Report WornTrackers::KeepAlive() {
  Report report;
  for (std::size_t i = 0; i < slimevr::kRecordsPerReport; ++i) {
    slimevr::EncodeRecord(
        Registration(),
        std::span(report).subspan(i * slimevr::kRecordSize).first<slimevr::kRecordSize>());
  }
  return report;
}

std::vector<WornTrackers::Report> WornTrackers::Next(const body::Pose& pose) {
  std::vector<slimevr::Record> records;
  bool greets = false;
  const auto take = [&](std::span<const std::byte> bytes) {
    slimevr::Datagram datagram;
    if (slimevr::Decode(bytes, datagram) != slimevr::UdpResult::kOk) return;
    for (const auto& packet : std::span(datagram.packets).first(datagram.count)) {
      greets = greets || std::holds_alternative<slimevr::Handshake>(packet);
      const auto* rotation = std::get_if<slimevr::Rotation>(&packet);
      if (rotation == nullptr) continue;
      records.push_back({rotation->sensor, slimevr::Motion{rotation->orientation, {}}});
    }
  };
  // The stand-in seeks a server first.
  for (int i = 0; records.empty() && i < 2; ++i) {
    rig_->Encode({frame_, static_cast<double>(frame_) / kRate_hz, {&pose, 1}}, take);
    ++frame_;
    if (!greets) continue;
    std::array<std::byte, slimevr::kMaxAnswerSize> answer;
    const auto size = slimevr::EncodeAnswer(slimevr::Greeting{}, answer);
    rig_->Receive(std::span(answer).first(size), take);
  }
  // It gives up after 3 s of silence.
  std::array<std::byte, slimevr::kMaxAnswerSize> heartbeat;
  const auto size = slimevr::EncodeAnswer(slimevr::Heartbeat{}, heartbeat);
  rig_->Receive(std::span(heartbeat).first(size), [](std::span<const std::byte>) {});

  std::vector<Report> reports;
  for (std::size_t i = 0; i < records.size(); i += slimevr::kRecordsPerReport) {
    Report report = KeepAlive();
    const std::size_t count = std::min(slimevr::kRecordsPerReport, records.size() - i);
    for (std::size_t k = 0; k < count; ++k) {
      slimevr::EncodeRecord(
          records[i + k],
          std::span(report).subspan(k * slimevr::kRecordSize).first<slimevr::kRecordSize>());
    }
    reports.push_back(report);
  }
  return reports;
}

}  // namespace styled::support
