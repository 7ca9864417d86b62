#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>

namespace styled::web {

// The connections that are open. When there is no room for another, one that waits for its peer
// gives way: requests that are never finished, or replies that are never read, keep nobody out.
// The loop's thread.
class Crowd {
 public:
  enum class State { kReading, kWriting, kBrowser };  // an HTTP request, its reply, a WebSocket

  // A connection, for as long as this object lives. `close` ends it, soon; it is called at most
  // once, and the connection does not count from then on.
  class Member {
   public:
    Member(std::shared_ptr<Crowd> crowd, std::function<void()> close);
    ~Member();
    Member(const Member&) = delete;
    Member& operator=(const Member&) = delete;
    // The wait begins anew.
    void Now(State state);

   private:
    friend class Crowd;
    std::shared_ptr<Crowd> crowd_;
    std::function<void()> close_;
    State state_ = State::kReading;
    bool counted_ = true;
    std::list<Member*>::iterator place_;
  };

  std::size_t size() const { return members_.size(); }
  // Closes who has waited longest for the rest of a request; where there is none, who has waited
  // longest for a reply to be read. False where there are browsers' WebSockets alone.
  bool MakeRoom();

 private:
  std::list<Member*> members_;  // the longest wait first
};

}  // namespace styled::web
