#include "clients/cpp/asker.h"

#include <algorithm>
#include <utility>

namespace styled::client {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxWaiting = 64;
constexpr std::size_t kMaxLanes = 5;  // as many takes at once as the daemon has, and the other
                                      // requests
constexpr std::chrono::milliseconds kTimeout(2000), kLongTimeout(10000);

}  // namespace

bool IsLong(const v1::Request& request) {
  return request.has_like() || request.has_preview() || request.has_export_style() ||
         request.has_import_style();
}

Asker::~Asker() { ending_.request_stop(); }

Result<std::unique_ptr<Asker>> Asker::Start(const std::string& endpoint,
                                            const std::optional<Curve>& curve) {
  std::unique_ptr<Asker> asker(new Asker);
  asker->options_ = {.endpoint = endpoint,
                     .timeout = kTimeout,
                     .curve = curve,
                     .stop = asker->ending_.get_token()};
  const Status status = asker->AddLane();
  if (!status.ok()) return status;
  return asker;
}

Status Asker::AddLane() {
  ControlOptions options = options_;
  if (!lanes_.empty()) options.timeout = kLongTimeout;
  auto control = Control::Connect(options);
  if (!control.ok()) return control.status();
  auto lane = std::make_unique<Lane>();
  lane->control = std::move(control.value());
  lane->thread =
      std::jthread([this, lane = lane.get()](const std::stop_token& stop) { Loop(stop, *lane); });
  lanes_.push_back(std::move(lane));
  return Status::Ok();
}

// The lane for long requests with the fewest waiting; null if none can be connected.
Asker::Lane* Asker::LaneFor(const v1::Request& request) {
  if (!IsLong(request)) return lanes_.front().get();
  const auto load = [](const auto& lane) {
    return lane->waiting.size() + static_cast<std::size_t>(lane->busy);
  };
  const auto least =
      std::min_element(lanes_.begin() + 1, lanes_.end(),
                       [&load](const auto& a, const auto& b) { return load(a) < load(b); });
  if (least != lanes_.end() && (load(*least) == 0 || lanes_.size() == kMaxLanes)) {
    return least->get();
  }
  return AddLane().ok() ? lanes_.back().get() : nullptr;
}

bool Asker::Ask(v1::Request request, Done done) {
  const std::scoped_lock lock(mutex_);
  Lane* const lane = LaneFor(request);
  if (lane == nullptr || lane->waiting.size() >= kMaxWaiting) return false;
  lane->waiting.push_back({std::move(request), std::move(done), Clock::now()});
  lane->wake.notify_one();
  return true;
}

void Asker::Loop(const std::stop_token& stop, Lane& lane) {
  for (;;) {
    Waiting next;
    {
      std::unique_lock lock(mutex_);
      lane.busy = false;
      if (!lane.wake.wait(lock, stop, [&lane] { return !lane.waiting.empty(); })) return;
      if (stop.stop_requested()) return;
      next = std::move(lane.waiting.front());
      lane.waiting.pop_front();
      lane.busy = true;
    }
    v1::Reply reply;
    const std::uint64_t id = next.request.id();
    CallStatus status;
    if (Clock::now() - next.since > kTimeout) {
      status = {CallStatus::Kind::kNoAnswer, v1::CODE_OK,
                "the daemon has not answered earlier requests"};
    } else {
      status = lane.control->Call(next.request, &reply);
    }
    reply.set_id(id);  // restore the caller's id
    next.done(std::move(status), std::move(reply));
  }
}

}  // namespace styled::client
