#include "sim/rigs/live_link_face.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "proto/rigs/livelinkface/live_link_face.h"
#include "sim/rigs/synthetic_face.h"

namespace styled::rigs {
namespace {

// The app counts from a start of its own, as a recording of it shows: 24 h 53 min at 60 Hz.
constexpr std::int32_t kFirstFaceFrame = 5'375'735;

class LiveLinkFace final : public Rig {
 public:
  explicit LiveLinkFace(const Options& options)
      : name_(options.performers.front()),
        rate_(static_cast<std::int32_t>(std::lround(options.rate_hz))),
        loses_(!options.quirks.empty()) {}

  void Encode(const Frame& frame, const Send& send) override {
    live_link_face::Frame out;
    out.device = "5717D000-0000-4000-8000-000000000001";
    out.subject = name_;
    out.frame = kFirstFaceFrame + static_cast<std::int32_t>(frame.index);
    out.subframe = 0.125F;
    out.rate = std::max(rate_, 1);
    out.has_face = !loses_ || std::fmod(frame.time_s, 10.0) < 8;
    const auto face = SyntheticFace(frame.time_s);
    std::copy(face.begin(), face.end(), out.values.begin());
    const SyntheticHead head = HeadOfSyntheticFace(frame.time_s);
    const std::array<float, 3> angles{head.left_rad, -head.down_rad, -head.to_right_shoulder_rad};
    std::copy(angles.begin(), angles.end(), out.values.begin() + arkit::kShapes);
    std::array<std::byte, live_link_face::kMaxSize> bytes;
    send(std::span(bytes).first(live_link_face::Encode(out, bytes)));
  }
  std::string default_address() const override { return "udp://127.0.0.1:11111"; }

 private:
  std::string name_;
  std::int32_t rate_;
  bool loses_;
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeLiveLinkFace(const Options& options) {
  const Status status = CheckOptions("livelinkface", options, 1, {"lost"});
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<LiveLinkFace>(options));
}

}  // namespace styled::rigs
