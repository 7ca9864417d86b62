#include "daemon/source/tcp_client.h"

#include <netinet/tcp.h>
#include <poll.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>

#include "daemon/config/sources.h"
#include "daemon/runtime/sockets.h"
#include "daemon/source/note_limit.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using runtime::AddressText;
using runtime::BindSocket;
using runtime::Counter;
using runtime::kSecond_ns;

// Bound of a cycle. A frame of sixteen skeletons with fingers has 30 KB.
constexpr std::size_t kClientReadBytes = 65536;
constexpr std::int64_t kConnectTimeout_ns = 5 * kSecond_ns;
constexpr std::int64_t kFirstPause_ns = kSecond_ns, kLongestPause_ns = 5 * kSecond_ns;
// A server without a measurement sends nothing for hours, so the kernel probes the connection:
// after 5 s of silence, five times, a second apart.
constexpr int kIdle_s = 5, kProbe_s = 1, kProbes = 5;

class TcpClient final : public Transport {
 public:
  TcpClient(Descriptor epoll, const config::Source& config, int source, const sockaddr_in& server,
            runtime::Clock& clock, runtime::Counters& counters,
            std::unique_ptr<ServerTranslator> translator)
      : epoll_(std::move(epoll)),
        listen_(config.listen),
        receive_buffer_bytes_(config.receive_buffer_bytes),
        source_(source),
        server_(server),
        clock_(clock),
        counters_(counters),
        translator_(std::move(translator)),
        outbox_(source, counters),
        capacity_(translator_->max_record() + kClientReadBytes),
        buffer_(std::make_unique_for_overwrite<std::byte[]>(capacity_)),
        reader_({buffer_.get(), capacity_}, translator_->cutter()) {
    std::memcpy(&peer_.address, &server, sizeof server);
    peer_.address_size = sizeof server;
    endpoint_ = AddressText(peer_.address, peer_.address_size);
  }

  int DoWork(Receiver& receiver) override {
    const std::int64_t now_ns = clock_.Now_ns();
    switch (state_) {
      case State::kWaiting:
        return now_ns < next_ns_ ? 0 : Begin(now_ns, receiver);
      case State::kConnecting:
        return Finish(now_ns, receiver);
      case State::kConnected:
        break;
    }
    const int work = Receive(now_ns, receiver);
    if (state_ != State::kConnected) return work;
    outbox_.Open(receiver, socket_.get());
    translator_->Tick(now_ns, outbox_);
    outbox_.Close();
    return work + CheckDialogue(now_ns, receiver);
  }

  std::int64_t NextDeadline_ns() const override {
    return state_ == State::kConnected ? translator_->NextDeadline_ns() : next_ns_;
  }
  // One epoll instance holds the socket, which changes with every connection.
  int fd() const override { return epoll_.get(); }
  // The server's address.
  const std::string& endpoint() const override { return endpoint_; }
  std::uint64_t received() const override { return received_; }

 private:
  enum class State { kWaiting, kConnecting, kConnected };

  // Starts a connection.
  int Begin(std::int64_t now_ns, Receiver& receiver) {
    auto bound = BindSocket(SOCK_STREAM, listen_, receive_buffer_bytes_);
    if (!bound.ok()) return Lose(bound.status().message(), now_ns, receiver);
    socket_ = std::move(bound.value());
    const auto set = [this](int level, int option, int value) {
      setsockopt(socket_.get(), level, option, &value, sizeof value);
    };
    set(IPPROTO_TCP, TCP_NODELAY, 1);
    set(SOL_SOCKET, SO_KEEPALIVE, 1);
    set(IPPROTO_TCP, TCP_KEEPIDLE, kIdle_s);
    set(IPPROTO_TCP, TCP_KEEPINTVL, kProbe_s);
    set(IPPROTO_TCP, TCP_KEEPCNT, kProbes);
    set(IPPROTO_TCP, TCP_USER_TIMEOUT, 1000 * (kIdle_s + kProbe_s * kProbes));
    state_ = State::kConnecting;
    next_ns_ = now_ns + kConnectTimeout_ns;
    const int error =
        connect(socket_.get(), reinterpret_cast<const sockaddr*>(&server_), sizeof server_) == 0
            ? 0
            : errno;
    if (error != 0 && error != EINPROGRESS) return Lose(std::strerror(error), now_ns, receiver);
    Watch(EPOLL_CTL_ADD, EPOLLOUT);
    return 1 + Finish(now_ns, receiver);
  }

  // Checks whether the connection has been made.
  int Finish(std::int64_t now_ns, Receiver& receiver) {
    pollfd waiting{socket_.get(), POLLOUT, 0};
    if (poll(&waiting, 1, 0) != 1) {
      if (now_ns < next_ns_) return 0;
      return Lose("does not answer, " + std::to_string(kConnectTimeout_ns / kSecond_ns) + " s long",
                  now_ns, receiver);
    }
    int error = 0;
    socklen_t size = sizeof error;
    getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return Lose(std::strerror(error), now_ns, receiver);
    Watch(EPOLL_CTL_MOD, EPOLLIN);
    state_ = State::kConnected;
    was_ready_ = false;
    ++peer_.id;
    reader_.Clear();
    counters_.AddOf(source_, Counter::kSourceTcpAccepted);
    translator_->Connected(now_ns);
    return 1;
  }

