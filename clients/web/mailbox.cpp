#include "clients/web/mailbox.h"

#include <utility>

namespace styled::web {

bool Mailbox::Put(MessagePtr message) {
  if (message->key.empty()) {
    waiting_.push_back(std::move(message));
    return false;
  }
  const auto known = by_key_.find(message->key);
  if (known == by_key_.end()) {
    by_key_.emplace(message->key, taken_ + waiting_.size());
    waiting_.push_back(std::move(message));
    return false;
  }
  const std::size_t number = known->second;
  by_key_.erase(known);  // its key is a view into the message about to be removed
  by_key_.emplace(message->key, number);
  waiting_[number - taken_] = std::move(message);
  return true;
}

MessagePtr Mailbox::Pop() {
  if (waiting_.empty()) return nullptr;
  MessagePtr message = std::move(waiting_.front());
  waiting_.pop_front();
  ++taken_;
  if (!message->key.empty()) by_key_.erase(message->key);
  return message;
}

}  // namespace styled::web
