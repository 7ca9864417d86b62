#include "daemon/replay/replay.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "daemon/config/sources.h"
#include "daemon/looks/state_file.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/host_port.h"
#include "daemon/source/cut_reader.h"
#include "daemon/source/delay.h"
#include "daemon/source/native_decoder.h"
#include "daemon/source/outbox.h"
#include "daemon/source/rigs/make.h"
#include "daemon/styles/make_config.h"
#include "daemon/styles/networks.h"
#include "daemon/styles/style_requests.h"
#include "model/base/text.h"
#include "proto/recording/writer.h"
#include "proto/rigs/native/stream_reader.h"
#include "proto/rigs/types.h"

namespace styled::replay {
namespace {

constexpr int kSubscriptions = 100;

class RecordedClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = 0;
};

class Collector final : public publish::Publisher {
 public:
  Collector(const runtime::Clock& clock, std::string subscription, const Sink& sink)
      : clock_(clock), subscription_(std::move(subscription)), sink_(sink) {}
  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override {
    if (topic != "stats/") sink_(clock_.Now_ns(), topic, payload);
  }
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    event = {true, subscription_};
    return std::exchange(asking_, false);
  }
  int fd() const override { return -1; }

 private:
  const runtime::Clock& clock_;
  std::string subscription_;
  const Sink& sink_;
  bool asking_ = true;
};

// Parses a recorded peer, e.g. "127.0.0.1:9763". Any other text gives a peer without an address,
// but with an id of its own.
source::Peer ParsePeer(const std::string& text) {
  source::Peer peer;
  peer.id = std::hash<std::string>()(text) | 1U;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const auto parsed = runtime::ParseHostPort(text);
  if (!parsed.ok()) return peer;
  address.sin_port = htons(parsed.value().port);
  if (inet_pton(AF_INET, parsed.value().host.c_str(), &address.sin_addr) != 1) return peer;
  std::memcpy(&peer.address, &address, sizeof address);
  peer.address_size = sizeof address;
  return peer;
}

// `sender`: the first recorded sender of the source. It stands for a NatNet server that the
// configuration gives by host name.
std::unique_ptr<source::Translator> MakeTranslator(config::Source config,
                                                   const std::string& sender) {
  const rigs::RigType& rig = *rigs::FindSourceType(config.type)->rig;
  const bool named = !config::ParseServer(config.server, rig.server_port).ok();
  if (rig.asks_server && named) config.server = sender;
  return source::MakeTranslator(config);
}

// Whether arrivals are pieces of a stream. Data from a server to which the daemon connected is
// recorded as records.
bool IsStream(const std::string& type) {
  const rigs::SourceType& known = *rigs::FindSourceType(type);
  return (known.stream && !known.connects()) || type == rigs::kNative.usb;
}

// One source whose recorded arrivals replace its socket or device. TCP streams, and the data of USB
// devices with the native protocol, are cut into records here.
class Recorded final : public source::Transport {
 public:
  Recorded(const config::Source& config, int source, const std::string& sender,
           runtime::Clock& clock, runtime::Counters& counters)
      : clock_(clock),
        stream_(IsStream(config.type)),
        translator_(MakeTranslator(config, sender)),
        decoder_(source, counters),
        outbox_(source, counters) {}

  void Push(const recording::Arrival& arrival) { waiting_.push_back(arrival); }

  int DoWork(source::Receiver& receiver) override {
    const bool due = clock_.Now_ns() >= NextDeadline_ns();
    if (waiting_.empty() && !due) return 0;
    if (!waiting_.empty()) {
      const recording::Arrival arrival = std::move(waiting_.front());
      waiting_.pop_front();
      Deliver(arrival, receiver);
    }
    if (translator_ != nullptr) {
      outbox_.Open(receiver, -1);
      translator_->Tick(clock_.Now_ns(), outbox_);
      outbox_.Close();
    }
    return 1;
  }
  std::int64_t NextDeadline_ns() const override {
    return translator_ == nullptr ? source::Translator::kNever : translator_->NextDeadline_ns();
  }
  bool has_sensors() const override { return translator_ != nullptr && translator_->has_sensors(); }
  Status Calibrate(source::Calibration what, std::int64_t now_ns) override {
    return translator_->Calibrate(what, now_ns);
  }
  int fd() const override { return -1; }
  const std::string& endpoint() const override { return endpoint_; }
  std::uint64_t received() const override { return 0; }