  int Receive(std::int64_t now_ns, Receiver& receiver) {
    const auto all = reader_.Space();
    const auto space = all.first(std::min(all.size(), kClientReadBytes));
    const auto size = recv(socket_.get(), space.data(), space.size(), 0);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    if (size <= 0) {
      const std::string why = size < 0 ? std::strerror(errno) : "closed the connection";
      if (reader_.Pending() > 0) counters_.AddOf(source_, Counter::kSourceTcpCutShort);
      return Lose(why, now_ns, receiver);
    }
    reader_.Received(static_cast<std::size_t>(size));
    int work = 1;
    auto result = CutReader::Result::kRecord;
    while (result == CutReader::Result::kRecord) {
      std::size_t count = 0;
      while (count < kBatch) {
        result = reader_.Next(records_[count]);
        if (result != CutReader::Result::kRecord) break;
        ++count;
      }
      HandOn(std::span(records_).first(count), now_ns, receiver);
      work += static_cast<int>(count);
      if (CheckDialogue(now_ns, receiver) > 0) return work;
    }
    if (result == CutReader::Result::kBroken) {
      ++received_;
      counters_.AddOf(source_, Counter::kSourceMalformed);
      counters_.AddOf(source_, Counter::kSourceTcpBroken);
      Lose("sent " + translator_->WhyBroken(reader_.PendingBytes()), now_ns, receiver);
    }
    return work;
  }

  void HandOn(std::span<const std::span<const std::byte>> records, std::int64_t now_ns,
              Receiver& receiver) {
    received_ += records.size();
    for (const auto record : records) {
      const runtime::HotSection hot;
      receiver.OnArrival({source_, now_ns, record,
                          reinterpret_cast<const sockaddr*>(&peer_.address), peer_.address_size});
    }
    outbox_.Open(receiver, socket_.get());
    for (const auto record : records) translator_->Handle(record, peer_, now_ns, outbox_);
    outbox_.Close();
  }

  // Returns 1 if the connection has been closed.
  int CheckDialogue(std::int64_t now_ns, Receiver& receiver) {
    if (const std::string fault = translator_->NextFault(); !fault.empty()) {
      Lose(fault, now_ns, receiver);
      return 1;
    }
    if (was_ready_ || !translator_->ready()) return 0;
    was_ready_ = true;
    pause_ns_ = kFirstPause_ns;
    if (complaint_.empty()) return 0;
    complaint_.clear();
    if (const auto times = again_notes_.Count(now_ns)) {
      receiver.OnNotice(source_, "server " + endpoint_ + ": connected again" + Times(times));
    }
    return 0;
  }

  int Lose(const std::string& why, std::int64_t now_ns, Receiver& receiver) {
    socket_ = Descriptor();
    state_ = State::kWaiting;
    next_ns_ = now_ns + pause_ns_;
    pause_ns_ = std::min(2 * pause_ns_, kLongestPause_ns);
    if (why == complaint_) return 1;
    complaint_ = why;
    if (const auto times = lost_notes_.Count(now_ns)) {
      receiver.OnNote(source_, "server " + endpoint_ + ": " + why + "; trying again every " +
                                   std::to_string(kLongestPause_ns / kSecond_ns) + " s" +
                                   Times(times));
    }
    return 1;
  }

  void Watch(int operation, std::uint32_t events) {
    epoll_event event{};
    event.events = events;
    epoll_ctl(epoll_.get(), operation, socket_.get(), &event);
  }

  Descriptor epoll_, socket_;
  std::string listen_;
  int receive_buffer_bytes_, source_;
  sockaddr_in server_;
  Peer peer_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  std::unique_ptr<ServerTranslator> translator_;
  Outbox outbox_;
  std::size_t capacity_;
  std::unique_ptr<std::byte[]> buffer_;  // untouched pages cost nothing, unless memory is locked
  CutReader reader_;
  std::string endpoint_, complaint_;
  State state_ = State::kWaiting;
  std::int64_t next_ns_ = 0;  // kWaiting: the next attempt; kConnecting: the end of this attempt
  std::int64_t pause_ns_ = kFirstPause_ns;
  bool was_ready_ = false;
  std::uint64_t received_ = 0;
  // Limits the lines about a server that reconnects repeatedly.
  NoteLimit again_notes_, lost_notes_;
  std::array<std::span<const std::byte>, kBatch> records_;
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeTcpClient(const config::Source& config, int source,
                                                 runtime::Clock& clock, runtime::Counters& counters,
                                                 std::unique_ptr<Translator> translator) {
  const auto& rig = *rigs::FindSourceType(config.type)->rig;
  const auto server = config::ParseServer(config.server, rig.server_port);
  if (!server.ok()) return server.status();
  // Tried once here, so that a wrong address is an error at start-up.
  const auto bound = BindSocket(SOCK_STREAM, config.listen, config.receive_buffer_bytes);
  if (!bound.ok()) return bound.status();
  if (runtime::BoundAddress(bound.value().get()).starts_with('[')) {
    return Status::Error("tcp " + config.listen + ": expected an IPv4 address, like the server's");
  }
  Descriptor epoll(epoll_create1(EPOLL_CLOEXEC));
  if (epoll.get() < 0) {
    return Status::Error("server " + config.server + ": no file descriptor left");
  }
  assert(dynamic_cast<ServerTranslator*>(translator.get()) != nullptr);
  std::unique_ptr<ServerTranslator> of_server(static_cast<ServerTranslator*>(translator.release()));
  return std::unique_ptr<Transport>(std::make_unique<TcpClient>(
      std::move(epoll), config, source, server.value(), clock, counters, std::move(of_server)));
}

}  // namespace styled::source
