#include "daemon/source/tcp.h"

#include <netinet/tcp.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <vector>

#include "daemon/source/sockets.h"
#include "proto/rigs/native/stream_reader.h"

namespace styled::source {
namespace {

using native::StreamReader;
using runtime::Counter;

struct Connection {
  explicit Connection(Descriptor connected)
      : socket(std::move(connected)), buffer(2 * native::kMaxDatagramSize), reader(buffer) {}
  Descriptor socket;
  std::vector<std::byte> buffer;
  StreamReader reader;
};

class Tcp final : public Transport {
 public:
  Tcp(Descriptor listener, Descriptor epoll, const config::Source& config, int source,
      runtime::Counters& counters)
      : listener_(std::move(listener)),
        epoll_(std::move(epoll)),
        source_(source),
        max_connections_(static_cast<std::size_t>(config.max_connections)),
        counters_(counters),
        endpoint_(BoundAddress(listener_.get())) {
    Watch(listener_.get(), nullptr);
  }

  // One epoll instance holds listener and connections; it is itself what the pipeline polls.
  int DoWork(Receiver& receiver) override {
    std::array<epoll_event, kBatch> events;
    const int ready = epoll_wait(epoll_.get(), events.data(), kBatch, 0);
    int work = 0;
    for (int i = 0; i < ready; ++i) {
      auto* connection = static_cast<Connection*>(events[static_cast<std::size_t>(i)].data.ptr);
      work += connection == nullptr ? Accept() : Receive(*connection, receiver);
    }
    return work;
  }

  int fd() const override { return epoll_.get(); }
  const std::string& endpoint() const override { return endpoint_; }

 private:
  bool Watch(int fd, Connection* connection) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = connection;
    return epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) == 0;
  }

  int Accept() {
    Descriptor socket(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) return 0;
    if (connections_.size() >= max_connections_) {
      counters_.Add(Counter::kSourceTcpRefused);
      return 1;
    }
    const int one = 1;
    setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    setsockopt(socket.get(), SOL_SOCKET, SO_KEEPALIVE, &one, sizeof one);
    auto connection = std::make_unique<Connection>(std::move(socket));
    if (Watch(connection->socket.get(), connection.get())) {
      connections_.push_back(std::move(connection));
      counters_.Add(Counter::kSourceTcpAccepted);
    }
    return 1;
  }

  // One read, and all the records that it completes.
  int Receive(Connection& connection, Receiver& receiver) {
    const auto space = connection.reader.Space();
    const auto size = recv(connection.socket.get(), space.data(), space.size(), 0);
    if (size <= 0) {
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
      if (connection.reader.Pending() > 0) counters_.Add(Counter::kSourceTcpCutShort);
      Close(connection);
      return 1;
    }
    connection.reader.Received(static_cast<std::size_t>(size));
    int work = 1;
    while (true) {
      std::size_t count = 0;
      auto result = StreamReader::Result::kRecord;
      while (count < kBatch) {
        result = connection.reader.Next(records_[count]);
        if (result != StreamReader::Result::kRecord) break;
        ++count;
      }
      if (count > 0) receiver.OnDatagrams(source_, {records_.data(), count});
      work += static_cast<int>(count);
      if (result == StreamReader::Result::kNeedMore) return work;
      if (result == StreamReader::Result::kBroken) {
        counters_.Add(runtime::CounterOf(connection.reader.Broken()));
        counters_.Add(Counter::kSourceTcpBroken);
        Close(connection);
        return work;
      }
    }
  }

  void Close(Connection& connection) {
    std::erase_if(connections_, [&](const auto& owned) { return owned.get() == &connection; });
  }

  Descriptor listener_, epoll_;
  int source_;
  std::size_t max_connections_;
  runtime::Counters& counters_;
  std::string endpoint_;
  std::vector<std::unique_ptr<Connection>> connections_;
  std::array<std::span<const std::byte>, kBatch> records_;
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeTcp(const config::Source& config, int source,
                                           runtime::Counters& counters) {
  auto listener = BindSocket(SOCK_STREAM, config.listen, config.receive_buffer_bytes);
  if (!listener.ok()) return listener.status();
  if (listen(listener.value().get(), 64) != 0) {
    return Status::Error("tcp " + config.listen + ": in use (another styled?)");
  }
  Descriptor epoll(epoll_create1(EPOLL_CLOEXEC));
  if (epoll.get() < 0) return Status::Error("tcp " + config.listen + ": no file descriptor left");
  return std::unique_ptr<Transport>(std::make_unique<Tcp>(
      std::move(listener.value()), std::move(epoll), config, source, counters));
}

}  // namespace styled::source
