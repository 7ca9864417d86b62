#include "daemon/log/recorder.h"

#include <array>
#include <ctime>
#include <system_error>

#include "daemon/log/frame_history.h"
#include "daemon/runtime/clock.h"
#include "proto/rigs/types.h"

namespace styled::log {
namespace {

constexpr const char* kUsualName = "%Y-%m-%d_%H-%M-%S.styrec";
constexpr std::uint64_t kMiB = 1U << 20U;

std::vector<recording::Origin> OriginsOf(const config::Config& config,
                                         const std::vector<std::string>& endpoints) {
  std::vector<recording::Origin> origins;
  for (std::size_t i = 0; i < config.sources.size(); ++i) {
    const auto& source = config.sources[i];
    const rigs::SourceType& type = *rigs::FindSourceType(source.type);
    const std::string scheme = type.usb ? "usb:" : type.stream ? "tcp://" : "udp://";
    origins.push_back({source.name, source.type, scheme + endpoints[i]});
  }
  return origins;
}

}  // namespace

bool Changes(const v1::Request& request) {
  return !request.has_list() && !request.has_status() && !request.has_preview() &&
         !request.has_export_style() && !request.has_take_checkpoint() && !request.has_lead() &&
         !request.has_explain() && !request.like().measure() &&
         request.command_case() != v1::Request::COMMAND_NOT_SET;
}

std::filesystem::path FileAt(const std::string& pattern, std::int64_t unix_s) {
  std::error_code error;
  std::string text = pattern;
  if (text.ends_with('/') || std::filesystem::is_directory(text, error)) {
    text += std::string(text.ends_with('/') ? "" : "/") + kUsualName;
  }
  const auto seconds = static_cast<std::time_t>(unix_s);
  std::tm parts{};
  localtime_r(&seconds, &parts);
  std::array<char, 4096> name{};
  const std::size_t size = std::strftime(name.data(), name.size(), text.c_str(), &parts);
  const std::filesystem::path file = size > 0 ? std::string(name.data(), size) : text;
  std::filesystem::path free = file;
  for (int i = 2; std::filesystem::exists(free, error) && i < 10000; ++i) {
    free = file;
    free.replace_filename(file.stem().string() + "-" + std::to_string(i) +
                          file.extension().string());
  }
  return free;
}

Result<std::unique_ptr<Recorder>> Recorder::Start(const config::Config& config,
                                                  const std::vector<std::string>& endpoints,
                                                  const About& about) {
  recording::FileHeader header = recording::BeginningNow("styled", STYLED_VERSION);
  header.set_config(about.config);
  header.set_state(about.state);
  header.set_weights(about.weights);
  header.set_weights_hash(about.weights_hash);
  const auto file = FileAt(config.record.file, header.created_unix_ns() / runtime::kSecond_ns);
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  auto thread = recording::RecordingThread::Start(file, header, OriginsOf(config, endpoints));
  if (!thread.ok()) return thread.status();
  const auto min_free_bytes = static_cast<std::uint64_t>(config.record.min_free_mb) * kMiB;
  std::vector<std::string> names;
  for (const config::Source& source : config.sources) names.push_back(source.name);
  return std::unique_ptr<Recorder>(
      new Recorder(file, min_free_bytes, std::move(thread.value()), std::move(names)));
}

bool Recorder::Paused() noexcept {
  if (!paused_.load(std::memory_order_relaxed)) return false;
  skipped_.fetch_add(1, std::memory_order_relaxed);
  return true;
}

void Recorder::OnArrival(const source::Arrival& arrival) noexcept {
  if (Paused()) return;
  if (arrival.device != 0) {
    (void)thread_->PushTransfer(arrival.time_ns, arrival.source, arrival.device, arrival.bytes);
  } else {
    (void)thread_->PushArrival(arrival.time_ns, arrival.source, arrival.peer, arrival.peer_size,
                               arrival.bytes);
  }
}

void Recorder::OnRequest(std::int64_t now_ns, const v1::Request& request, const v1::Reply& reply) {
  const bool done = reply.code() == v1::CODE_OK || reply.has_like();  // the style is made
  if (!Changes(request) || !done || Paused()) return;
  recording::Command command;
  *command.mutable_request() = request;
  *command.mutable_applied() = reply.applied();
  (void)thread_->PushCommand(now_ns, command);
}

void Recorder::OnFrames(int source, std::span<const decide::FrameInTransit> frames,
                        std::int64_t receive_ns, std::int64_t /*wall_ns*/) {
  if (paused_.load(std::memory_order_relaxed)) return;  // the arrival is counted as lost
  const auto at = static_cast<std::size_t>(source);
  fates_.Clear();
  fates_.set_source(source_names_[at]);
  for (const decide::FrameInTransit& frame : frames) {
    if (frame.decision.postponed) continue;
    v1::FrameFate& fate = *fates_.add_frames();
    fate.set_performer(source_names_[at] + ".");
    fate.mutable_performer()->append(frame.given->performer);
    FillFate(frame, fate);
  }
  if (fates_.frames_size() > 0) (void)thread_->PushDecided(receive_ns, fates_);
}

void Recorder::OnSilence(std::int64_t now_ns, const v1::Silence& silence) {
  if (paused_.load(std::memory_order_relaxed)) return;
  recording::Decided decided;
  *decided.mutable_silence() = silence;
  (void)thread_->PushDecided(now_ns, decided);
}

void Recorder::OnReload(std::int64_t now_ns, std::string_view weights) {
  if (!Paused()) (void)thread_->PushNote(now_ns, "reloaded: weights " + std::string(weights));
}

std::string Recorder::Check(runtime::Counters& counters) {
  std::error_code error;
  const auto space = std::filesystem::space(file_, error);
  const bool full = !error && space.available < min_free_bytes_;
  paused_.store(full, std::memory_order_relaxed);
  counters.Set(runtime::Counter::kRecordOn, full ? 0 : 1);
  counters.Set(runtime::Counter::kRecordWritten, written());
  counters.Set(runtime::Counter::kRecordLost, lost());
  std::string complaint = thread_->error().message();
  if (full) {
    complaint = file_.string() +
                ": less than record.min_free_mb = " + std::to_string(min_free_bytes_ / kMiB) +
                " is free there; recording pauses";
  }
  if (complaint == last_complaint_) return "";
  last_complaint_ = complaint;
  if (!complaint.empty()) counters.Add(runtime::Counter::kRecordFailures);
  return complaint;
}

}  // namespace styled::log
