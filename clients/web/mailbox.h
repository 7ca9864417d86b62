#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

namespace styled::web {

// One WebSocket message, made once and shared by all browsers that want it.
struct Message {
  std::string key;    // of two messages with the same key only the newer matters; "": all matter
  std::string bytes;  // as it goes out
  bool text = false;  // a notice (JSON), else binary
};
using MessagePtr = std::shared_ptr<const Message>;

// What waits to be sent to one browser: at most one message per key, the newest, so that a browser
// that does not read costs a bounded amount of memory and gets the present when it reads again. The
// caller bounds how many distinct keys, and how many messages without key, can wait.
//
// One thread at a time. Allocates.
class Mailbox {
 public:
  // A message that replaces another takes its place in the queue. True where it did.
  bool Put(MessagePtr message);
  // The one that waited longest; null where nothing waits.
  MessagePtr Take();
  std::size_t size() const { return waiting_.size(); }

 private:
  std::deque<MessagePtr> waiting_;
  std::size_t taken_ = 0;  // since the beginning: the number of waiting_.front()
  std::unordered_map<std::string_view, std::size_t> by_key_;  // key to number; views into Message
};

}  // namespace styled::web
