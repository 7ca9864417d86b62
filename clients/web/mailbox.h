#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

namespace styled::web {

// A WebSocket message, encoded once and shared by all browsers that receive it.
struct Message {
  std::string key;    // a newer message replaces one with the same key; "": never replaced
  std::string bytes;  // as sent
  bool text = false;  // a notice (JSON), else binary
};
using MessagePtr = std::shared_ptr<const Message>;

// The send queue of one browser. It holds at most one message per key, the newest. A browser that
// does not read therefore uses a bounded amount of memory, and receives the current state when it
// reads again. The caller must bound the number of distinct keys and of messages without a key.
//
// One thread at a time. Allocates.
class Mailbox {
 public:
  // Queues a message. If one with the same key waits, it is replaced at its place, and the result
  // is true.
  bool Put(MessagePtr message);
  // Removes and returns the message that has waited longest; null if the queue is empty.
  MessagePtr Pop();
  std::size_t size() const { return waiting_.size(); }

 private:
  std::deque<MessagePtr> waiting_;
  std::size_t taken_ = 0;  // total removed so far: the sequence number of waiting_.front()
  // Key to sequence number; views into Message.
  std::unordered_map<std::string_view, std::size_t> by_key_;
};

}  // namespace styled::web
