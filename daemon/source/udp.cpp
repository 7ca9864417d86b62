#include "daemon/source/udp.h"

#include "daemon/source/native_decoder.h"
#include "daemon/source/udp_socket.h"

namespace styled::source {
namespace {

// Native datagrams.
class Udp final : public Transport {
 public:
  Udp(Descriptor socket, const config::Source& config, int source, runtime::Clock& clock,
      runtime::Counters& counters)
      : socket_(std::move(socket), source, clock, counters, config.sender_limit_hz),
        source_(source),
        decoder_(source, counters) {}

  int DoWork(Receiver& receiver) override {
    const auto datagrams = socket_.Receive();
    if (datagrams.empty()) return 0;
    socket_.Announce(source_, receiver);
    decoder_.HandOn(datagrams, socket_.machines(), receiver, socket_.arrivals_ns());
    return static_cast<int>(datagrams.size());
  }

  int fd() const override { return socket_.fd(); }
  const std::string& endpoint() const override { return socket_.endpoint(); }
  std::uint64_t received() const override { return socket_.received(); }
  void Sample() override { socket_.ReadDrops(); }
  std::uint64_t kernel_dropped() const override { return socket_.kernel_dropped(); }

 private:
  UdpSocket socket_;
  int source_;
  NativeDecoder decoder_;
};

// A rig's datagrams, through its translator.
class TranslatedUdp final : public Transport {
 public:
  TranslatedUdp(Descriptor socket, const config::Source& config, int source, runtime::Clock& clock,
                runtime::Counters& counters, std::unique_ptr<Translator> translator)
      : socket_(std::move(socket), source, clock, counters, config.sender_limit_hz),
        source_(source),
        translator_(std::move(translator)),
        outbox_(source, counters) {}

  int DoWork(Receiver& receiver) override {
    const auto datagrams = socket_.Receive();
    const std::int64_t until_ns = socket_.read_until_ns();
    const bool due = until_ns >= translator_->NextDeadline_ns();
    if (datagrams.empty() && !due) return 0;
    socket_.Announce(source_, receiver);
    outbox_.Open(receiver, socket_.fd());
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      translator_->Handle(datagrams[i], socket_.Sender(i), socket_.arrived_ns(i), outbox_);
    }
    translator_->Tick(until_ns, outbox_);
    outbox_.Close();
    return static_cast<int>(datagrams.size()) + (due ? 1 : 0);
  }

  std::int64_t NextDeadline_ns() const override { return translator_->NextDeadline_ns(); }
  bool has_sensors() const override { return translator_->has_sensors(); }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return translator_->Calibrate(what, now_ns);
  }
  int fd() const override { return socket_.fd(); }
  const std::string& endpoint() const override { return socket_.endpoint(); }
  std::uint64_t received() const override { return socket_.received(); }
  void Sample() override { socket_.ReadDrops(); }
  std::uint64_t kernel_dropped() const override { return socket_.kernel_dropped(); }

 private:
  UdpSocket socket_;
  int source_;
  std::unique_ptr<Translator> translator_;
  Outbox outbox_;
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeUdp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator) {
  auto socket = runtime::BindSocket(SOCK_DGRAM, config.listen, config.receive_buffer_bytes);
  if (!socket.ok()) return socket.status();
  if (translator == nullptr) {
    return std::unique_ptr<Transport>(
        std::make_unique<Udp>(std::move(socket.value()), config, source, clock, counters));
  }
  return std::unique_ptr<Transport>(std::make_unique<TranslatedUdp>(
      std::move(socket.value()), config, source, clock, counters, std::move(translator)));
}

}  // namespace styled::source
