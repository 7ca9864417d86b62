#include "daemon/supervisor.h"

#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <sys/signalfd.h>
#include <unistd.h>
#include <zmq.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/config/machine.h"
#include "daemon/looks/state_file.h"
#include "daemon/runtime/journal.h"
#include "daemon/runtime/realtime.h"
#include "daemon/source/open.h"
#include "daemon/styles/make_config.h"
#include "daemon/styles/networks.h"
#include "model/base/descriptor.h"
#include "model/base/random_id.h"
#include "model/base/read_file.h"
#include "proto/rigs/types.h"

namespace styled {
namespace {

constexpr int kTick_ms = 200;
// A sender's skeleton comes once a second, and its rest pose within 1.5 s.
constexpr std::uint64_t kStart_s = 3;

// Counters that grow whenever a daemon starts while a rig sends, or a rig begins: a warning only if
// it lasts.
constexpr bool OfStarts(runtime::Counter counter) {
  return counter == runtime::Counter::kPipelineBeforeBody ||
         counter == runtime::Counter::kSourceBeforeRestPose;
}

// Whether the two daemons of [standby] show each other their keys.
bool ExchangesKeys(const config::Config& config) {
  return !config.standby.peer.empty() && !config.standby.peer_key.empty() &&
         !config.security.keys.empty() && !config.standby.allow_unauthenticated_remote;
}

runtime::Scheduling SchedulingOf(const config::Realtime& realtime) {
  return {realtime.lock_memory, realtime.priority, realtime.cpu};
}

// Returns "" when the file cannot be read.
std::string ReadText(const std::string& file, std::size_t max_bytes) {
  auto text = ReadFile(file, max_bytes);
  return text.ok() ? std::move(text.value()) : "";
}

}  // namespace

Supervisor::Supervisor(config::Config config, Origin origin)
    : config_(std::move(config)),
      origin_(std::move(origin)),
      context_(zmq_ctx_new()),
      epoch_(RandomId() | 1U) {}

Supervisor::~Supervisor() {
  sign_of_life_.reset();
  if (pipeline_loop_ != nullptr) pipeline_loop_->Stop();
  if (control_ != nullptr) control_->Stop();
  if (pipeline_thread_.joinable()) pipeline_thread_.join();
  if (control_thread_.joinable()) control_thread_.join();
  files_.reset();
  pipeline_.reset();
  helpers_.reset();
  standby_.reset();
  publisher_.reset();
  control_.reset();
  gatekeeper_.reset();
  zmq_ctx_term(context_);
}

Status Supervisor::Start() {
  notifier_.SetStatus("reading the weights");
  auto made = pipeline::MakeRuntimeConfig(config_, nullptr, weights_crc_);
  if (!made.ok()) return made.status();
  runtime_config_ = made.value();
  for (const auto& complaint : runtime_config_->complaints) spdlog::warn("{}", complaint);
  Status status = OpenSources();
  if (status.ok()) status = OpenGate();
  if (status.ok()) status = OpenSockets();
  if (status.ok()) status = OpenStandby();
  if (!status.ok()) return status;
  StartRecording();
  clock_watch_.Update(clock_.Now_ns());
  StartHelpers();
  std::vector<std::string> names, types;
  for (const auto& source : config_.sources) {
    names.push_back(source.name);
    types.push_back(source.type);
  }
  pipeline_ = std::make_unique<pipeline::Pipeline>(
      pipeline::Dependencies{
          standby_ != nullptr ? static_cast<runtime::Clock&>(standby_->clock()) : clock_, counters_,
          standby_ != nullptr ? standby_->publisher() : *publisher_, mailboxes_, recorder_.get(),
          config_.realtime.prewarm || config_.realtime.wait == "hybrid", config_.realtime.prewarm,
          config_.realtime.wait == "hybrid", &clock_watch_, standby_.get(),
          config_.realtime.relieve, helpers_.get()},
      std::move(names), std::move(transports_), runtime_config_, epoch_,
      config_.publish.max_subscriptions);
  pipeline_->SetSourceTypes(std::move(types));
  pipeline_->SetLayers(config_.sources);
  RestoreProfiles();
  if (config_.realtime.lock_memory) {
    for (const auto& refused : runtime::LockMemory()) spdlog::warn("{}", refused);
  }
  const std::string memory =
      config::MemoryWarning(config_.performers.max_performers, config::MemoryLimit());
  if (!memory.empty()) spdlog::warn("{}", memory);
  StartThreads();
  status = WriteReadyFile();
  if (status.ok()) {
    spdlog::info("styled {} ready: weights {}, publishing on {}, control on {}", STYLED_VERSION,
                 runtime_config_->weights_name, publish_endpoint_, control_endpoint_);
    for (const net::Terms& terms : runtime_config_->terms) spdlog::info("{}", TermsText(terms));
    notifier_.Ready("ready");
    StartSignOfLife();
  }
  return status;
}

Status Supervisor::OpenSources() {
  for (std::size_t i = 0; i < config_.sources.size(); ++i) {
    const auto& source = config_.sources[i];
    const rigs::SourceType& type = *rigs::FindSourceType(source.type);
    auto transport = source::Open(source, static_cast<int>(i), clock_, counters_);
    if (!transport.ok()) {
      const bool usb = type.usb;
      return Status::Error("source." + std::to_string(i) + (usb ? ": " : ".listen: ") +
                           transport.status().message());
    }
    source_endpoints_.push_back(transport.value()->endpoint());
    spdlog::info("source {} {} {} {}", source.name,
                 type.connects()         ? "connects to"
                 : type.rig->asks_server ? "asks"
                                         : "listens on",
                 source.type, source_endpoints_.back());
    transports_.push_back(std::move(transport.value()));
  }
  return Status::Ok();
}

// Runs before the sockets are bound: libzmq then asks the gatekeeper about every client.
Status Supervisor::OpenGate() {
  const config::Publish& publish = config_.publish;
  const config::Control& control = config_.control;
  const bool asks =
      ExchangesKeys(config_) ||
      config::RequiresKeys(config_, publish.address, publish.allow_unauthenticated_remote) ||
      config::RequiresKeys(config_, control.address, control.allow_unauthenticated_remote);
  if (!asks) return Status::Ok();
  auto opened = security::Gatekeeper::Open(context_, config_.security.keys, counters_);
  if (!opened.ok()) return opened.status();
  gatekeeper_ = std::move(opened.value());
  spdlog::info("clients from other machines need a key ({}); this daemon's is {}",
               config_.security.keys, gatekeeper_->public_key());
  return Status::Ok();
}

security::Gatekeeper* Supervisor::KeeperOf(const std::string& address,
                                           bool allow_unauthenticated_remote) {
  return config::RequiresKeys(config_, address, allow_unauthenticated_remote) ? gatekeeper_.get()
                                                                              : nullptr;
}

Status Supervisor::OpenSockets() {
  auto publisher = publish::MakeZmqPublisher(
      context_, config_.publish, counters_, publish_endpoint_,
      KeeperOf(config_.publish.address, config_.publish.allow_unauthenticated_remote));
  if (!publisher.ok()) return publisher.status();
  publisher_ = std::move(publisher.value());
  std::unique_ptr<control::OscSocket> osc;
  if (!config_.osc.listen.empty()) {
    auto opened = control::OscSocket::Open(config_.osc.listen);
    if (!opened.ok()) return Status::Error("osc.listen: " + opened.status().message());
    osc = std::move(opened.value());
    osc_endpoint_ = osc->endpoint();
    spdlog::info("OSC at {}", osc_endpoint_);
  }
  auto control = control::MakeControlSocket(
      context_, config_.control, std::move(osc), mailboxes_, counters_, control_endpoint_,
      KeeperOf(config_.control.address, config_.control.allow_unauthenticated_remote));
  if (!control.ok()) return control.status();
  control_ = std::move(control.value());
  if (gatekeeper_ != nullptr) gatekeeper_->Start();
  return Status::Ok();
}

Status Supervisor::OpenStandby() {
  if (config_.standby.peer.empty()) return Status::Ok();
  auto opened = standby::OpenZmqChannel(context_, config_.standby,
                                        ExchangesKeys(config_) ? gatekeeper_.get() : nullptr);
  if (!opened.ok()) return opened.status();
  standby_fds_ = {opened.value().publish_fd, opened.value().subscribe_fd};
  standby_endpoint_ = opened.value().endpoint;
  standby_ = std::make_unique<standby::Standby>(std::move(opened.value().channel), config_.standby,
                                                epoch_, *publisher_, clock_);
  mailboxes_.stands_by.store(true, std::memory_order_relaxed);
  spdlog::info("standby of {}; its own journal is at {}", config_.standby.peer, standby_endpoint_);
  return Status::Ok();
}

// A recording that cannot start is logged and does not keep the daemon from starting.
void Supervisor::StartRecording() {
  if (config_.record.file.empty()) return;
  log::About about;
  about.config = ReadText(origin_.file, config::kMaxFileBytes);
  for (const auto& set : origin_.overrides) {
    about.config += "# " + set.place + ": " + set.key + " = " + set.value + "\n";
  }
  about.state = ReadText(Origin::StateFile(config_), pipeline::kMaxStateBytes);
  const auto files = pipeline::FindWeightsFiles(config_.model);
  if (files.ok()) {
    const auto label = pipeline::LabelOf(config_.model, files.value());
    if (label.ok()) {
      about.weights = label.value().names;
      about.weights_hash = label.value().hashes;
    }
  }
  auto recorder = log::Recorder::Start(config_, source_endpoints_, about);
  if (!recorder.ok()) {
    counters_.Add(runtime::Counter::kRecordFailures);
    spdlog::error("nothing is recorded: {}", recorder.status().message());
    return;
  }
  recorder_ = std::move(recorder.value());
  spdlog::info("recording to {}", recorder_->file().string());
}

void Supervisor::CloseRecording() {
  if (recorder_ == nullptr) return;
  recorder_->Close();
  const std::string complaint = recorder_->Check(counters_);
  if (!complaint.empty()) spdlog::error("recording: {}", complaint);
  spdlog::info("recorded {} records to {}, {} lost", recorder_->written(),
               recorder_->file().string(), recorder_->lost());
}

// A broken state file is logged and does not keep the daemon from starting.
void Supervisor::RestoreProfiles() {
  const std::string file = Origin::StateFile(config_);
  if (file.empty()) {
    spdlog::info("no state.dir: performers' settings will not survive a restart");
    return;
  }
  std::error_code error;
  std::filesystem::create_directories(config_.state.dir, error);
  if (!std::filesystem::is_directory(config_.state.dir, error)) {
    spdlog::error("state.dir: {} cannot be made a folder; settings will not survive a restart",
                  config_.state.dir);
    return;
  }
  // Writability is tested with a temporary file, which covers permissions, mounts and limits.
  std::string probe = config_.state.dir + "/.styled-XXXXXX";
  if (const Descriptor made(mkstemp(probe.data())); made.get() >= 0) {
    std::filesystem::remove(probe, error);
  } else {
    spdlog::error("state.dir: {}: cannot be written: {}; settings will not survive a restart",
                  config_.state.dir, std::strerror(errno));
  }
  auto kept = pipeline::ReadProfiles(file);
  if (!kept.ok()) {
    spdlog::error("settings of the last run are lost: {}", kept.status().message());
    return;
  }
  spdlog::info("{} performers' settings restored from {}", kept.value().size(), file);
  for (const auto& profile : kept.value()) {
    if (recorder_ == nullptr) break;
    for (const auto& request : pipeline::AsRequests(profile)) {
      recorder_->OnRequest(clock_.Now_ns(), request, {});
    }
  }
  pipeline_->Restore(std::move(kept.value()));
}

// Helpers run at the pipeline thread's priority, on the cores behind its own.
void Supervisor::StartHelpers() {
  const int count = config_.realtime.styling_threads - 1;
  if (count == 0) return;
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  if (cores > 0 && count >= cores) {
    spdlog::warn("realtime.styling_threads: found {}, expected at most {}, the number of cores",
                 count + 1, cores);
  }
  helpers_ = std::make_unique<runtime::Helpers>(count, [this](int index) {
    const std::string name = "styling " + std::to_string(index + 2);
    pthread_setname_np(pthread_self(), name.c_str());
    runtime::Scheduling scheduling = SchedulingOf(config_.realtime);
    if (scheduling.cpu >= 0) scheduling.cpu += index + 1;
    for (const auto& refused : runtime::ApplyScheduling(scheduling)) {
      spdlog::warn("thread {}: {}", name, refused);
    }
  });
}

void Supervisor::StartThreads() {
  files_ = std::make_unique<FilesThread>(config_, origin_, runtime_config_, weights_crc_,
                                         mailboxes_, counters_, clock_, recorder_.get());
  std::vector<int> fds{publisher_->fd()};
  for (const auto& transport : pipeline_->transports()) fds.push_back(transport->fd());
  fds.insert(fds.end(), standby_fds_.begin(), standby_fds_.end());
  const std::string& wait = config_.realtime.wait;
  pipeline_loop_ =
      std::make_unique<pipeline::PipelineThread>(*pipeline_, fds, mailboxes_.wake_pipeline, clock_,
                                                 wait == "busy"     ? pipeline::Wait::kBusy
                                                 : wait == "hybrid" ? pipeline::Wait::kHybrid
                                                                    : pipeline::Wait::kBlock);
  pipeline_thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "pipeline");
    for (const auto& refused : runtime::ApplyScheduling(SchedulingOf(config_.realtime))) {
      spdlog::warn("pipeline thread: {}", refused);
    }
    pipeline_loop_->Run();
  });
  files_->Start();
  control_thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "control");
    control_->Run();
  });
}

