#include "tests/support/rig.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <thread>

#include "model/body/pose.h"

namespace styled::support {
namespace {

int Connect(int type, const std::string& address) {
  const std::size_t colon = address.rfind(':');
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr);
  const int fd = socket(AF_INET, type | SOCK_CLOEXEC, 0);
  if (connect(fd, reinterpret_cast<sockaddr*>(&to), sizeof to) != 0) {
    std::fprintf(stderr, "cannot connect to %s\n", address.c_str());
    std::abort();
  }
  return fd;
}

}  // namespace

Rig::Rig(std::string the_performer, std::uint64_t session_id)
    : performer(std::move(the_performer)), session(session_id) {}

v1::Body Rig::MakeBody() const {
  v1::Body body;
  body.set_performer(performer);
  for (const auto& row : body::kHumanoid) {
    body.add_names(std::string(row.name));
    body.add_parents(row.parent);
    for (const float value : {row.x_m, row.y_m, row.z_m}) body.add_offsets(value);
  }
  body.set_metres_per_unit(1);
  body.set_dialect("canonical");
  return body;
}

v1::SourceFrame Rig::MakeFrame() const {
  const double t_s = static_cast<double>(time_ns) * 1e-9;
  const auto swing = [t_s](double rate_hz, double phase) {
    return static_cast<float>(std::sin(2 * M_PI * (rate_hz * t_s + phase)));
  };
  v1::SourceFrame frame;
  frame.set_performer(performer);
  frame.set_source_time_ns(time_ns);
  for (const float value : {0.05F * swing(0.3, 0), 0.97F + 0.01F * swing(2, 0), 0.02F}) {
    frame.add_root_position(value);
  }
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    body::Vec3 turn = body::Vec3::Zero();
    if (joint == body::kLeftUpperLeg) turn.x() = 0.3F * swing(1, 0);
    if (joint == body::kRightUpperLeg) turn.x() = 0.3F * swing(1, 0.5);
    if (joint == body::kLeftUpperArm) turn.z() = -1.2F + 0.1F * swing(1, 0.5);
    if (joint == body::kRightUpperArm) turn.z() = 1.2F + 0.1F * swing(1, 0);
    if (joint == body::kChest) turn.y() = 0.1F * swing(0.5, 0);
    const body::Quat rotation = body::Exp(turn);
    for (const float value : {rotation.x(), rotation.y(), rotation.z(), rotation.w()}) {
      frame.add_rotations(value);
    }
  }
  return frame;
}

Bytes Rig::Datagram(native::Kind kind, std::string_view payload) {
  Bytes bytes(native::kHeaderSize + payload.size());
  native::Datagram datagram{kind, session, sequence++, std::as_bytes(std::span(payload))};
  bytes.resize(native::Encode(datagram, bytes));
  return bytes;
}

Bytes Rig::Body() { return Datagram(native::Kind::kBody, MakeBody().SerializeAsString()); }

Bytes Rig::Frame() {
  return Frame([](v1::SourceFrame&) {});
}

Bytes Rig::Frame(const std::function<void(v1::SourceFrame&)>& change) {
  v1::SourceFrame frame = MakeFrame();
  time_ns += period_ns;
  change(frame);
  return Datagram(native::Kind::kSourceFrame, frame.SerializeAsString());
}

UdpLink::UdpLink(const std::string& address) : fd_(Connect(SOCK_DGRAM, address)) {}
UdpLink::~UdpLink() { close(fd_); }
void UdpLink::Send(const Bytes& bytes) const { (void)send(fd_, bytes.data(), bytes.size(), 0); }

TcpLink::TcpLink(const std::string& address) : fd_(Connect(SOCK_STREAM, address)) {}
TcpLink::~TcpLink() { close(fd_); }

void TcpLink::Send(const Bytes& bytes) const {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const auto size = send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (size <= 0) return;
    sent += static_cast<std::size_t>(size);
  }
}

void TcpLink::Send(std::string_view text) const {
  const auto bytes = std::as_bytes(std::span(text));
  Send(Bytes(bytes.begin(), bytes.end()));
}

std::string TcpLink::ReadToEnd() const {
  std::string text;
  pollfd waiting{fd_, POLLIN, 0};
  std::array<char, 4096> part{};
  while (poll(&waiting, 1, 10000) > 0) {
    const auto size = recv(fd_, part.data(), part.size(), 0);
    if (size <= 0) break;
    text.append(part.data(), static_cast<std::size_t>(size));
  }
  return text;
}

bool TcpLink::Closed(double seconds) const {
  pollfd waiting{fd_, POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(seconds * 1000)) <= 0) return false;
  char byte = 0;
  return recv(fd_, &byte, 1, 0) <= 0;
}

void Paced(int count, double rate_hz, const std::function<void(int)>& step) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_until(start + std::chrono::duration<double>(i / rate_hz));
    step(i);
  }
}

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

}  // namespace styled::support
