#include "daemon/publish/bundle.h"

namespace styled::publish {

void Bundle::Add(std::span<const std::byte> frame, Publisher& publisher) noexcept {
  if (topic_.wanted == 0 || frame.empty()) return;
  if (bytes_.size() + frame.size() > kMostBytes) Send(publisher);
  // Field 1 of v1.Frames: its key, the length as a varint, the message.
  bytes_.push_back(std::byte{0x0A});
  std::size_t rest = frame.size();
  for (; rest >= 0x80; rest >>= 7U)
    bytes_.push_back(static_cast<std::byte>(0x80U | (rest & 0x7FU)));
  bytes_.push_back(static_cast<std::byte>(rest));
  bytes_.insert(bytes_.end(), frame.begin(), frame.end());
}

void Bundle::Send(Publisher& publisher) noexcept {
  if (!bytes_.empty()) publisher.Send(topic_.name, bytes_);
  bytes_.clear();
}

}  // namespace styled::publish