void Supervisor::StartSignOfLife() {
  const char* const manager = std::getenv("NOTIFY_SOCKET");
  if (manager != nullptr &&
      runtime::WatchdogAsked(std::getenv("WATCHDOG_USEC"), std::getenv("WATCHDOG_PID"), getpid())) {
    // An idle pipeline sleeps: the signal makes it turn once before the next check.
    sign_of_life_ = std::make_unique<runtime::SignOfLife>(
        manager, [this] { return pipeline_loop_->turns(); },
        [this] { mailboxes_.wake_pipeline.Signal(); });
  }
}

Status Supervisor::WriteReadyFile() const {
  if (origin_.ready_file.empty()) return Status::Ok();
  nlohmann::json ready{{"pid", getpid()},
                       {"publish", publish_endpoint_},
                       {"control", control_endpoint_},
                       {"osc", osc_endpoint_},
                       {"standby", standby_endpoint_},
                       {"weights", runtime_config_->weights_name},
                       {"epoch", epoch_}};
  for (std::size_t i = 0; i < config_.sources.size(); ++i) {
    ready["sources"].push_back({{"name", config_.sources[i].name},
                                {"type", config_.sources[i].type},
                                {"listen", source_endpoints_[i]}});
  }
  if (gatekeeper_ != nullptr) ready["server_key"] = gatekeeper_->public_key();
  if (recorder_ != nullptr) ready["recording"] = recorder_->file().string();
  const std::string fresh = origin_.ready_file + ".new";
  std::ofstream out(fresh);
  out << ready.dump(2) << "\n";
  out.close();
  if (!out || std::rename(fresh.c_str(), origin_.ready_file.c_str()) != 0) {
    return Status::Error("--ready-file " + origin_.ready_file + ": cannot be written");
  }
  return Status::Ok();
}

