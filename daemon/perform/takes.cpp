#include "daemon/perform/takes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/looks/refusal.h"
#include "daemon/runtime/clock.h"
#include "daemon/styles/like.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

constexpr std::size_t kMostTakes = 4;  // as many as Mailboxes::takes holds
constexpr std::int64_t kRecent_ns = 300 * runtime::kMillisecond_ns;    // as for Calibrate
constexpr std::int64_t kPatience_ns = 500 * runtime::kMillisecond_ns;  // silence that ends a take

}  // namespace

Status Takes::Begin(std::unique_ptr<Exchange>& exchange, const Roster& roster,
                    std::int64_t now_ns) {
  const v1::Request& request = exchange->request;
  if (Status status = CheckLike(roster.config(), request.like()); !status.ok()) {
    return Of("like", status);
  }
  const Profile* const profile = roster.FindProfile(request.performer());
  const Performer* const live = profile == nullptr ? nullptr : roster.LiveOf(*profile);
  const body::Pose* const pose = live == nullptr ? nullptr : live->input();
  if (pose == nullptr || now_ns - live->admission.last_frame_ns() > kRecent_ns) {
    return Refused(profile == nullptr ? v1::CODE_UNKNOWN_PERFORMER : v1::CODE_NOT_READY,
                   "like: performer \"" + Printable(request.performer(), 80) +
                       "\": no frame in the last 0.3 s; expected one who moves now");
  }
  if (takes_.size() == kMostTakes) {
    return Refused(v1::CODE_BUSY, "like: four performers show a style already; try again");
  }
  const auto rate_hz = static_cast<double>(roster.config().network->model().rate_hz);
  Take take{.exchange = std::move(exchange),
            .performer = profile->id,
            .step_ns = 1e9 / rate_hz,
            .wanted = static_cast<std::size_t>(
                std::lround(static_cast<double>(request.like().learn_s()) * rate_hz)),
            .due_ns = now_ns + kPatience_ns,
            .last = *pose};
  take.exchange->take.reserve(take.wanted);
  takes_.push_back(std::move(take));
  return Status::Ok();
}

void Takes::OnFrame(const Performer& performer) noexcept {
  for (Take& take : takes_) {
    if (take.performer != performer.profile.id || performer.input() == nullptr) continue;
    take.due_ns = performer.admission.last_frame_ns() + kPatience_ns;
    Sample(*performer.input(), performer.elapsed_ns(), take);
  }
}

void Takes::Sample(const body::Pose& pose, std::int64_t elapsed_ns, Take& take) noexcept {
  if (!take.started) {
    take.began_ns = elapsed_ns;
    take.started = true;
  } else if (elapsed_ns <= take.last_ns || elapsed_ns - take.last_ns > kPatience_ns) {
    take.broken = true;  // another session, or a gap
  }
  std::vector<body::Pose>& poses = take.exchange->take;
  while (!take.broken && poses.size() < take.wanted) {
    const double tick_ns =
        static_cast<double>(take.began_ns) + static_cast<double>(poses.size()) * take.step_ns;
    const double after_ns = static_cast<double>(elapsed_ns) - tick_ns;
    if (after_ns < 0) break;
    const double between_ns = static_cast<double>(elapsed_ns - take.last_ns);
    poses.emplace_back();  // memory is reserved
    body::Interpolate(take.last, pose,
                      poses.size() == 1 ? 1 : static_cast<float>(1 - after_ns / between_ns),
                      poses.back());
  }
  take.last = pose;
  take.last_ns = elapsed_ns;
}

std::unique_ptr<Exchange> Takes::Pop(std::int64_t now_ns) {
  const auto ended = std::find_if(takes_.begin(), takes_.end(), [now_ns](const Take& take) {
    return take.broken || take.exchange->take.size() == take.wanted || now_ns > take.due_ns;
  });
  if (ended == takes_.end()) return nullptr;
  std::unique_ptr<Exchange> exchange = std::move(ended->exchange);
  if (exchange->take.size() < ended->wanted) {
    const double shown_s = static_cast<double>(exchange->take.size()) * ended->step_ns * 1e-9;
    FillReply(Refused(v1::CODE_NOT_READY,
                      "like: the performer's frames stopped or restarted after " +
                          NumberText(static_cast<float>(shown_s), 1) + " s, expected " +
                          NumberText(exchange->request.like().learn_s()) + " s without a gap"),
              exchange->reply);
  }
  takes_.erase(ended);
  return exchange;
}

}  // namespace styled::pipeline