 private:
  struct Connection {
    std::vector<std::byte> buffer = std::vector<std::byte>(2 * native::kMaxDatagramSize);
    native::StreamReader ours{buffer};
    source::CutReader rigs{buffer};
  };

  void Deliver(const recording::Arrival& arrival, source::Receiver& receiver) {
    const auto bytes = std::as_bytes(std::span(arrival.datagram()));
    const source::Peer peer = ParsePeer(arrival.peer());
    if (!stream_) return HandOn(bytes, peer, receiver);
    Connection& connection = connections_[arrival.peer()];
    if (translator_ == nullptr) {
      Cut(connection.ours, bytes, peer, receiver);
    } else {
      Cut(connection.rigs, bytes, peer, receiver);
    }
    // Feeds the bytes piecewise through the stream's reader, because they may exceed its free
    // space.
  }
  template <typename Reader>
  void Cut(Reader& reader, std::span<const std::byte> bytes, const source::Peer& peer,
           source::Receiver& receiver) {
    while (!bytes.empty()) {
      const auto space = reader.Space();
      const std::size_t size = std::min(space.size(), bytes.size());
      std::copy_n(bytes.begin(), size, space.begin());
      reader.Received(size);
      bytes = bytes.subspan(size);
      std::span<const std::byte> record;
      auto result = reader.Next(record);
      for (; result == Reader::Result::kRecord; result = reader.Next(record)) {
        HandOn(record, peer, receiver);
      }
      if (result == Reader::Result::kBroken) return;
    }
  }
  void HandOn(std::span<const std::byte> bytes, const source::Peer& peer,
              source::Receiver& receiver) {
    if (translator_ == nullptr) {
      const source::Machine machine = source::MachineOf(peer.address);
      return decoder_.HandOn({&bytes, 1}, {&machine, 1}, receiver);
    }
    outbox_.Open(receiver, -1);
    translator_->Handle(bytes, peer, clock_.Now_ns(), outbox_);
    outbox_.Close();
  }

  runtime::Clock& clock_;
  bool stream_;
  std::unique_ptr<source::Translator> translator_;
  source::NativeDecoder decoder_;
  source::Outbox outbox_;
  std::deque<recording::Arrival> waiting_;
  std::map<std::string, Connection> connections_;
  std::string endpoint_;
};

// Sources may share a name, but not both name and type.
std::string KeyOf(const std::string& name, const std::string& type) { return name + " " + type; }

// A replay reads the library's styles and does not change its files.
std::shared_ptr<const pipeline::RuntimeConfig> WithoutLibrary(
    const pipeline::RuntimeConfig& config) {
  auto without = std::make_shared<pipeline::RuntimeConfig>(config);
  without->style.library.clear();
  return without;
}

// The recorded decisions about frames that are yet to be played, by the frame's numbers.
class Decisions final : public pipeline::RecordedDecisions {
 public:
  explicit Decisions(std::vector<std::string> source_names)
      : source_names_(std::move(source_names)) {}

  void Add(const recording::Decided& decided) {
    for (const v1::FrameFate& fate : decided.frames()) {
      fates_[{fate.performer(), fate.source_sequence(), fate.is_body()}].push_back(fate);
    }
  }
  std::span<const decide::FrameInTransit> Of(int source,
                                             std::span<const source::SourceFrame> frames) override {
    found_.clear();
    for (const source::SourceFrame& frame : frames) {
      const Key key{
          source_names_[static_cast<std::size_t>(source)] + "." + std::string(frame.performer),
          frame.sequence, frame.is_body};
      const auto fate = fates_.find(key);
      if (fate == fates_.end()) return {};
      found_.push_back(DecidedAs(fate->second.front()));
      fate->second.pop_front();
      if (fate->second.empty()) fates_.erase(fate);
    }
    return found_;
  }

