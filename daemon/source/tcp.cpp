#include "daemon/source/tcp.h"

#include <netinet/tcp.h>
#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <type_traits>
#include <vector>

#include "daemon/runtime/sockets.h"
#include "daemon/source/arrival_clock.h"
#include "daemon/source/cut_reader.h"
#include "daemon/source/native_decoder.h"
#include "daemon/source/note_limit.h"
#include "proto/rigs/native/stream_reader.h"

namespace styled::source {
namespace {

using native::StreamReader;
using runtime::AddressText;
using runtime::BindSocket;
using runtime::BoundAddress;
using runtime::Counter;
using runtime::kSecond_ns;

// Bounds per cycle: the number of connections that are read, and the bytes read from each. A frame
// of 21 joints has 400 bytes, so that is some 330 frames.
constexpr int kReads = 8;
constexpr std::size_t kReadBytes = 16384;
// A new connection must send a whole record within this time, even if its bytes arrive slowly.
// Senders repeat skeleton or name once a second, so five were missed.
constexpr std::int64_t kFirstRecord_ns = 5 * kSecond_ns;
// A connection without a record for this long may be replaced by a new one. For a rig that sends at
// 1 Hz, four records may be late.
constexpr std::int64_t kSilent_ns = 5 * kSecond_ns;

// Reader is StreamReader for native records, CutReader for a rig's.
template <typename Reader>
class Tcp final : public Transport {
 public:
  Tcp(Descriptor listener, Descriptor epoll, const config::Source& config, int source,
      runtime::Clock& clock, runtime::Counters& counters, std::unique_ptr<Translator> translator)
      : listener_(std::move(listener)),
        epoll_(std::move(epoll)),
        source_(source),
        max_connections_(static_cast<std::size_t>(config.max_connections)),
        clock_(clock),
        counters_(counters),
        translator_(std::move(translator)),
        decoder_(source, counters),
        outbox_(source, counters),
        endpoint_(BoundAddress(listener_.get())) {
    Watch(listener_.get(), nullptr);
  }

  // One epoll instance holds the listener and all connections; the pipeline polls that instance.
  int DoWork(Receiver& receiver) override {
    std::array<epoll_event, kReads> events;
    const int ready = epoll_wait(epoll_.get(), events.data(), kReads, 0);
    int work = 0;
    for (int i = 0; i < ready; ++i) {
      auto* connection = static_cast<Connection*>(events[static_cast<std::size_t>(i)].data.ptr);
      work += connection == nullptr ? Accept(receiver) : Receive(*connection, receiver);
    }
    // If more events are waiting, a connection's first record may be among them.
    if (ready < kReads) work += CloseSilent(receiver);
    closed_.clear();
    return work;
  }

  std::int64_t NextDeadline_ns() const override {
    const auto oldest = OldestWithoutRecord();
    return oldest == connections_.end() ? Transport::NextDeadline_ns()
                                        : (*oldest)->accepted_ns + kFirstRecord_ns;
  }

  int fd() const override { return epoll_.get(); }
  const std::string& endpoint() const override { return endpoint_; }
  std::uint64_t received() const override { return received_; }

 private:
  struct Connection {
    Connection(Descriptor connected, std::uint64_t number, std::int64_t now_ns)
        : socket(std::move(connected)),
          buffer(2 * native::kMaxDatagramSize),
          reader(buffer),
          accepted_ns(now_ns),
          record_ns(now_ns) {
      peer.id = number;
    }
    std::string Who() const { return AddressText(address, address_size); }
    Descriptor socket;
    std::vector<std::byte> buffer;
    Reader reader;
    Peer peer;
    sockaddr_storage address{};  // the sender's; not in `peer`, because it cannot be answered
    socklen_t address_size = 0;
    std::int64_t accepted_ns,
        record_ns;  // when the last record came; before the first, accepted_ns
    bool any_record = false;
    ArrivalClock arrival;
    std::int64_t arrived_ns = 0;  // the last byte that was read
  };
  using Owned = std::unique_ptr<Connection>;
  using Connections = std::vector<Owned>;

  bool Watch(int fd, Connection* connection) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = connection;
    return epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) == 0;
  }

