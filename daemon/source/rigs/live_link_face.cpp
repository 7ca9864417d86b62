#include "daemon/source/rigs/live_link_face.h"

#include <cmath>
#include <optional>
#include <span>
#include <string>

#include "daemon/runtime/clock.h"
#include "daemon/source/face_stream.h"
#include "daemon/source/rigs/face_body.h"
#include "proto/rigs/livelinkface/live_link_face.h"

namespace styled::source {
namespace {

using runtime::Counter;

constexpr std::int64_t kFaceTakeOver_ns = 2 * runtime::kSecond_ns;
// As in mocopi.cpp: a smaller step back means a late frame, unless so many occur in a row.
constexpr int kFaceOldFrames = 5;
constexpr std::size_t kYaw = arkit::kShapes, kPitch = kYaw + 1, kRoll = kYaw + 2;

class LiveLinkFace final : public Translator {
 public:
  explicit LiveLinkFace(const config::Source& config) : face_(config.expressions == "vrm") {
    if (config.FaceAlone()) body_.emplace(config);
  }

  void Handle(std::span<const std::byte> datagram, const Peer& /*peer*/, std::int64_t now_ns,
              Outbox& out) override {
    live_link_face::Frame frame;
    if (live_link_face::Decode(datagram, frame) != live_link_face::DecodeResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    if (!Admit(frame, now_ns, out)) return;
    if (!frame.has_face) return out.Refuse(Counter::kSourceIncomplete);
    const double seconds = (double{frame.subframe} + static_cast<double>(frame.frame)) *
                           frame.rate_divisor / frame.rate;
    const double time_ns = std::isfinite(seconds) && seconds > 0 ? seconds * 1e9 : 0.0;
    const auto shapes = std::span(frame.values).first<arkit::kShapes>();
    const Face& face = face_.Of(shapes);
    if (!body_) return stream_.Send(face, number_++, static_cast<std::uint64_t>(time_ns), out);
    body_->Send({.yaw_rad = frame.values[kYaw],
                 .pitch_rad = -frame.values[kPitch],
                 .roll_rad = -frame.values[kRoll],
                 .source_time_ns = static_cast<std::uint64_t>(time_ns),
                 .lost = lost_,
                 .now_ns = now_ns},
                shapes, face, out);
  }

  bool has_sensors() const override { return body_.has_value(); }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return body_ ? body_->Calibrate(what) : Translator::Calibrate(what, now_ns);
  }

 private:
  // Returns false for a phone other than the current one, and for an old frame.
  bool Admit(const live_link_face::Frame& frame, std::int64_t now_ns, Outbox& out) {
    if (frame.device != device_ || frame.subject != subject_) {
      if (any_ && now_ns - seen_ns_ < kFaceTakeOver_ns) {
        out.Refuse(Counter::kPipelineSecondSender);
        return false;
      }
      out.LeaveHotSection();
      device_ = frame.device;
      subject_ = frame.subject;
      Restart();
    }
    if (any_ && frame.frame <= frame_) {
      if (frame.frame == frame_) {
        seen_ns_ = now_ns;
        out.Refuse(Counter::kPipelineDuplicate);
        return false;
      }
      const double behind_s =
          (static_cast<double>(frame_) - frame.frame) * frame.rate_divisor / frame.rate;
      if (behind_s < 1 && ++behind_ < kFaceOldFrames) {
        out.Refuse(Counter::kPipelineReordered);
        return false;
      }
      Restart();
    }
    lost_ = any_ ? static_cast<std::uint64_t>(std::int64_t{frame.frame} - frame_ - 1) : 0;
    any_ = true;
    behind_ = 0;
    frame_ = frame.frame;
    seen_ns_ = now_ns;
    return true;
  }
  void Restart() noexcept {
    stream_.Restart();
    if (body_) body_->Restart();
    any_ = false;
    behind_ = 0;
    number_ = 0;
  }

  std::string device_, subject_;
  bool any_ = false;
  std::int32_t frame_ = 0;
  std::int64_t seen_ns_ = 0;
  int behind_ = 0;  // consecutive frames that were older than the newest
  std::uint64_t number_ = 0, lost_ = 0;
  FaceStream stream_;             // of a face that is merged
  std::optional<FaceBody> body_;  // of a face alone
  ShapeFace face_;
};

}  // namespace

std::unique_ptr<Translator> MakeLiveLinkFace(const config::Source& config) {
  return std::make_unique<LiveLinkFace>(config);
}

}  // namespace styled::source