void Supervisor::Run() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  const Descriptor signal_fd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
  std::int64_t logged_ns = clock_.Now_ns();
  while (true) {
    pollfd signal{signal_fd.get(), POLLIN, 0};
    poll(&signal, 1, kTick_ms);
    signalfd_siginfo caught{};
    while (read(signal_fd.get(), &caught, sizeof caught) == sizeof caught) {
      if (caught.ssi_signo == SIGHUP) {
        files_->RequestReload();
        continue;
      }
      spdlog::info("{}: stopping", caught.ssi_signo == SIGTERM ? "SIGTERM" : "SIGINT");
      return Stop();
    }
    LogEvents();
    const std::int64_t passed_ns = clock_.Now_ns() - logged_ns;
    if (passed_ns < runtime::kSecond_ns) continue;
    logged_ns += passed_ns;
    LogTrouble();
    ReportStatus(static_cast<double>(passed_ns) / 1e9);
  }
}

void Supervisor::Stop() {
  notifier_.Stopping();
  pipeline_loop_->Stop();
  pipeline_thread_.join();
  if (standby_ != nullptr) standby_->Leave();
  LogEvents();
  const bool ended = files_->Stop(pipeline_->PopUnsaved());
  if (!ended) spdlog::error("a disk does not answer: the last settings may be lost");
  CloseRecording();
  // A thread that waits for the kernel cannot be ended, and what it uses cannot be destroyed.
  if (!ended) std::_Exit(EXIT_FAILURE);
}

