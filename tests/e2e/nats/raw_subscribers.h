#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace styled::support {

enum class Wire { kNats, kZmtp };

struct RawOptions {
  Wire wire = Wire::kNats;
  std::string port;                 // of loopback
  std::string user;                 // NATS: with the password USERword; ZMTP has none
  std::vector<std::string> topics;  // NATS: subjects
  int count = 1;
  bool stopped = false;  // they read nothing and answer nothing, with the smallest SO_RCVBUF
};

// The delivery of the frames that were published in a span of time.
struct RawResult {
  std::uint64_t delivered = 0;
  std::uint64_t lost = 0;              // of the frames of the span, for each subscriber
  std::uint64_t doubled = 0;           // not newer than what the same subscriber had
  std::vector<float> latency_ms;       // of each; sorted
  std::map<int, float> worst_ms;       // by the second of its arrival in the span
  double Quantile_ms(double q) const;  // 0 where nothing came
};

// Subscribers of a daemon (ZMTP) or of a NATS server, as sockets that one thread reads with epoll:
// both kinds cost their side the same. Of each Frame the thread parses performer, sequence and
// publish_time_ns, and takes the time. Bodies and other messages are left out.
class RawSubscribers {
 public:
  // Connects all and subscribes; ok() is false where one was refused, error() says why.
  explicit RawSubscribers(const RawOptions& options);
  ~RawSubscribers();
  RawSubscribers(const RawSubscribers&) = delete;
  RawSubscribers& operator=(const RawSubscribers&) = delete;

  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  std::uint64_t frames() const { return frames_; }   // so far, of all
  int closed() const { return closed_; }             // connections that the other side ended
  std::int64_t last_ns() const { return last_ns_; }  // monotonic, of the last frame's arrival

  // Frames published from now on are stored until Take.
  void Begin();
  // Waits `drain_s` for frames on their way, and returns those published until the call.
  RawResult Collect(double drain_s = 1);

 private:
  struct Socket;
  struct Arrival {
    std::uint32_t subscriber, performer;
    std::uint64_t sequence;
    std::int64_t published_ns, arrived_ns;
  };
  bool Open(const RawOptions& options, Socket& socket);
  void Run(const std::stop_token& stop);
  bool Read(Socket& socket);  // false: it is closed
  std::size_t ParseNats(Socket& socket, std::string_view bytes);
  std::size_t ParseZmtp(Socket& socket, std::string_view bytes);
  void AddFrame(Socket& socket, std::string_view payload);

  const Wire wire_;
  std::string error_;
  std::vector<std::unique_ptr<Socket>> sockets_;
  int epoll_ = -1;
  std::map<std::string, std::uint32_t, std::less<>> performers_;
  std::int64_t now_ns_ = 0;  // of the bytes that are parsed
  std::mutex mutex_;         // of the next three
  std::vector<Arrival> arrivals_;
  bool storing_ = false;
  std::int64_t begin_ns_ = 0;
  std::atomic<std::int64_t> last_ns_{0};
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<int> closed_{0};
  std::jthread thread_;
};

// The monotonic clock of Frame.publish_time_ns.
std::int64_t Monotonic_ns();

}  // namespace styled::support
