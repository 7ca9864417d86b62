#include "daemon/files_thread.h"

#include <poll.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "daemon/looks/refusal.h"
#include "daemon/looks/state_file.h"
#include "daemon/standby/standby.h"
#include "daemon/styles/make_config.h"

namespace styled {
namespace {

// The interval at which the free space of the recording's disk is checked.
constexpr int kLookAtDisk_ms = 200;

}  // namespace

FilesThread::FilesThread(const config::Config& config, const Origin& origin,
                         std::shared_ptr<const pipeline::RuntimeConfig> running,
                         std::uint32_t weights_crc, pipeline::Mailboxes& mailboxes,
                         runtime::Counters& counters, const runtime::Clock& clock,
                         log::Recorder* recorder)
    : config_(config),
      origin_(origin),
      running_(std::move(running)),
      weights_crc_(weights_crc),
      mailboxes_(mailboxes),
      counters_(counters),
      clock_(clock),
      recorder_(recorder) {}

FilesThread::~FilesThread() {
  if (!thread_.joinable()) return;
  stop_.store(true, std::memory_order_relaxed);
  mailboxes_.wake_files.Signal();
  thread_.join();
}

void FilesThread::Start() {
  thread_ = std::thread([this] { Run(); });
}

void FilesThread::RequestReload() {
  reload_.store(true, std::memory_order_relaxed);
  mailboxes_.wake_files.Signal();
}

std::string FilesThread::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

bool FilesThread::Stop(std::unique_ptr<std::vector<pipeline::Profile>> last) {
  std::unique_lock lock(mutex_);
  last_ = std::move(last);
  stop_.store(true, std::memory_order_relaxed);
  mailboxes_.wake_files.Signal();
  const auto patience = std::chrono::duration<double>(kPatience_s);
  if (!end_.wait_for(lock, patience, [this] { return ended_; })) return false;
  lock.unlock();
  thread_.join();
  return true;
}

void FilesThread::Run() {
  pthread_setname_np(pthread_self(), "files");
  pollfd wake{mailboxes_.wake_files.fd(), POLLIN, 0};
  while (!stop_.load(std::memory_order_relaxed)) {
    if (DoTurn()) continue;
    if (poll(&wake, 1, kLookAtDisk_ms) > 0) mailboxes_.wake_files.Clear();
  }
  std::unique_lock lock(mutex_);
  auto last = std::move(last_);
  lock.unlock();
  KeepProfiles(std::move(last));
  KeepMovedStyles(true);
  lock.lock();
  ended_ = true;
  end_.notify_one();
}

// At most one reload and one request per turn: settings are written in between.
bool FilesThread::DoTurn() {
  KeepProfiles();
  CheckRecording();
  KeepMovedStyles(false);
  if (reload_.exchange(false, std::memory_order_relaxed)) {
    Reload();
    return true;
  }
  std::unique_ptr<pipeline::Exchange> exchange;
  if (!mailboxes_.examples.Pop(exchange) && !mailboxes_.takes.Pop(exchange)) return false;
  DoStyleRequest(std::move(exchange));
  return true;
}

void FilesThread::Reload() {
  notifier_.Reloading(clock_.Now_ns());
  KeepMovedStyles(true);  // the library is read again
  const Status status = Adopt();
  const std::string refused = status.ok() ? "" : status.message();
  if (!status.ok()) {
    counters_.Add(runtime::Counter::kConfigReloadsRefused);
    spdlog::error("reload refused, the running configuration stays: {}", refused);
  }
  {
    const std::lock_guard lock(mutex_);
    refused_ = refused;
  }
  notifier_.Ready(status.ok() ? "reloaded" : "reload refused: " + refused);
}

Status FilesThread::Adopt() {
  auto fresh = config::Load(origin_.file, origin_.overrides);
  if (!fresh.ok()) return fresh.status();
  std::uint32_t crc = weights_crc_;
  auto made = pipeline::MakeRuntimeConfig(fresh.value(), running_.get(), crc);
  if (!made.ok()) return made.status();
  if (!Push({made.value(), nullptr})) return Status::Error("the daemon stops");
  WarnOfRestartKeys(fresh.value());
  running_ = made.value();
  for (const auto& complaint : running_->complaints) spdlog::warn("{}", complaint);
  weights_crc_ = crc;
  config_.log = fresh.value().log;
  config_.presets = fresh.value().presets;
  spdlog::set_level(spdlog::level::from_str(config_.log.level));
  counters_.Add(runtime::Counter::kConfigReloads);
  spdlog::info("reloaded: weights {}, {} presets", running_->weights_name,
               running_->presets.size());
  return Status::Ok();
}

void FilesThread::WarnOfRestartKeys(const config::Config& fresh) const {
  const auto warn = [](const char* section) {
    spdlog::warn("reload: [{}] changed; the change needs a restart", section);
  };
  if (fresh.sources != config_.sources) warn("source");
  if (!(fresh.publish == config_.publish)) warn("publish");
  if (!(fresh.control == config_.control)) warn("control");
  if (!(fresh.security == config_.security)) warn("security");
  if (!(fresh.osc == config_.osc)) warn("osc");
  if (!(fresh.standby == config_.standby)) warn("standby");
  if (!(fresh.time == config_.time)) warn("time");
  if (!(fresh.realtime == config_.realtime)) warn("realtime");
  if (fresh.state.dir != config_.state.dir) warn("state");
  if (!(fresh.record == config_.record)) warn("record");
}

void FilesThread::DoStyleRequest(std::unique_ptr<pipeline::Exchange> exchange) {
  std::shared_ptr<const pipeline::RuntimeConfig> made;
  if (mailboxes_.stands_by.load(std::memory_order_relaxed) && !exchange->followed &&
      log::Changes(exchange->request)) {
    exchange->reply.set_id(exchange->request.id());
    pipeline::FillReply(standby::OrderRefused(config_.standby.peer), exchange->reply);
  } else {
    made = style_requests_.Do(*running_, *exchange);
    if (!style_requests_.log_line().empty()) spdlog::info("{}", style_requests_.log_line());
    if (!style_requests_.error().empty()) spdlog::error("{}", style_requests_.error());
    if (made != nullptr) running_ = made;
  }
  (void)Push({std::move(made), std::move(exchange)});
}

// Waits while the ring is full: the pipeline empties it between frames. False when the daemon
// stops.
bool FilesThread::Push(pipeline::Reload reload) {
  // A full ring leaves it as it is: it is not moved twice. NOLINTNEXTLINE(bugprone-use-after-move)
  while (!mailboxes_.reloads.Push(std::move(reload))) {
    if (stop_.load(std::memory_order_relaxed)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  mailboxes_.wake_pipeline.Signal();
  return true;
}

void FilesThread::KeepProfiles(std::unique_ptr<std::vector<pipeline::Profile>> newest) {
  std::unique_ptr<std::vector<pipeline::Profile>> kept;
  while (mailboxes_.profiles.Pop(kept)) {
  }
  if (newest != nullptr) kept = std::move(newest);
  const std::string file = Origin::StateFile(config_);
  if (kept == nullptr || file.empty()) return;
  const Status status = pipeline::WriteProfiles(file, *kept);
  counters_.Add(status.ok() ? runtime::Counter::kStateWrites
                            : runtime::Counter::kStateWritesFailed);
  if (!status.ok()) spdlog::error("settings are not kept: {}", status.message());
}

void FilesThread::KeepMovedStyles(bool now) {
  const auto kept = style_requests_.KeepMoved(*running_, now);
  if (!style_requests_.error().empty()) spdlog::error("{}", style_requests_.error());
  // Only this thread reads what the library has: the pipeline keeps the configuration it has.
  if (kept != nullptr) running_ = kept;
}

void FilesThread::CheckRecording() {
  if (recorder_ == nullptr) return;
  const std::string complaint = recorder_->Check(counters_);
  if (!complaint.empty()) spdlog::error("recording: {}", complaint);
}

}  // namespace styled
