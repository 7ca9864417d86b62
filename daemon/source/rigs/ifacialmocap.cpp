#include "daemon/source/rigs/ifacialmocap.h"

#include <cstring>
#include <optional>

#include "daemon/config/sources.h"
#include "daemon/runtime/clock.h"
#include "daemon/source/face_stream.h"
#include "daemon/source/rigs/face_body.h"
#include "proto/rigs/ifacialmocap/ifacialmocap.h"

namespace styled::source {
namespace {

using runtime::Counter;

constexpr float kRadians = 0.017453293F;
constexpr std::int64_t kPhoneTakeOver_ns = 2 * runtime::kSecond_ns;
// The interval between two start texts; readers of the app's text use 2 to 10 s.
constexpr std::int64_t kAsk_ns = 2 * runtime::kSecond_ns;
// Silence after which the first start text is sent again. It is long compared to gaps of Wi-Fi, and
// short enough that the face is still held (MergedPart::kHold_ns) when a stopped app continues.
constexpr std::int64_t kPhoneSilence_ns = 300'000'000;

class IFacialMocap final : public Translator {
 public:
  explicit IFacialMocap(const config::Source& config) : face_(config.expressions == "vrm") {
    if (config.FaceAlone()) body_.emplace(config);
    if (config.server.empty()) return;
    const auto server = config::ParseServer(config.server, ifacialmocap::kPort);
    if (!server.ok()) return;  // the configuration is already validated
    phone_.emplace();
    std::memcpy(&phone_->address, &server.value(), sizeof(sockaddr_in));
    phone_->address_size = sizeof(sockaddr_in);
    ask_ns_ = 0;
  }

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    const auto result = ifacialmocap::Decode(datagram, frame_);
    if (result != ifacialmocap::DecodeResult::kOk) return out.Refuse(Counter::kSourceMalformed);
    if (peer.id != peer_) {
      if (peer_ != 0 && now_ns - seen_ns_ < kPhoneTakeOver_ns) {
        return out.Refuse(Counter::kPipelineSecondSender);
      }
      peer_ = peer.id;
      stream_.Restart();
      if (body_) body_->Restart();
    }
    seen_ns_ = now_ns;
    if (phone_) ask_ns_ = now_ns + kPhoneSilence_ns;
    if (frame_.known == 0) return out.Refuse(Counter::kSourceIncomplete);
    const Face& face = face_.Of(frame_.shapes);
    if (!body_) return stream_.Send(face, number_++, static_cast<std::uint64_t>(now_ns), out);
    body_->Send({.yaw_rad = kRadians * frame_.head[1],
                 .pitch_rad = kRadians * frame_.head[0],
                 .roll_rad = kRadians * frame_.head[2],
                 .source_time_ns = static_cast<std::uint64_t>(now_ns),
                 .now_ns = now_ns},
                frame_.shapes, face, out);
  }

  bool has_sensors() const override { return body_.has_value(); }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return body_ ? body_->Calibrate(what) : Translator::Calibrate(what, now_ns);
  }

  void Tick(std::int64_t now_ns, Outbox& out) override {
    if (!phone_ || now_ns < ask_ns_) return;
    ask_ns_ = now_ns + kAsk_ns;
    out.Reply(*phone_, std::as_bytes(std::span(ifacialmocap::kStart)));
  }
  std::int64_t NextDeadline_ns() const override { return ask_ns_; }

 private:
  std::optional<Peer> phone_;
  std::int64_t ask_ns_ = kNever;
  std::uint64_t peer_ = 0;
  std::int64_t seen_ns_ = 0;
  std::uint64_t number_ = 0;
  ifacialmocap::Frame frame_;
  FaceStream stream_;             // of a face that is merged
  std::optional<FaceBody> body_;  // of a face alone
  ShapeFace face_;
};

}  // namespace

std::unique_ptr<Translator> MakeIFacialMocap(const config::Source& config) {
  return std::make_unique<IFacialMocap>(config);
}

}  // namespace styled::source
