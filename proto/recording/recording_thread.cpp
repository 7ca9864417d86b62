#include "proto/recording/recording_thread.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <chrono>
#include <cstring>

namespace styled::recording {
namespace {

constexpr std::chrono::milliseconds kNap{5};  // waits in addition to the age of a block

enum class Kind : std::uint8_t { kArrival, kTransfer, kPublished, kCommand, kNote, kDecided };

// The beginning of every ring entry. It is followed by `head_size` bytes (peer, device or topic),
// then the payload.
struct EntryHead {
  std::int64_t time_ns = 0;
  std::uint16_t source = 0;
  std::uint16_t head_size = 0;
  Kind kind = Kind::kNote;
};

std::span<const std::byte> BytesOf(const EntryHead& head) {
  return std::as_bytes(std::span(&head, 1));
}

std::string ToString(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string PeerText(std::span<const std::byte> bytes) {
  sockaddr_storage peer{};
  std::memcpy(&peer, bytes.data(), std::min(bytes.size(), sizeof peer));
  return AddressText(reinterpret_cast<const sockaddr*>(&peer),
                     static_cast<socklen_t>(bytes.size()));
}

std::string DeviceText(std::span<const std::byte> bytes) {
  std::uint32_t device = 0;
  std::memcpy(&device, bytes.data(), std::min(bytes.size(), sizeof device));
  return "device " + std::to_string(device);
}

}  // namespace

std::string AddressText(const sockaddr* address, socklen_t size) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address != nullptr && size >= sizeof(sockaddr_in) && address->sa_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, address, sizeof v4);
    inet_ntop(AF_INET, &v4.sin_addr, text, sizeof text);
    return std::string(text) + ":" + std::to_string(ntohs(v4.sin_port));
  }
  if (address != nullptr && size >= sizeof(sockaddr_in6) && address->sa_family == AF_INET6) {
    sockaddr_in6 v6;
    std::memcpy(&v6, address, sizeof v6);
    inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof text);
    return "[" + std::string(text) + "]:" + std::to_string(ntohs(v6.sin6_port));
  }
  return "";
}

Result<std::unique_ptr<RecordingThread>> RecordingThread::Start(
    const std::filesystem::path& file, const FileHeader& header, std::vector<Origin> origins,
    const RecordingThreadOptions& options) {
  auto writer = FileWriter::Create(file, header, options.writer);
  if (!writer.ok()) return writer.status();
  return std::unique_ptr<RecordingThread>(
      new RecordingThread(std::move(writer.value()), std::move(origins), options.ring_bytes));
}

RecordingThread::RecordingThread(std::unique_ptr<FileWriter> writer, std::vector<Origin> origins,
                                 std::size_t ring_bytes)
    : ring_(ring_bytes), writer_(std::move(writer)), origins_(std::move(origins)) {
  origins_.emplace_back();  // for a source index out of range
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void RecordingThread::Stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

bool RecordingThread::Push(std::initializer_list<std::span<const std::byte>> parts) noexcept {
  std::size_t size = 0;
  for (const auto part : parts) size += part.size();
  if (size <= kMaxRecordSize && ring_.Push(parts)) return true;
  dropped_.fetch_add(1, std::memory_order_relaxed);
  return false;
}

bool RecordingThread::PushArrival(std::int64_t time_ns, int source, const sockaddr* peer,
                                  socklen_t peer_size,
                                  std::span<const std::byte> datagram) noexcept {
  const std::size_t size = peer == nullptr ? 0 : peer_size;
  const EntryHead head{time_ns, static_cast<std::uint16_t>(source),
                       static_cast<std::uint16_t>(size), Kind::kArrival};
  return Push({BytesOf(head), {reinterpret_cast<const std::byte*>(peer), size}, datagram});
}

bool RecordingThread::PushTransfer(std::int64_t time_ns, int source, std::uint32_t device,
                                   std::span<const std::byte> bytes) noexcept {
  const EntryHead head{time_ns, static_cast<std::uint16_t>(source), sizeof device, Kind::kTransfer};
  return Push({BytesOf(head), std::as_bytes(std::span(&device, 1)), bytes});
}

bool RecordingThread::PushPublished(std::int64_t time_ns, std::string_view topic,
                                    std::span<const std::byte> payload) noexcept {
  topic = topic.substr(0, 0xFFFF);
  const EntryHead head{time_ns, 0, static_cast<std::uint16_t>(topic.size()), Kind::kPublished};
  return Push({BytesOf(head), std::as_bytes(std::span(topic)), payload});
}

bool RecordingThread::PushCommand(std::int64_t time_ns, const Command& command) {
  const EntryHead head{time_ns, 0, 0, Kind::kCommand};
  const std::string bytes = command.SerializeAsString();
  return Push({BytesOf(head), std::as_bytes(std::span(bytes))});
}

bool RecordingThread::PushDecided(std::int64_t time_ns, const Decided& decided) {
  const EntryHead head{time_ns, 0, 0, Kind::kDecided};
  const std::string bytes = decided.SerializeAsString();
  return Push({BytesOf(head), std::as_bytes(std::span(bytes))});
}

bool RecordingThread::PushNote(std::int64_t time_ns, std::string_view text) noexcept {
  const EntryHead head{time_ns, 0, 0, Kind::kNote};
  return Push({BytesOf(head), std::as_bytes(std::span(text))});
}

Status RecordingThread::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

void RecordingThread::Note(const Status& status) {
  written_.store(writer_->counts().records, std::memory_order_relaxed);
  lost_.store(writer_->counts().lost + writer_->counts().too_large, std::memory_order_relaxed);
  if (status.ok()) return;
  const std::lock_guard lock(mutex_);
  error_ = status;
}

void RecordingThread::Run(const std::stop_token& stop) {
  PreferThisThread();
  while (!stop.stop_requested()) {
    Drain();
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, stop, kNap, [] { return false; });
  }
  Drain();
  Note(writer_->Flush());
}

void RecordingThread::Drain() {
  while (ring_.Pop(entry_)) {
    if (Decode(entry_)) Note(writer_->Add(record_, MonotonicNow_ns()));
  }
  Note(writer_->Poll(MonotonicNow_ns()));
}

bool RecordingThread::Decode(std::span<const std::byte> entry) {
  EntryHead head;
  std::memcpy(&head, entry.data(), sizeof head);
  const auto first = entry.subspan(sizeof head, head.head_size);
  const auto rest = entry.subspan(sizeof head + head.head_size);
  record_.set_time_ns(head.time_ns);
  switch (head.kind) {
    case Kind::kArrival:
    case Kind::kTransfer: {
      Arrival& arrival = *record_.mutable_arrival();
      const Origin& origin = origins_[std::min<std::size_t>(head.source, origins_.size() - 1)];
      arrival.set_source(origin.name);
      arrival.set_type(origin.type);
      arrival.set_listen(origin.listen);
      arrival.set_peer(head.kind == Kind::kArrival ? PeerText(first) : DeviceText(first));
      arrival.set_datagram(ToString(rest));
      return true;
    }
    case Kind::kPublished:
      record_.mutable_published()->set_topic(ToString(first));
      record_.mutable_published()->set_payload(ToString(rest));
      return true;
    case Kind::kCommand:
      return record_.mutable_command()->ParseFromArray(rest.data(), static_cast<int>(rest.size()));
    case Kind::kDecided:
      return record_.mutable_decided()->ParseFromArray(rest.data(), static_cast<int>(rest.size()));
    case Kind::kNote:
      record_.mutable_note()->set_text(ToString(rest));
      return true;
  }
  return false;
}

}  // namespace styled::recording
