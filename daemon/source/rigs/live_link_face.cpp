#include "daemon/source/rigs/live_link_face.h"

#include <cmath>
#include <span>
#include <string>

#include "daemon/runtime/clock.h"
#include "daemon/source/face_stream.h"
#include "proto/rigs/livelinkface/live_link_face.h"

namespace styled::source {
namespace {

using runtime::Counter;

constexpr std::int64_t kFaceTakeOver_ns = 2 * runtime::kSecond_ns;
// As in mocopi.cpp: a smaller step back means a late frame, unless so many occur in a row.
constexpr int kFaceOldFrames = 5;

class LiveLinkFace final : public Translator {
 public:
  explicit LiveLinkFace(const config::Source& config) : face_(config.expressions == "vrm") {}

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
    stream_.Send(face_.Of(std::span(frame.values).first<arkit::kShapes>()), number_++,
                 static_cast<std::uint64_t>(time_ns), out);
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
    any_ = true;
    behind_ = 0;
    frame_ = frame.frame;
    seen_ns_ = now_ns;
    return true;
  }
  void Restart() noexcept {
    stream_.Restart();
    any_ = false;
    behind_ = 0;
    number_ = 0;
  }

  std::string device_, subject_;
  bool any_ = false;
  std::int32_t frame_ = 0;
  std::int64_t seen_ns_ = 0;
  int behind_ = 0;  // consecutive frames that were older than the newest
  std::uint64_t number_ = 0;
  FaceStream stream_;
  ShapeFace face_;
};

}  // namespace

std::unique_ptr<Translator> MakeLiveLinkFace(const config::Source& config) {
  return std::make_unique<LiveLinkFace>(config);
}

}  // namespace styled::source
