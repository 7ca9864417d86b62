#include "sim/rigs/ifacialmocap.h"

#include <algorithm>
#include <array>
#include <string>

#include "proto/rigs/ifacialmocap/ifacialmocap.h"
#include "sim/rigs/synthetic_face.h"

namespace styled::rigs {
namespace {

class IFacialMocap final : public Rig {
 public:
  explicit IFacialMocap(const Options& options)
      : old_(HasQuirk(options, "v1")), state_(HasQuirk(options, "state")) {}

  void Encode(const Frame& frame, const Send& send) override {
    if (!started_) return;
    ifacialmocap::Frame out;
    out.shapes = SyntheticFace(frame.time_s);
    constexpr float kDegrees = 57.29578F;
    const SyntheticHead head = HeadOfSyntheticFace(frame.time_s);
    out.head = {kDegrees * head.down_rad,
                kDegrees * head.left_rad,
                kDegrees * head.to_right_shoulder_rad,
                0,
                0,
                -0.5F};
    std::array<char, ifacialmocap::kMaxSize> text;
    std::string whole = state_ ? "trackingStatus&1|" : "";
    whole.append(text.data(), ifacialmocap::Encode(out, version_, text));
    send(std::as_bytes(std::span(whole)));
  }
  void Restart() override { started_ = false; }
  void Receive(std::span<const std::byte> datagram, const Send& /*send*/) override {
    const std::string_view text(reinterpret_cast<const char*>(datagram.data()), datagram.size());
    constexpr std::string_view kNewer = "|sendDataVersion=v2";
    const std::string_view first =
        ifacialmocap::kStart.substr(0, ifacialmocap::kStart.size() - kNewer.size());
    if (!text.starts_with(first)) return;
    started_ = true;
    version_ = text.ends_with(kNewer) && !old_ ? 2 : 1;
  }
  std::string default_address() const override { return "udp://127.0.0.1:49983"; }
  bool is_server() const override { return true; }
  // A single start text is enough, and the newest one wins.
  player::Audience audience() const override { return player::Audience::kNewest; }

 private:
  bool old_, state_;
  bool started_ = false;
  int version_ = 1;
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeIFacialMocap(const Options& options) {
  const Status status = CheckOptions("ifacialmocap", options, 1, {"v1", "state"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<IFacialMocap>(options));
}

}  // namespace styled::rigs