  int Accept(Receiver& receiver) {
    sockaddr_storage address{};
    socklen_t address_size = sizeof address;
    Descriptor socket(accept4(listener_.get(), reinterpret_cast<sockaddr*>(&address), &address_size,
                              SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) return 0;
    const std::int64_t now_ns = clock_.Now_ns();
    if (connections_.size() >= max_connections_ && !MakeRoom(now_ns, receiver)) {
      Refuse(AddressText(address, address_size), now_ns, receiver);
      return 1;
    }
    const int one = 1;
    setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    setsockopt(socket.get(), SOL_SOCKET, SO_KEEPALIVE, &one, sizeof one);
    setsockopt(socket.get(), SOL_SOCKET, SO_TIMESTAMPNS, &one, sizeof one);
    auto connection = std::make_unique<Connection>(std::move(socket), ++accepted_, now_ns);
    connection->address = address;
    connection->address_size = address_size;
    if (Watch(connection->socket.get(), connection.get())) {
      connections_.push_back(std::move(connection));
      counters_.AddOf(source_, Counter::kSourceTcpAccepted);
    }
    return 1;
  }

  // Connections are kept in the order of their acceptance.
  Connections::const_iterator OldestWithoutRecord() const {
    return std::ranges::find(connections_, false,
                             [](const Owned& connection) { return connection->any_record; });
  }

  // Replaces a connection that never sent a record, otherwise the one that was silent for longest.
  // A connection that sends is kept.
  bool MakeRoom(std::int64_t now_ns, Receiver& receiver) {
    auto place = OldestWithoutRecord();
    if (place == connections_.end()) {
      place = std::ranges::min_element(
          connections_, {}, [](const Owned& connection) { return connection->record_ns; });
      if (now_ns - (*place)->record_ns <= kSilent_ns) return false;
    }
    Connection& connection = **place;
    counters_.AddOf(source_, Counter::kSourceTcpGaveWay);
    if (const auto times = gave_way_notes_.Count(now_ns)) {
      receiver.OnNote(source_, "all " + std::to_string(max_connections_) +
                                   " connections (max_connections) are taken: that of " +
                                   connection.Who() + ", which " +
                                   (connection.any_record ? "fell silent" : "never sent a record") +
                                   ", is closed for a new one" + Times(times));
    }
    Close(connection);
    return true;
  }

  void Refuse(const std::string& who, std::int64_t now_ns, Receiver& receiver) {
    counters_.AddOf(source_, Counter::kSourceTcpRefused);
    if (const auto times = refused_notes_.Count(now_ns)) {
      receiver.OnNote(source_, "all " + std::to_string(max_connections_) +
                                   " connections (max_connections) are sending: that of " + who +
                                   " is refused" + Times(times));
    }
  }

  int CloseSilent(Receiver& receiver) {
    const std::int64_t now_ns = clock_.Now_ns();
    int closed = 0;
    for (; now_ns >= NextDeadline_ns(); ++closed) {
      Connection& connection = **OldestWithoutRecord();
      counters_.AddOf(source_, Counter::kSourceTcpSilent);
      if (const auto times = silent_notes_.Count(now_ns)) {
        receiver.OnNote(source_, "the connection of " + connection.Who() +
                                     " is closed: no whole record arrived in " +
                                     std::to_string(kFirstRecord_ns / kSecond_ns) + " s" +
                                     Times(times));
      }
      Close(connection);
    }
    return closed;
  }

  // One read of at most kReadBytes, and all records that it completes. The rest is read in the next
  // cycle, after the other sources.
  int Receive(Connection& connection, Receiver& receiver) {
    if (connection.socket.get() < 0) return 0;  // closed earlier in this batch of events
    const auto all = connection.reader.Space();
    const auto space = all.first(std::min(all.size(), kReadBytes));
    connection.arrival.Begin(clock_.Now_ns());
    const auto size = Read(connection, space);
    if (size <= 0) {
      if (size < 0) connection.arrival.End(errno == EAGAIN);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
      if (connection.reader.Pending() > 0) counters_.Add(Counter::kSourceTcpCutShort);
      Close(connection);
      return 1;
    }
    const auto piece = space.first(static_cast<std::size_t>(size));
    Announce(connection, piece, receiver);
    connection.reader.Received(piece.size());
    const ReadTogether read{connection.arrived_ns, connection.arrival.empty_ns()};
    connection.arrival.End(piece.size() < space.size());
    int work = 1;
    while (true) {
      std::size_t count = 0;
      auto result = Reader::Result::kRecord;
      while (count < kBatch) {
        result = connection.reader.Next(records_[count]);
        if (result != Reader::Result::kRecord) break;
        ++count;
      }
      received_ += count + (result == Reader::Result::kBroken ? 1 : 0);
      if (count > 0) {
        connection.any_record = true;
        connection.record_ns = clock_.Now_ns();
        HandOn(connection, {records_.data(), count}, read, receiver);
      }
      work += static_cast<int>(count);
      if (result == Reader::Result::kNeedMore) return work;
      if (result == Reader::Result::kBroken) {
        counters_.Add(WhyBroken(connection.reader));
        counters_.Add(Counter::kSourceTcpBroken);
        Close(connection);
        return work;
      }
    }
  }

  void Announce(const Connection& connection, std::span<const std::byte> piece,
                Receiver& receiver) const {
    const runtime::HotSection hot;
    receiver.OnArrival({source_, clock_.Now_ns(), piece,
                        reinterpret_cast<const sockaddr*>(&connection.address),
                        connection.address_size});
  }

  void HandOn(const Connection& connection, std::span<const std::span<const std::byte>> records,
              const ReadTogether& read, Receiver& receiver) {
    if (translator_ == nullptr) {
      std::fill_n(machines_.begin(), records.size(), MachineOf(connection.address));
      return decoder_.HandOn(records, std::span(machines_).first(records.size()), receiver, read);
    }
    outbox_.Open(receiver, -1);
    for (const auto record : records) {
      translator_->Handle(record, connection.peer, read.last_ns, outbox_);
    }
    outbox_.Close();
  }

  // Like recv, and returns when the last byte arrived at the kernel.
  ssize_t Read(Connection& connection, std::span<std::byte> space) noexcept {
    iovec place{space.data(), space.size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control;
    msghdr message{};
    message.msg_iov = &place;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = recvmsg(connection.socket.get(), &message, 0);
    if (size <= 0) return size;
    connection.arrival.Received(clock_);
    connection.arrived_ns = connection.arrival.now_ns();
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
      if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
      connection.arrived_ns =
          connection.arrival.Arrival_ns(stamp.tv_sec * runtime::kSecond_ns + stamp.tv_nsec);
    }
    return size;
  }

  static Counter WhyBroken(const StreamReader& reader) {
    return runtime::CounterOf(reader.Broken());
  }
  static Counter WhyBroken(const CutReader&) { return Counter::kSourceMalformed; }

  // Keeps the connection's object until the batch of events is done, because a later event may
  // point to it.
  void Close(Connection& connection) {
    connection.socket = Descriptor();
    const auto place = std::ranges::find_if(
        connections_, [&connection](const Owned& owned) { return owned.get() == &connection; });
    closed_.push_back(std::move(*place));
    connections_.erase(place);
  }

  Descriptor listener_, epoll_;
  int source_;
  std::size_t max_connections_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  std::unique_ptr<Translator> translator_;
  NativeDecoder decoder_;
  Outbox outbox_;
  std::string endpoint_;
  std::uint64_t accepted_ = 0, received_ = 0;
  Connections connections_, closed_;
  NoteLimit gave_way_notes_, refused_notes_, silent_notes_;
  std::array<std::span<const std::byte>, kBatch> records_;
  std::array<Machine, kBatch> machines_{};
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeTcp(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator) {
  auto listener = BindSocket(SOCK_STREAM, config.listen, config.receive_buffer_bytes);
  if (!listener.ok()) return listener.status();
  if (listen(listener.value().get(), 64) != 0) {
    return Status::Error("tcp " + config.listen + ": in use (another styled?)");
  }
  Descriptor epoll(epoll_create1(EPOLL_CLOEXEC));
  if (epoll.get() < 0) return Status::Error("tcp " + config.listen + ": no file descriptor left");
  const auto make = [&]<typename Reader>(std::type_identity<Reader>) {
    return std::unique_ptr<Transport>(
        std::make_unique<Tcp<Reader>>(std::move(listener.value()), std::move(epoll), config, source,
                                      clock, counters, std::move(translator)));
  };
  return translator == nullptr ? make(std::type_identity<StreamReader>())
                               : make(std::type_identity<CutReader>());
}

}  // namespace styled::source
