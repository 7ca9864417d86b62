#include "tests/faults/stage.h"

#include <zmq.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "proto/styled/v1/frame.pb.h"

namespace styled::faults {

std::int64_t Now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

Feed::Feed(std::string udp, int performers, Meddle meddle)
    : udp_(std::move(udp)),
      performers_(performers),
      meddle_(std::move(meddle)),
      thread_([this] { Run(); }) {}

Feed::~Feed() { Stop(); }

Feed::Sent Feed::Stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  return so_far();
}

void Feed::Run() {
  const support::UdpLink link(udp_);
  std::vector<support::Rig> rigs;
  for (int i = 0; i < performers_; ++i) {
    rigs.emplace_back("p" + std::to_string(i), static_cast<std::uint64_t>(Now_ns()) + i);
    rigs.back().time_ns = static_cast<std::uint64_t>(Now_ns());
  }
  const double period_ns = 1e9 / 120;
  const std::int64_t start_ns = Now_ns();
  for (std::int64_t k = 0; !stop_; ++k) {
    for (int i = 0; i < performers_; ++i) {
      const double due_ns =
          (static_cast<double>(k) + static_cast<double>(i) / performers_) * period_ns;
      std::this_thread::sleep_until(std::chrono::steady_clock::time_point(
          std::chrono::nanoseconds(start_ns + static_cast<std::int64_t>(due_ns))));
      if (k % 120 == 0) {
        link.Send(rigs[i].Body());
        ++datagrams_;
      }
      const bool send = !meddle_ || meddle_(rigs[i]);
      const support::Bytes frame = rigs[i].Frame();
      if (!send) {
        ++withheld_;
        continue;
      }
      link.Send(frame);
      ++datagrams_;
      ++frames_;
    }
  }
}

Watcher::Watcher(const std::string& publish)
    : context_(zmq_ctx_new()), socket_(zmq_socket(context_, ZMQ_SUB)) {
  const int wait_ms = 20, room = 100'000, retry_ms = 20, linger = 0;
  zmq_setsockopt(socket_, ZMQ_RCVTIMEO, &wait_ms, sizeof wait_ms);
  zmq_setsockopt(socket_, ZMQ_RCVHWM, &room, sizeof room);
  zmq_setsockopt(socket_, ZMQ_RECONNECT_IVL, &retry_ms, sizeof retry_ms);
  zmq_setsockopt(socket_, ZMQ_LINGER, &linger, sizeof linger);
  zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, "styled/", 7);
  if (zmq_connect(socket_, publish.c_str()) != 0) std::abort();
  thread_ = std::thread([this] { Run(); });
}

Watcher::~Watcher() {
  stop_ = true;
  thread_.join();
  zmq_close(socket_);
  zmq_ctx_term(context_);
}

void Watcher::Run() {
  std::vector<char> topic(512), payload(1 << 16);
  while (!stop_) {
    const int topic_size = zmq_recv(socket_, topic.data(), topic.size(), 0);
    if (topic_size < 0) continue;
    const int size = zmq_recv(socket_, payload.data(), payload.size(), 0);
    // One stream a performer is enough.
    const std::string_view name(topic.data(), static_cast<std::size_t>(topic_size));
    if (size > 0 && name.ends_with("/rig/"))
      Record(std::string(payload.data(), static_cast<std::size_t>(size)));
  }
}

void Watcher::Record(const std::string& payload) {
  v1::Frame frame;
  if (!frame.ParseFromString(payload)) return;
  bool good = frame.rotations_size() > 0;
  for (const float value : frame.root_position()) good = good && std::isfinite(value);
  for (int i = 0; i + 3 < frame.rotations_size(); i += 4) {
    double square = 0;
    for (int k = 0; k < 4; ++k) square += std::pow(frame.rotations(i + k), 2);
    good = good && std::abs(square - 1) < 1e-3;  // not for NaN, either
  }
  const std::int64_t now_ns = Now_ns();
  const std::scoped_lock lock(mutex_);
  if (frame.epoch() != seen_.epoch) sequence_.clear();
  seen_.epoch = frame.epoch();
  ++seen_.frames;
  if (!good) ++seen_.bad;
  const auto took_ns = static_cast<std::int64_t>(frame.publish_time_ns() - frame.source_time_ns());
  if (took_ns > 1'000'000'000 / 120) ++seen_.over_period;
  std::uint64_t& last = sequence_[frame.performer()];
  if (last != 0 && frame.sequence() > last + 1) {
    seen_.missing += frame.sequence() - last - 1;
    seen_.longest_gap = std::max(seen_.longest_gap, frame.sequence() - last - 1);
  }
  last = frame.sequence();
  if (seen_.last_ns != 0) {
    seen_.longest_pause_ns = std::max(seen_.longest_pause_ns, now_ns - seen_.last_ns);
  }
  seen_.last_ns = now_ns;
  seen_.last_wall_ns = static_cast<std::int64_t>(frame.wall_time_ns());
  seen_.style = frame.styles_size() > 0 ? frame.styles(0).style() : "";
}

Watcher::Seen Watcher::seen() const {
  const std::scoped_lock lock(mutex_);
  return seen_;
}

bool Watcher::Sees(double seconds) const {
  const std::int64_t from_ns = Now_ns();
  while (Now_ns() < from_ns + static_cast<std::int64_t>(seconds * 1e9)) {
    if (seen().last_ns > from_ns) return true;
    support::Sleep(0.002);
  }
  return false;
}

std::uint64_t ResidentBytes(int pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stoull(line.substr(6)) * 1024;
  }
  return 0;
}

int Descriptors(int pid) {
  const std::filesystem::directory_iterator fds("/proc/" + std::to_string(pid) + "/fd");
  return static_cast<int>(std::distance(begin(fds), end(fds)));
}

}  // namespace styled::faults