 private:
  // Performer, the sender's number, whether it is a body.
  using Key = std::tuple<std::string, std::uint64_t, bool>;

  static decide::FrameInTransit DecidedAs(const v1::FrameFate& fate) {
    decide::FrameInTransit frame;
    frame.decision.fate = fate.fate();
    frame.decision.late = (fate.flags() & v1::FLAG_LATE) != 0;
    frame.decision.relieved = fate.relieved();
    frame.decision.sequence = fate.sequence();
    return frame;
  }

  std::vector<std::string> source_names_;
  std::map<Key, std::deque<v1::FrameFate>> fates_;
  std::vector<decide::FrameInTransit> found_;  // of the last call
};

class Player {
 public:
  Player(const config::Config& config,
         const std::shared_ptr<const pipeline::RuntimeConfig>& runtime_config,
         const Options& options, const std::map<std::string, std::string>& senders,
         runtime::Counters& counters, const Sink& sink)
      : commands_(options.commands),
        collector_(clock_, options.subscription, sink),
        runtime_config_(WithoutLibrary(*runtime_config)) {
    std::vector<std::string> names;
    std::vector<std::unique_ptr<source::Transport>> transports;
    for (std::size_t i = 0; i < config.sources.size(); ++i) {
      const auto& source = config.sources[i];
      const std::string key = KeyOf(source.name, source.type);
      const auto sender = senders.find(key);
      auto recorded = std::make_unique<Recorded>(source, static_cast<int>(i),
                                                 sender == senders.end() ? "" : sender->second,
                                                 clock_, counters);
      sources_[key] = recorded.get();
      names.push_back(source.name);
      transports.push_back(std::move(recorded));
      if (source.delay_s > 0) {
        transports.back() =
            source::MakeDelayed(std::move(transports.back()), source.delay_s, clock_);
      }
    }
    pipeline::Dependencies dependencies{clock_,  counters, collector_, mailboxes_,
                                        nullptr, false,    false};
    if (options.decided) {
      decisions_ = std::make_unique<Decisions>(names);
      dependencies.decisions = decisions_.get();
    }
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        dependencies, std::move(names), std::move(transports), runtime_config_, 1, kSubscriptions);
    pipeline_->SetLayers(config.sources);
    pipeline_->Restore(options.profiles);
  }

  Status Play(const recording::Record& record) {
    if (record.has_decided() && decisions_ == nullptr) return Status::Ok();
    PassTimeUntil(record.time_ns());
    if (record.decided().has_silence()) {
      pipeline_->OnSilence(record.decided().silence());
    } else if (record.has_decided()) {
      decisions_->Add(record.decided());
      Deliver(record.decided().source());
    } else if (record.has_arrival()) {
      const auto found = sources_.find(KeyOf(record.arrival().source(), record.arrival().type()));
      if (found == sources_.end()) {
        return Status::Error("arrival of source " + record.arrival().source() + " (" +
                             record.arrival().type() + "), which is not in the configuration");
      }
      if (decisions_ != nullptr) {
        undecided_.push_back(record.arrival());
        return Status::Ok();
      }
      found->second->Push(record.arrival());
    } else if (record.has_command() && commands_) {
      auto exchange = std::make_unique<pipeline::Exchange>();
      exchange->request = record.command().request();
      // A recorded take is replaced by its code.
      if (pipeline::IsStyleRequest(exchange->request)) {
        DoStyleRequest(std::move(exchange));
      } else {
        (void)mailboxes_.commands.Push(std::move(exchange));
      }
    }
    Work();
    return Status::Ok();
  }
  // Continues for 0.2 s after the last record, for the work that is due by time.
  void Finish() {
    Deliver("");
    PassTimeUntil(clock_.now_ns + runtime::kSecond_ns / 5);
  }

 private:
  // Delivers the arrivals of a source, or of all with "", whose decisions are known by now.
  void Deliver(const std::string& source) {
    for (auto arrival = undecided_.begin(); arrival != undecided_.end();) {
      if (!source.empty() && arrival->source() != source) {
        ++arrival;
        continue;
      }
      sources_.at(KeyOf(arrival->source(), arrival->type()))->Push(*arrival);
      arrival = undecided_.erase(arrival);
    }
    Work();
  }
  // Replaces the supervisor.
  void DoStyleRequest(std::unique_ptr<pipeline::Exchange> exchange) {
    auto made = style_requests_.Do(*runtime_config_, *exchange);
    if (made != nullptr) runtime_config_ = made;
    (void)mailboxes_.reloads.Push({std::move(made), std::move(exchange)});
  }
  void PassTimeUntil(std::int64_t time_ns) {
    if (clock_.now_ns == 0) clock_.now_ns = time_ns;
    while (pipeline_->NextDeadline_ns() <= time_ns) {
      const std::int64_t before_ns =
          std::exchange(clock_.now_ns, std::max(clock_.now_ns, pipeline_->NextDeadline_ns()));
      Work();
      // A deadline that does not advance would stop the time for ever.
      if (pipeline_->NextDeadline_ns() <= clock_.now_ns && before_ns == clock_.now_ns) break;
    }
    clock_.now_ns = std::max(clock_.now_ns, time_ns);
  }
  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
    std::unique_ptr<pipeline::Exchange> answered;
    while (mailboxes_.replies.Pop(answered)) {
    }
    pipeline::Event event;
    while (mailboxes_.events.Pop(event)) {
    }
  }

  bool commands_;
  RecordedClock clock_;
  Collector collector_;
  pipeline::Mailboxes mailboxes_;
  std::shared_ptr<const pipeline::RuntimeConfig> runtime_config_;
  pipeline::StyleRequests style_requests_;
  std::map<std::string, Recorded*> sources_;
  std::unique_ptr<Decisions> decisions_;      // with Options::decided
  std::deque<recording::Arrival> undecided_;  // arrivals before the decisions about them
  std::unique_ptr<pipeline::Pipeline> pipeline_;
};

