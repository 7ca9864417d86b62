#include "clients/web/asker.h"

#include <utility>

namespace styled::web {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxWaiting = 64;
constexpr std::chrono::milliseconds kTimeout(2000);

}  // namespace

Asker::Asker(std::unique_ptr<client::Control> control)
    : control_(std::move(control)), thread_([this](const std::stop_token& stop) { Loop(stop); }) {}

Asker::~Asker() = default;

Result<std::unique_ptr<Asker>> Asker::Start(const std::string& endpoint,
                                            const std::optional<client::Curve>& curve) {
  auto control =
      client::Control::Connect({.endpoint = endpoint, .timeout = kTimeout, .curve = curve});
  if (!control.ok()) return control.status();
  return std::unique_ptr<Asker>(new Asker(std::move(control.value())));
}

bool Asker::Ask(v1::Request request, Done done) {
  {
    const std::scoped_lock lock(mutex_);
    if (waiting_.size() >= kMaxWaiting) return false;
    waiting_.push_back({std::move(request), std::move(done), Clock::now()});
  }
  wake_.notify_one();
  return true;
}

void Asker::Loop(const std::stop_token& stop) {
  for (;;) {
    Waiting next;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return !waiting_.empty(); })) return;
      if (stop.stop_requested()) return;
      next = std::move(waiting_.front());
      waiting_.pop_front();
    }
    v1::Reply reply;
    const std::uint64_t id = next.request.id();
    client::CallStatus status;
    if (Clock::now() - next.since > kTimeout) {
      status = {client::CallStatus::Kind::kNoAnswer, v1::CODE_OK,
                "the daemon has not answered earlier requests"};
    } else {
      status = control_->Call(next.request, &reply);
    }
    reply.set_id(id);  // restore the caller's id
    next.done(std::move(status), std::move(reply));
  }
}

}  // namespace styled::web
