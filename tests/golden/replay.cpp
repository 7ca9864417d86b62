#include "tests/golden/replay.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <set>

#include "daemon/config/address.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/source/cut_reader.h"
#include "daemon/source/rigs/make.h"
#include "daemon/source/rigs/natnet.h"
#include "proto/rigs/native/stream_reader.h"
#include "tests/support/child.h"

namespace styled::golden {
namespace {

class RecordedClock final : public runtime::Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return now_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  std::int64_t now_ns = 0;
};

class Collector final : public publish::Publisher {
 public:
  explicit Collector(Played& played) : played_(played) {}
  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override {
    const auto size = static_cast<int>(payload.size());
    if (topic.starts_with("body/")) {
      v1::Body body;
      body.ParseFromArray(payload.data(), size);
      if (known_.insert({body.hash(), body.output()}).second) played_.bodies.push_back(body);
    } else if (topic != "stats/") {
      played_.frames[std::string(topic)].emplace_back().ParseFromArray(payload.data(), size);
    }
  }
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    event = {true, "styled/"};
    return std::exchange(asking_, false);
  }
  int fd() const override { return -1; }

 private:
  Played& played_;
  std::set<std::pair<std::uint64_t, int>> known_;
  bool asking_ = true;
};

// "127.0.0.1:9763" of a recording; nobody where it is something else.
source::Peer ParsePeer(const std::string& text) {
  source::Peer peer;
  peer.id = std::hash<std::string>()(text) | 1U;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const auto parsed = config::ParseHostPort(text);
  if (!parsed.ok()) return peer;
  address.sin_port = htons(parsed.value().port);
  if (inet_pton(AF_INET, parsed.value().host.c_str(), &address.sin_addr) != 1) return peer;
  std::memcpy(&peer.address, &address, sizeof address);
  peer.address_size = sizeof address;
  return peer;
}

std::unique_ptr<source::Translator> MakeTranslator(const config::Source& config) {
  if (config.type != "natnet") return source::MakeTranslator(config);
  const source::Peer server = ParsePeer(config.server);
  sockaddr_in address{};
  std::memcpy(&address, &server.address, sizeof address);
  in_addr group{};
  inet_pton(AF_INET, config.group.c_str(), &group);
  return std::make_unique<source::NatNet>(config, address, group);
}

// One source, with what was recorded in place of its socket or device. Streams, and what vendors'
// USB devices send, are cut into records here.
class Recorded final : public source::Transport {
 public:
  Recorded(const config::Source& config, int source, runtime::Clock& clock,
           runtime::Counters& counters)
      : source_(source),
        clock_(clock),
        stream_(config::FindSourceType(config.type)->stream || config.type == "usb"),
        translator_(MakeTranslator(config)),
        outbox_(source, counters) {}

  void Push(const recording::Arrival& arrival) { waiting_.push_back(arrival); }

