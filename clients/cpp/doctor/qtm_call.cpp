#include "clients/cpp/doctor/qtm_call.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "proto/rigs/qtm/frame.h"
#include "proto/rigs/qtm/parameters.h"

namespace styled::doctor {
namespace {

using qtm::PacketType;

constexpr double kRetry_s = 0.5;  // QTM may just be starting

class QtmCall final : public Listener {
 public:
  QtmCall(const sockaddr_storage& server, QtmAnswers& answers)
      : server_(server), answers_(answers) {}

  int fd() const override { return fd_.get(); }

  // A connection that could not be made is readable, too.
  void Listen(Notebook& notes) override {
    if (!answers_.connected && !Connected()) return;
    for (int i = 0; i < kBatch && fd_.get() >= 0; ++i) {
      const ssize_t size = recv(fd_.get(), notes.buffer.data(), notes.buffer.size(), MSG_DONTWAIT);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
      if (size <= 0) {
        answers_.refused = size < 0 ? std::strerror(errno) : "It closed the connection";
        fd_ = Descriptor();
        return;
      }
      const auto piece = std::span(notes.buffer).first(static_cast<std::size_t>(size));
      received_.insert(received_.end(), piece.begin(), piece.end());
      if (!HandlePackets()) return;
    }
  }

  void Tick(double now_s) override {
    if (answers_.connected) return;
    if (fd_.get() >= 0) {
      (void)Connected();
    } else if (now_s >= next_s_) {
      next_s_ = now_s + kRetry_s;
      Open();
    }
  }

 private:
  void Open() {
    fd_ = Descriptor(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (fd_.get() >= 0 && (connect(fd_.get(), reinterpret_cast<const sockaddr*>(&server_),
                                   sizeof(sockaddr_in)) == 0 ||
                           errno == EINPROGRESS)) {
      return;
    }
    answers_.refused = std::strerror(errno);
    fd_ = Descriptor();
  }

  // Whether the connection has been made by now.
  bool Connected() {
    pollfd waiting{fd_.get(), POLLOUT, 0};
    if (poll(&waiting, 1, 0) != 1) return false;
    int error = 0;
    socklen_t size = sizeof error;
    getsockopt(fd_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
    answers_.connected = error == 0;
    if (error == 0) {
      answers_.refused.clear();
      return true;
    }
    answers_.refused = std::strerror(error);
    fd_ = Descriptor();
    return false;
  }

  // False: the data is not QTM's.
  bool HandlePackets() {
    std::size_t begin = 0, size = 0;
    rigs::Cut cut{};
    while (begin < received_.size() && (cut = qtm::CutPacket(std::span(received_).subspan(begin),
                                                             size)) == rigs::Cut::kRecord) {
      qtm::Packet packet;
      const auto record = std::span(received_).subspan(begin, size);
      begin += size;
      if (qtm::DecodePacket(record, packet) == qtm::DecodeResult::kOk) Handle(packet);
    }
    if (cut == rigs::Cut::kBroken) {
      const std::string_view text(reinterpret_cast<const char*>(received_.data()),
                                  received_.size());
      if (answers_.text.empty()) answers_.text = Printable(text.substr(begin), 40);
      fd_ = Descriptor();
      return false;
    }
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(begin));
    return true;
  }

  void Handle(const qtm::Packet& packet) {
    switch (packet.type) {
      case PacketType::kCommand:
      case PacketType::kError:
        return HandleText(qtm::TextOf(packet.payload));
      case PacketType::kXml:
        return HandleXml(qtm::TextOf(packet.payload));
      case PacketType::kNoMoreData:
        answers_.no_measurement = true;
        return;
      case PacketType::kData:
        return HandleFrame(packet.payload);
      default:
        return;
    }
  }

  void HandleText(std::string_view text) {
    if (qtm::IsGreeting(text)) {
      answers_.greeted = true;
      return Ask("Version 1." + std::to_string(asked_minor_));
    }
    if (!answers_.greeted || answers_.minor > 0) {
      if (answers_.text.empty()) answers_.text = Printable(text, 80);
      return;
    }
    if (qtm::AcceptsVersion(text)) {
      answers_.minor = asked_minor_;
      return Ask("GetParameters Skeleton");
    }
    if (asked_minor_ == qtm::kOldestMinor) {
      answers_.text = Printable(text, 80);
      return;
    }
    Ask("Version 1." + std::to_string(--asked_minor_));
  }

  void HandleXml(std::string_view xml) {
    const auto read = qtm::ReadParameters(xml);
    if (!read.ok()) {
      answers_.text = Printable(read.status().message(), 80);
      return;
    }
    answers_.skeletons_answered = true;
    answers_.skeletons = read.value().skeletons ? read.value().skeletons->size() : 0;
    Ask("StreamFrames Frequency:10 Skeleton");
  }

  void HandleFrame(std::span<const std::byte> payload) {
    if (qtm::DecodeFrame(payload, *frame_) != qtm::DecodeResult::kOk) return;
    ++answers_.frames;
    const auto skeletons = std::span(frame_->skeletons).first(frame_->skeleton_count);
    const bool seen = std::ranges::any_of(
        skeletons, [](const auto& skeleton) { return skeleton.segment_count > 0; });
    answers_.seen_frames += seen ? 1 : 0;
  }

  void Ask(const std::string& command) {
    std::array<std::byte, 128> buffer;
    const std::size_t size = qtm::EncodeText(PacketType::kCommand, command, buffer);
    (void)send(fd_.get(), buffer.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL);
  }

  Descriptor fd_;
  sockaddr_storage server_;
  QtmAnswers& answers_;
  double next_s_ = 0;
  std::vector<std::byte> received_;
  int asked_minor_ = qtm::kNewestMinor;
  std::unique_ptr<qtm::Frame> frame_ = std::make_unique<qtm::Frame>();
};

}  // namespace

Result<std::unique_ptr<Listener>> MakeQtmCall(const Endpoint& server, QtmAnswers& answers) {
  sockaddr_storage address;
  const socklen_t size = ToSocket(server, address);
  if (size == 0 || address.ss_family != AF_INET || server.port == 0) {
    return Status::Error("server: \"" + ToString(server) + "\" is not an IPv4 address");
  }
  answers.server = server;
  return std::unique_ptr<Listener>(std::make_unique<QtmCall>(address, answers));
}

}  // namespace styled::doctor
