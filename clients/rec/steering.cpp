#include "clients/rec/steering.h"

#include <algorithm>

namespace styled::rec {
namespace {

constexpr std::uint64_t kUnderWay = 64;  // datagrams; small compared with any socket's buffer
constexpr std::int64_t kStill_ns = 20'000'000, kLongest_ns = 2'000'000'000, kLook_ns = 500'000;
// Number of polls with an unchanged count. The daemon's pipeline reads its sources before each
// reply, however slow the machine is.
constexpr int kStillLooks = 8, kSurelyStillLooks = 3;

}  // namespace

Result<std::unique_ptr<Steering>> Steering::Connect(const std::string& endpoint,
                                                    player::Clock& clock,
                                                    const std::optional<client::Curve>& curve) {
  auto control = client::Control::Connect(
      {.endpoint = endpoint, .timeout = std::chrono::seconds(2), .curve = curve});
  if (!control.ok()) return control.status();
  styled::v1::StatusReply reply;
  const auto answer = control.value()->Status(&reply);
  if (!answer.ok()) return styled::Status::Error(answer.reason());
  std::unique_ptr<Steering> steering(new Steering(std::move(control.value()), clock));
  steering->before_ = steering->Received().value_or(0);
  return steering;
}

std::optional<std::uint64_t> Steering::Received() {
  styled::v1::StatusReply reply;
  if (!control_->Status(&reply).ok()) return std::nullopt;
  for (const auto& counter : reply.stats().counters()) {
    if (counter.name() == "source.received") return counter.value();
  }
  return std::nullopt;
}

void Steering::Settle(std::uint64_t under_way) {
  const std::int64_t begin_ns = clock_.Now_ns();
  std::int64_t moved_ns = begin_ns;
  std::uint64_t received = known_;
  int still = 0;
  bool settled = under_way > 0 && sent_ <= known_ + under_way;
  while (!settled) {
    const auto counter = Received();
    const std::int64_t now_ns = clock_.Now_ns();
    if (counter) {
      const bool moved = *counter - before_ != received;
      received = *counter - before_;
      still = moved ? 0 : still + 1;
      if (moved) moved_ns = now_ns;
    }
    if (received <= sent_) known_ = std::max(known_, received);
    // Equality may be a coincidence if a source counts more than it is sent, so it must hold for
    // several polls.
    settled = under_way > 0 ? sent_ <= known_ + under_way
                            : received == sent_ && still >= kSurelyStillLooks;
    const bool at_rest = still >= kStillLooks && now_ns - moved_ns >= kStill_ns;
    if (!settled && (at_rest || now_ns - begin_ns >= kLongest_ns)) {
      // The source counts differently, or datagrams were lost. The next datagrams need not make up
      // for the difference.
      before_ += received - sent_;
      known_ = sent_;
      settled = true;
    }
    if (!settled) clock_.SleepUntil(now_ns + kLook_ns);
  }
}

void Steering::BeforeSending() {
  if (sent_ >= known_ + kUnderWay) Settle(kUnderWay / 2);
  ++sent_;
}

void Steering::Note(const recording::Record& record) { (void)Play(record); }

Status Steering::Play(const recording::Record& record) {
  if (!record.has_command()) return Status::Ok();
  CatchUp();
  styled::v1::Request request = record.command().request();
  styled::v1::Reply reply;
  const auto answer = control_->Call(request, &reply);
  ++commands_;
  if (answer.ok()) return Status::Ok();
  if (answer.kind() != client::CallStatus::Kind::kRefused) return Status::Error(answer.reason());
  refused_.push_back(request.performer() + ": " + answer.reason());
  return Status::Ok();
}

}  // namespace styled::rec