  int DoWork(source::Receiver& receiver) override {
    const bool due = clock_.Now_ns() >= NextDeadline_ns();
    if (waiting_.empty() && !due) return 0;
    if (!waiting_.empty()) {
      const recording::Arrival arrival = std::move(waiting_.front());
      waiting_.pop_front();
      Take(arrival, receiver);
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

  void Take(const recording::Arrival& arrival, source::Receiver& receiver) {
    const auto bytes = std::as_bytes(std::span(arrival.datagram()));
    const source::Peer peer = ParsePeer(arrival.peer());
    if (!stream_) return HandOn(bytes, peer, receiver);
    Connection& connection = connections_[arrival.peer()];
    if (translator_ == nullptr) {
      Cut(connection.ours, bytes, peer, receiver);
    } else {
      Cut(connection.rigs, bytes, peer, receiver);
    }
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
    if (translator_ == nullptr) return receiver.OnDatagrams(source_, {&bytes, 1});
    outbox_.Open(receiver, -1);
    translator_->Take(bytes, peer, clock_.Now_ns(), outbox_);
    outbox_.Close();
  }

  int source_;
  runtime::Clock& clock_;
  bool stream_;
  std::unique_ptr<source::Translator> translator_;
  source::Outbox outbox_;
  std::deque<recording::Arrival> waiting_;
  std::map<std::string, Connection> connections_;
  std::string endpoint_;
};

Result<config::Config> ConfigOf(const recording::FileHeader& header) {
  const support::TemporaryFolder folder;
  support::WriteText(folder / "styled.toml", header.config());
  return config::Load(folder / "styled.toml", {});
}

class Player {
 public:
  Player(const config::Config& config, std::shared_ptr<const pipeline::Live> live, Played& played)
      : collector_(played) {
    std::vector<std::string> names;
    std::vector<std::unique_ptr<source::Transport>> transports;
    for (std::size_t i = 0; i < config.sources.size(); ++i) {
      auto source =
          std::make_unique<Recorded>(config.sources[i], static_cast<int>(i), clock_, counters_);
      names.push_back(config.sources[i].name);
      // Sources may share a name, not name and type.
      sources_[config.sources[i].name + " " + config.sources[i].type] = source.get();
      transports.push_back(std::move(source));
    }
    pipeline_ = std::make_unique<pipeline::Pipeline>(
        pipeline::Surroundings{clock_, counters_, collector_, mailboxes_, nullptr, false, false},
        std::move(names), std::move(transports), std::move(live), 1, 100);
  }

  Status Take(const recording::Record& record, bool commands) {
    PassTimeUntil(record.time_ns());
    if (record.has_arrival()) {
      const auto found = sources_.find(record.arrival().source() + " " + record.arrival().type());
      if (found == sources_.end()) {
        return Status::Error("arrival of source " + record.arrival().source() + " (" +
                             record.arrival().type() + "), which is not in the configuration");
      }
      found->second->Push(record.arrival());
    } else if (record.has_command() && commands) {
      auto exchange = std::make_unique<pipeline::Exchange>();
      exchange->request = record.command().request();
      (void)mailboxes_.commands.Push(std::move(exchange));
    }
    Work();
    return Status::Ok();
  }
  // What time alone brings about after the last record.
  void Finish() { PassTimeUntil(clock_.now_ns + runtime::kSecond_ns / 5); }

  const runtime::Counters& counters() const { return counters_; }

 private:
  void PassTimeUntil(std::int64_t time_ns) {
    if (clock_.now_ns == 0) clock_.now_ns = time_ns;
    while (pipeline_->NextDeadline_ns() <= time_ns) {
      const std::int64_t before_ns =
          std::exchange(clock_.now_ns, std::max(clock_.now_ns, pipeline_->NextDeadline_ns()));
      Work();
      // A deadline that does not move on would hold time for ever.
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

  RecordedClock clock_;
  runtime::Counters counters_;
  Collector collector_;
  pipeline::Mailboxes mailboxes_;
  std::map<std::string, Recorded*> sources_;
  std::unique_ptr<pipeline::Pipeline> pipeline_;
};

bool IsOfTheMotion(std::string_view name) {
  if (name == "pipeline.longest_cycle_us" || name == "pipeline.over_budget_cycles") return false;
  return name.starts_with("source.") || name.starts_with("pipeline.") ||
         name.starts_with("stylist.");
}

}  // namespace

Result<Played> Replay(recording::Reader& reader, const std::string& weights,
                      const Options& options) {
  auto config = ConfigOf(reader.header());
  if (!config.ok()) return config.status();
  auto network = erd::Network::Load(weights);
  if (!network.ok()) return network.status();
  auto live = std::make_shared<pipeline::Live>();
  live->network = std::move(network.value());
  live->weights_name = weights;
  live->performers = config.value().performers;
  live->style = config.value().style;
  live->presets = config.value().presets;
  live->stylist = config.value().model.stylist;
  Played played;
  Player player(config.value(), std::move(live), played);
  reader.Rewind();
  recording::Record record;
  while (reader.Next(record)) {
    const Status status = player.Take(record, options.commands);
    if (!status.ok()) return Status::Error(reader.name() + ": " + status.message());
  }
  player.Finish();
  for (int i = 0; i < static_cast<int>(runtime::Counter::kCount); ++i) {
    const auto counter = static_cast<runtime::Counter>(i);
    const std::string name(runtime::Name(counter));
    if (IsOfTheMotion(name)) played.counters[name] = player.counters().Get(counter);
  }
  return played;
}

}  // namespace styled::golden
