#include "sim/rigs/vrchat.h"

#include <array>

#include "proto/rigs/vrchat/vrchat.h"
#include "sim/rigs/worn_devices.h"

namespace styled::rigs {
namespace {

// Indices beyond the trackers' mean VRChat's own devices: 9 + vrchat::System.
constexpr int kSystem = vrchat::kTrackers + 1;

std::vector<WornDevices::Place> Places(bool system) {
  std::vector<WornDevices::Place> places{{1, body::kHips},          {2, body::kLeftFoot},
                                         {3, body::kRightFoot},     {4, body::kLeftUpperLeg},
                                         {5, body::kRightUpperLeg}, {6, body::kChest},
                                         {7, body::kLeftUpperArm},  {8, body::kRightUpperArm}};
  if (system) {
    places.insert(places.end(), {{kSystem, body::kHead, true},
                                 {kSystem + 1, body::kLeftHand},
                                 {kSystem + 2, body::kRightHand}});
  } else {
    places.push_back({vrchat::kHead, body::kHead});
  }
  return places;
}

class VrChat final : public Rig {
 public:
  explicit VrChat(const Options& options)
      : single_(HasQuirk(options, "single")),
        devices_(options, Places(HasQuirk(options, "vrsystem"))) {}

  void Encode(const Frame& frame, const Send& send) override {
    messages_.clear();
    for (const auto& reading : devices_.Read(frame)) {
      const std::array<float, 3> at{reading.position_m.x(), reading.position_m.y(),
                                    reading.position_m.z()};
      const auto& q = reading.rotation;
      const auto euler = vrchat::EulerOf({q.x(), q.y(), q.z(), q.w()});
      if (reading.index >= kSystem) {
        messages_.emplace_back(
            vrchat::SystemPose{static_cast<vrchat::System>(reading.index - kSystem), at, euler});
        continue;
      }
      messages_.emplace_back(vrchat::Tracker{reading.index, false, at});
      const bool head = reading.index == vrchat::kHead;
      if (head && frame.index > 0) continue;
      messages_.emplace_back(vrchat::Tracker{reading.index, true,
                                             head ? std::array<float, 3>{0, euler[1], 0} : euler});
    }
    SendAll(send);
  }

  std::string default_address() const override { return "udp://127.0.0.1:9000"; }

 private:
  void SendAll(const Send& send) {
    const auto put = [](const vrchat::Message& message, vrchat::osc::Writer& writer) {
      if (const auto* tracker = std::get_if<vrchat::Tracker>(&message)) Put(*tracker, writer);
      if (const auto* pose = std::get_if<vrchat::SystemPose>(&message)) Put(*pose, writer);
    };
    if (single_) {
      for (const auto& message : messages_) {
        vrchat::osc::Writer writer(buffer_);
        put(message, writer);
        send(std::span(buffer_).first(writer.size()));
      }
      return;
    }
    if (messages_.empty()) return;
    vrchat::osc::Writer writer(buffer_);
    writer.BeginBundle();
    for (const auto& message : messages_) put(message, writer);
    writer.EndBundle();
    send(std::span(buffer_).first(writer.size()));
  }

  bool single_;
  WornDevices devices_;
  std::vector<vrchat::Message> messages_;
  std::array<std::byte, 2048> buffer_;
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeVrChat(const Options& options) {
  const Status status =
      CheckOptions("vrchat", options, 1,
                   {"single", "vrsystem", "mounted", "t-pose", "vanish", "shuffled", "hips",
                    "leftFoot", "rightFoot", "leftUpperLeg", "rightUpperLeg", "chest",
                    "leftUpperArm", "rightUpperArm", "head", "leftHand", "rightHand"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<VrChat>(options));
}

}  // namespace styled::rigs