// The first sender of each source.
std::map<std::string, std::string> FirstSenders(recording::Reader& reader, std::size_t sources) {
  std::map<std::string, std::string> senders;
  recording::Record record;
  while (senders.size() < sources && reader.Next(record)) {
    const auto& arrival = record.arrival();
    if (record.has_arrival()) {
      senders.emplace(KeyOf(arrival.source(), arrival.type()), arrival.peer());
    }
  }
  return senders;
}

std::string Counts(const runtime::Counters& counters) {
  std::string text;
  for (int i = 0; i < static_cast<int>(runtime::Counter::kCount); ++i) {
    const auto counter = static_cast<runtime::Counter>(i);
    const std::uint64_t value = counters.Get(counter);
    if (!IsOfTheMotion(counter) || value == 0) continue;
    text += " " + std::string(runtime::Name(counter)) + "=" + std::to_string(value);
  }
  return text;
}

}  // namespace

bool IsOfTheMotion(runtime::Counter counter) {
  using runtime::Counter;
  switch (counter) {
    case Counter::kPipelineLongestCycleUs:
    case Counter::kPipelineOverBudget:
    case Counter::kPipelineOverBudgetFrames:
    case Counter::kPipelineOverloadBypassed:
    case Counter::kPipelineWallClockSteps:
      return false;
    default:
      break;
  }
  const std::string_view name = runtime::Name(counter);
  return name.starts_with("source.") || name.starts_with("pipeline.") ||
         name.starts_with("stylist.");
}

