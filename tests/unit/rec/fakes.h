#pragma once

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "model/body/pose.h"
#include "proto/recording/reader.h"
#include "proto/recording/recording.pb.h"
#include "proto/recording/writer.h"
#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "sim/player/clock.h"
#include "tests/support/temporary_folder.h"

namespace styled::rec::testing {

constexpr std::int64_t kMillisecond_ns = 1'000'000, kSecond_ns = 1'000'000'000;

// Time moves when slept.
class FakeClock final : public player::Clock {
 public:
  std::int64_t Now_ns() override { return now_ns; }
  void SleepUntil(std::int64_t deadline_ns) override {
    if (deadline_ns > now_ns) slept_ns += deadline_ns - now_ns;
    now_ns = std::max(now_ns, deadline_ns);
  }
  std::int64_t now_ns = 77 * kSecond_ns, slept_ns = 0;
};

// Records in a file in memory.
inline std::unique_ptr<recording::Reader> MakeReader(
    const std::vector<recording::Record>& records) {
  std::vector<std::byte> bytes;
  const auto append = [&bytes](std::span<const std::byte> more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
  };
  append(recording::Preamble());
  recording::BlockBuilder builder;
  append(builder.Header({}));
  for (const auto& record : records) {
    if (!builder.Add(record)) std::abort();
    if (builder.records() == 10) append(builder.Close());
  }
  if (builder.records() > 0) append(builder.Close());
  auto reader = recording::Reader::Open(recording::MemoryInput(std::move(bytes)), "test.styrec");
  if (!reader.ok()) std::abort();
  return std::move(reader.value());
}

inline recording::Record Published(std::int64_t time_ns, const std::string& topic,
                                   const std::string& payload) {
  recording::Record record;
  record.set_time_ns(time_ns);
  record.mutable_published()->set_topic(topic);
  record.mutable_published()->set_payload(payload);
  return record;
}

inline recording::Record Arrival(std::int64_t time_ns, const std::string& datagram,
                                 const std::string& source = "rig",
                                 const std::string& peer = "10.0.0.1:5000") {
  recording::Record record;
  record.set_time_ns(time_ns);
  record.mutable_arrival()->set_source(source);
  record.mutable_arrival()->set_type("udp");
  record.mutable_arrival()->set_peer(peer);
  record.mutable_arrival()->set_datagram(datagram);
  return record;
}

// The canonical humanoid as a published body of `id`.
inline styled::v1::Body MakeBody(const std::string& id, styled::v1::Output output,
                                 std::uint64_t hash) {
  styled::v1::Body body;
  body.set_performer(id);
  body.set_output(output);
  body.set_hash(hash);
  body.set_metres_per_unit(1);
  body.set_dialect("canonical");
  for (const auto& row : body::kHumanoid) {
    body.add_names(std::string(row.name));
    body.add_parents(row.parent);
    for (const float value : {row.x_m, row.y_m, row.z_m}) body.add_offsets(value);
    for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) body.add_rest(value);
  }
  return body;
}

// A frame on it: the hips are `number` metres high.
inline styled::v1::Frame MakeFrame(const styled::v1::Body& body, std::uint64_t number,
                                   std::uint64_t source_time_ns) {
  styled::v1::Frame frame;
  frame.set_performer(body.performer());
  frame.set_output(body.output());
  frame.set_body_hash(body.hash());
  frame.set_epoch(9);
  frame.set_sequence(number);
  frame.set_source_sequence(number);
  frame.set_source_time_ns(source_time_ns);
  for (const float value : {0.0F, static_cast<float>(number), 0.0F}) frame.add_root_position(value);
  for (int joint = 0; joint < body.names_size(); ++joint) {
    for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) frame.add_rotations(value);
  }
  return frame;
}

inline std::string Datagram(native::Kind kind, std::uint64_t session, std::uint64_t sequence,
                            const std::string& payload) {
  std::string bytes(native::kHeaderSize + payload.size(), '\0');
  bytes.resize(native::Encode({kind, session, sequence, std::as_bytes(std::span(payload))},
                              std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

// A UDP socket that listens.
class Listener {
 public:
  Listener() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(fd_, reinterpret_cast<sockaddr*>(&address), size) != 0) std::abort();
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { close(fd_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  std::string url() const { return "udp://" + address(); }
  // The next datagram, "none" where none comes within `wait_ms`; its sender's port in from_port.
  std::string Receive(int wait_ms = 2000) {
    pollfd waiting{fd_, POLLIN, 0};
    if (poll(&waiting, 1, wait_ms) <= 0) return "none";
    std::string bytes(65536, '\0');
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t got =
        recvfrom(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    from_port = ntohs(from.sin_port);
    bytes.resize(got < 0 ? 0 : static_cast<std::size_t>(got));
    return bytes;
  }
  void Send(int port, const std::string& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    (void)sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  }
  int port() const { return port_; }
  int from_port = 0;

 private:
  int fd_, port_ = 0;
};

using support::TemporaryFolder;

}  // namespace styled::rec::testing