void Supervisor::LogEvents() {
  pipeline::Event event;
  while (mailboxes_.events.Pop(event)) {
    const bool warning = event.level == pipeline::Event::Level::kWarning;
    spdlog::log(warning ? spdlog::level::warn : spdlog::level::info, "{}", event.text);
  }
}

// The names of the sources whose bits are set, e.g. "suit, stage".
std::string Supervisor::NamesOf(std::uint64_t sources) const {
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(config_.sources.size(), 64); ++i) {
    if ((sources >> i & 1U) == 0) continue;
    names.append(names.empty() ? "" : ", ").append(config_.sources[i].name);
    if (i == 63 && config_.sources.size() > 64) names += " or a later one";
  }
  return names;
}

// Logs once a second which counters grew, instead of a line per packet.
void Supervisor::LogTrouble() {
  for (std::size_t i = 0; i < logged_.size(); ++i) {
    const auto counter = static_cast<runtime::Counter>(i);
    const std::uint64_t value = counters_.Get(counter);
    if (runtime::IsTrouble(counter) && value != logged_[i]) {
      const std::string from = NamesOf(counters_.ClearSources(counter));
      const runtime::LogFields fields{{"STYLED_COUNTER", std::string(runtime::Name(counter))},
                                      {"STYLED_MORE", std::to_string(value - logged_[i])},
                                      {"STYLED_IN_ALL", std::to_string(value)},
                                      {"STYLED_SOURCE", from}};
      ++growing_s_[i];
      spdlog::log(OfStarts(counter) && growing_s_[i] <= kStart_s ? spdlog::level::info
                                                                 : spdlog::level::warn,
                  "{}: {} more, {} in all{}", runtime::Name(counter), value - logged_[i], value,
                  from.empty() ? "" : "; source " + from);
    } else {
      growing_s_[i] = 0;
    }
    logged_[i] = value;
  }
}

// Sets the status line of `systemctl status`.
void Supervisor::ReportStatus(double seconds) {
  const std::uint64_t frames = counters_.Get(runtime::Counter::kPipelineFrames);
  std::string line = fmt::format("{} performers, {:.0f} frames/s; publishing on {}, control on {}",
                                 counters_.Get(runtime::Counter::kPipelinePerformers),
                                 static_cast<double>(frames - frames_said_) / seconds,
                                 publish_endpoint_, control_endpoint_);
  if (const std::string refused = files_->refused(); !refused.empty()) {
    line += "; the last reload was refused: " + refused;
  }
  frames_said_ = frames;
  notifier_.SetStatus(line);
}

}  // namespace styled
