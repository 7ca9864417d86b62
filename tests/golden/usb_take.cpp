// styled_golden_usb KIND SECONDS: makes take.styrec in the working folder from a USB device that
// umockdev emulates. KIND usb: a vendor's device with our own records; slimevr-usb: a receiver.
// record.sh calls it.

#include <signal.h>

#include <cstdlib>
#include <iostream>

#include "model/synthetic/performer.h"
#include "sim/player/performer_motion.h"
#include "sim/player/stream.h"
#include "tests/golden/golden.h"
#include "tests/support/child.h"
#include "tests/support/clients.h"
#include "tests/support/rig.h"
#include "tests/usb/fake_usb.h"
#include "tests/usb/worn_trackers.h"

namespace styled::golden {
namespace {

using support::FakeDevice;

constexpr double kTakeRate_hz = 60;

class UsbLink final : public player::Link {
 public:
  explicit UsbLink(FakeDevice& device) : device_(device) {}
  Status Send(std::span<const std::byte> datagram) override {
    device_.Send(datagram);
    return Status::Ok();
  }

 private:
  FakeDevice& device_;
};

std::string Configuration(const std::string& kind, const support::WornTrackers& trackers) {
  return "[[source]]\nname = \"suit\"\ntype = \"" + kind + "\"\n" +
         (kind == "usb" ? std::string("usb_id = \"1234:0001\"\n") : trackers.Config()) +
         "[publish]\naddress = \"tcp://127.0.0.1:27001\"\n"
         "[control]\naddress = \"tcp://127.0.0.1:27002\"\n"
         "[performers]\nbacklog_ms = 10000\n[record]\nfile = \"take.styrec\"\n";
}

int RecordTake(const std::string& kind, double seconds) {
  if (!support::FakeUsb::Available()) {
    std::cerr << "styled_golden_usb: no umockdev\n";
    return 1;
  }
  support::FakeUsb usb;
  const bool vendor = kind == "usb";
  FakeDevice device(usb, vendor ? FakeDevice::Kind::kVendor : FakeDevice::Kind::kReceiver,
                    vendor ? 0x1234 : 0x1209, vendor ? 0x0001 : 0x7690, "TAKE-1");
  device.Plug();
  support::WornTrackers trackers;
  support::WriteText("styled.toml", Configuration(kind, trackers));
  support::Child daemon({STYLED_BINARY, "--config", "styled.toml", "--ready-file", "ready.json"},
                        "styled.log");
  if (!device.WaitForTransfers(vendor ? 4 : 8)) {
    std::cerr << support::ReadText("styled.log");
    return 1;
  }
  support::ControlClient control("tcp://127.0.0.1:27002");
  const auto script = synthetic::ParseScript(kScript).value();
  UsbLink link(device);
  player::Stream stream({"sim", kTakeRate_hz, [] { return std::uint64_t{1}; }},
                        std::make_unique<player::PerformerMotion>(
                            synthetic::Vary(1, 0, script), synthetic::Proportions(), kTakeRate_hz),
                        faults::Faults({}));
  synthetic::Performer performer(synthetic::Vary(1, 0, script));
  support::Paced(static_cast<int>(seconds * kTakeRate_hz), kTakeRate_hz, [&](int i) {
    if (i == static_cast<int>((seconds - 1) * kTakeRate_hz)) {
      (void)control.SetStyle("*", "elderly", 1, 200);
    }
    if (vendor) return (void)stream.Tick(link);
    body::Pose pose;
    performer.Pose(i / kTakeRate_hz, pose);
    for (const auto& report : trackers.Next(pose)) device.Send(report);
  });
  support::Sleep(0.1);
  daemon.Signal(SIGTERM);
  return daemon.Wait(10).value_or(1);
}

}  // namespace
}  // namespace styled::golden

int main(int argc, char** argv) {
  styled::support::FakeUsb::Preload(argv);
  if (argc != 3) {
    std::cerr << "usage: styled_golden_usb KIND SECONDS\n";
    return 2;
  }
  return styled::golden::RecordTake(argv[1], std::atof(argv[2]));
}