Result<config::Config> ConfigOf(const recording::Reader& reader,
                                const std::vector<config::Override>& overrides) {
  if (reader.header().config().empty()) {
    return Status::Error(reader.name() +
                         ": contains no configuration; expected --config with the one that it was "
                         "recorded under");
  }
  auto config =
      config::Parse(reader.header().config(), reader.name() + ": its configuration", overrides);
  // A recording without `open` beside its weights is replayed without, unless it is named.
  const std::string& weights = reader.header().weights();
  if (config.ok() && config.value().model.gaits.empty() && !weights.empty() &&
      weights.find("open.safetensors") == std::string::npos) {
    config.value().model.gaits = "none";
  }
  return config;
}

Status Replay(recording::Reader& reader, const config::Config& config,
              const std::shared_ptr<const pipeline::RuntimeConfig>& runtime_config,
              const Options& options, runtime::Counters& counters, const Sink& sink) {
  reader.Rewind();
  const auto senders = FirstSenders(reader, config.sources.size());
  if (senders.empty()) {
    return Status::Error(reader.name() +
                         ": found no data from a rig, expected a recording of the "
                         "daemon ([record]) or of stylerec receive");
  }
  Player player(config, runtime_config, options, senders, counters, sink);
  reader.Rewind();
  recording::Record record;
  while (reader.Next(record)) {
    const Status status = player.Play(record);
    if (!status.ok()) return Status::Error(reader.name() + ": " + status.message());
  }
  player.Finish();
  return Status::Ok();
}

Result<std::string> ReplayToFile(recording::Reader& reader, const config::Config& config,
                                 const std::string& file, bool decided) {
  std::uint32_t crc = 0;
  auto runtime_config = pipeline::MakeRuntimeConfig(config, nullptr, crc);
  if (!runtime_config.ok()) return runtime_config.status();
  const auto weights = pipeline::FindWeightsFiles(config.model);
  if (!weights.ok()) return weights.status();
  const auto label = pipeline::LabelOf(config.model, weights.value());
  if (!label.ok()) return label.status();
  Options options;
  options.decided = decided;
  auto profiles = pipeline::ParseProfiles(reader.header().state(), reader.name() + ": its state");
  if (!profiles.ok()) return profiles.status();
  options.profiles = std::move(profiles.value());

  const auto range = reader.FindTimeRange();
  if (!range.any) return Status::Error(reader.name() + ": found no records, expected arrivals");
  recording::FileHeader header = reader.header();
  header.set_program("styled --replay");
  header.set_version(STYLED_VERSION);
  header.set_weights(label.value().names);
  header.set_weights_hash(label.value().hashes);
  auto writer = recording::FileWriter::Create(file, header);
  if (!writer.ok()) return writer.status();

  Status written = Status::Ok();
  std::uint64_t messages = 0;
  recording::Record record;
  runtime::Counters counters;
  const Status status =
      Replay(reader, config, runtime_config.value(), options, counters,
             [&](std::int64_t time_ns, std::string_view topic, std::span<const std::byte> payload) {
               if (!written.ok()) return;
               record.set_time_ns(time_ns);
               record.mutable_published()->set_topic(topic.data(), topic.size());
               record.mutable_published()->set_payload(payload.data(), payload.size());
               written = writer.value()->Add(record, time_ns);
               ++messages;
             });
  if (written.ok()) written = writer.value()->Flush();
  if (!status.ok() || !written.ok()) {
    std::error_code error;
    std::filesystem::remove(file, error);  // so that the next attempt can use the name
    return status.ok() ? written : status;
  }
  const double seconds = static_cast<double>(range.last_ns - range.first_ns) * 1e-9;
  std::string said = reader.name() + ": seconds=" + NumberText(seconds, 3) +
                     " messages=" + std::to_string(messages) + Counts(counters);
  const std::string& recorded = reader.header().weights_hash();
  if (!recorded.empty() && recorded != header.weights_hash()) {
    said += "\nrecorded with other weights: " + reader.header().weights() + ", " + recorded +
            "; these are " + header.weights() + ", " + header.weights_hash();
  }
  return said;
}

}  // namespace styled::replay
