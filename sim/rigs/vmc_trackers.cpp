#include "sim/rigs/vmc_trackers.h"

#include <array>

#include "proto/rigs/vmc/device.h"
#include "sim/rigs/worn_devices.h"

namespace styled::rigs {
namespace {

using Kind = vmc::Device::Kind;

const std::vector<WornDevices::Place> kTrackerPlaces{
    {0, body::kHead, true},   {1, body::kLeftHand},     {1, body::kRightHand},
    {2, body::kHips},         {2, body::kChest},        {2, body::kLeftFoot},
    {2, body::kRightFoot},    {2, body::kLeftUpperLeg}, {2, body::kRightUpperLeg},
    {2, body::kLeftUpperArm}, {2, body::kRightUpperArm}};

class VmcTrackers final : public Rig {
 public:
  explicit VmcTrackers(const Options& options)
      : single_(HasQuirk(options, "single")),
        local_(HasQuirk(options, "local")),
        devices_(options, kTrackerPlaces) {}

  void Encode(const Frame& frame, const Send& send) override {
    Begin(send);
    for (const auto& reading : devices_.Read(frame)) {
      const auto& p = reading.position_m;
      const auto& q = reading.rotation;
      const std::string serial = VmcSerial(reading.joint);
      const vmc::Device device{static_cast<Kind>(reading.index),
                               serial,
                               {{p.x(), p.y(), p.z()}, {q.x(), q.y(), q.z(), q.w()}}};
      One([&] { Put(device, writer_); });
      if (local_) One([&] { PutLocal(serial); });
    }
    if (local_) One([this] { PutButton(); });
    One([&] { Put(vmc::Time{static_cast<float>(frame.time_s)}, writer_); });
    End();
  }

  std::string default_address() const override { return "udp://127.0.0.1:39540"; }

 private:
  void Begin(const Send& send) {
    send_ = send;
    writer_ = vmc::osc::Writer(buffer_);
    if (!single_) writer_.BeginBundle();
  }
  // A message: a datagram of its own, or one more of the bundle.
  template <typename PutIt>
  void One(const PutIt& put) {
    if (single_) writer_ = vmc::osc::Writer(buffer_);
    put();
    if (single_) send_(std::span(buffer_).first(writer_.size()));
  }
  void End() {
    if (single_) return;
    writer_.EndBundle();
    send_(std::span(buffer_).first(writer_.size()));
  }
  void PutLocal(const std::string& serial) {
    writer_.BeginMessage("/VMC/Ext/Tra/Pos/Local", "sfffffff");
    writer_.Text(serial);
    for (int i = 0; i < 7; ++i) writer_.Float(9);
    writer_.EndMessage();
  }
  void PutButton() {
    writer_.BeginMessage("/VMC/Ext/Con", "isiiifff");
    writer_.Int(1);
    writer_.Text("ClickTrigger");
    for (int i = 0; i < 3; ++i) writer_.Int(1);
    for (int i = 0; i < 3; ++i) writer_.Float(0);
    writer_.EndMessage();
  }

  bool single_, local_;
  WornDevices devices_;
  std::array<std::byte, 4096> buffer_;
  vmc::osc::Writer writer_{buffer_};
  Send send_;
};

}  // namespace

std::string VmcSerial(body::Joint joint) {
  if (joint == body::kHead) return "HMD-0";
  return "LHR-" + std::string(body::kHumanoid[static_cast<std::size_t>(joint)].name);
}

Result<std::unique_ptr<Rig>> MakeVmcTrackers(const Options& options) {
  const Status status =
      CheckOptions("vmc with trackers", options, 1,
                   {"trackers", "single", "local", "mounted", "t-pose", "vanish", "shuffled",
                    "head", "leftHand", "rightHand", "hips", "chest", "leftFoot", "rightFoot",
                    "leftUpperLeg", "rightUpperLeg", "leftUpperArm", "rightUpperArm"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<VmcTrackers>(options));
}

}  // namespace styled::rigs
