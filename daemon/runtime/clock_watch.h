#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "proto/ptp/management.h"

namespace styled::runtime {

// The state of the clock according to a ptp4l on this machine.
struct PtpClock {
  std::uint8_t domain = 0;
  ptp::PortState port = ptp::PortState::kNone;  // the state of the port that is nearest to being a
                                                // slave
  ptp::Parent parent;
  ptp::Current current;
  ptp::TimeProperties properties;
};

struct ClockDiscipline {
  bool known = false;      // the kernel answered
  bool locked = false;     // the kernel considers the wall clock synchronized
  double max_error_s = 0;  // the kernel's bound of the clock's error
  std::optional<PtpClock> ptp;
};

// Watches how this machine's wall clock is disciplined: by the kernel (ntp_adjtime) and by ptp4l's
// management socket, which needs no library and no process. Update never blocks. One thread;
// allocates in Update only when it connects. Pinned by
// tests/unit/daemon/runtime/clock_watch_test.cpp.
class ClockWatch {
 public:
  // ptp4l's sockets: the one for readers (since 4.0), and that of earlier versions, which only its
  // group may use.
  static constexpr std::array kUsualSockets{"/var/run/ptp4lro", "/var/run/ptp4l"};
  // After this long without an answer the clock counts as gone.
  static constexpr std::int64_t kPatience_ns = 3'500'000'000;

  // `ptp4l`: its socket; "": the usual ones.
  explicit ClockWatch(std::string ptp4l = "") : path_(std::move(ptp4l)) {}
  ~ClockWatch();
  ClockWatch(const ClockWatch&) = delete;
  ClockWatch& operator=(const ClockWatch&) = delete;

  // Call about once a second: reads the answers and sends the next requests.
  void Update(std::int64_t now_ns) noexcept;
  const ClockDiscipline& discipline() const { return discipline_; }

 private:
  // ptp4l answers in its own domain only. While the domain is unknown, this many are tried at a
  // time; ptp4l's socket queues 10 datagrams.
  static constexpr int kDomainsAtOnce = 8;

  void ReadKernel() noexcept;
  bool Connect() noexcept;
  bool ConnectTo(const char* path) noexcept;
  void Disconnect() noexcept;
  void ReadReplies(std::int64_t now_ns) noexcept;
  void Apply(const ptp::Reply& reply) noexcept;
  void Ask() noexcept;
  bool Send(ptp::DataSet data, std::uint8_t domain) noexcept;

  std::string path_;
  int fd_ = -1;
  std::uint16_t sequence_ = 0;
  std::optional<std::uint8_t> domain_;  // the domain in which it answered
  int tried_ = 0;                       // domains, in the order in which they are tried
  std::int64_t answered_ns_ = 0;
  PtpClock heard_;
  ptp::PortState best_ = ptp::PortState::kNone;  // best state among the ports in this round
  ClockDiscipline discipline_;
};

}  // namespace styled::runtime
