#include "daemon/source/rigs/slimevr_hid.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "daemon/source/rigs/tracker_rig.h"
#include "proto/rigs/slimevr/hid.h"

namespace styled::source {
namespace {

using runtime::Counter;

constexpr std::size_t kMaxReceivers = 16;

// One receiver since it was opened, with its registered trackers by number.
struct Receiver {
  struct Tracker {
    std::optional<std::uint64_t> address;
    int part = TrackerRig::kUnassigned;
  };
  std::uint64_t peer = 0;
  std::int64_t heard_ns = 0;
  std::array<Tracker, 256> trackers;
};

class SlimeVrHid final : public Translator {
 public:
  explicit SlimeVrHid(const config::Source& config) : rig_(config) {
    receivers_.reserve(kMaxReceivers);
  }

  void Handle(std::span<const std::byte> bytes, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    if (slimevr::DecodeReport(bytes, report_) != slimevr::ReportResult::kOk || report_.count == 0) {
      return out.Refuse(Counter::kUsbBadReports);
    }
    if (report_.unknown > 0) out.Refuse(Counter::kSourceIgnored);
    Receiver& receiver = ReceiverOf(peer);
    receiver.heard_ns = now_ns;
    for (const auto& record : std::span(report_.records).first(report_.count)) {
      HandleRecord(record, receiver.trackers[record.tracker], now_ns, out);
    }
  }

  void Tick(std::int64_t now_ns, Outbox& out) override { rig_.Tick(now_ns, out); }
  std::int64_t NextDeadline_ns() const override { return rig_.NextDeadline_ns(); }
  bool has_sensors() const override { return true; }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return rig_.Calibrate(what, now_ns);
  }

 private:
  // If all places are in use, the receiver that was silent for longest is removed.
  Receiver& ReceiverOf(const Peer& peer) {
    const auto found = std::ranges::find(receivers_, peer.id, &Receiver::peer);
    if (found != receivers_.end()) return *found;
    Receiver& fresh = receivers_.size() < kMaxReceivers
                          ? receivers_.emplace_back()  // reserved
                          : *std::ranges::min_element(receivers_, {}, &Receiver::heard_ns);
    fresh = Receiver();
    fresh.peer = peer.id;
    return fresh;
  }

  void HandleRecord(const slimevr::Record& record, Receiver::Tracker& tracker, std::int64_t now_ns,
                    Outbox& out) {
    if (const auto* registration = std::get_if<slimevr::Registration>(&record.body)) {
      if (tracker.address == registration->address) return;
      tracker = {registration->address, rig_.PartOf({registration->address, 0}, 0, now_ns, out)};
      return;
    }
    const slimevr::Orientation* orientation = slimevr::OrientationOf(record);
    if (orientation == nullptr) return;
    if (tracker.part == TrackerRig::kUnassigned) return out.Refuse(Counter::kSourceIgnored);
    rig_.Accept(body::Joint(tracker.part), *orientation, now_ns);
  }

  TrackerRig rig_;
  std::vector<Receiver> receivers_;
  slimevr::Report report_;
};

}  // namespace

std::unique_ptr<Translator> MakeSlimeVrHid(const config::Source& config) {
  return std::make_unique<SlimeVrHid>(config);
}

}  // namespace styled::source
