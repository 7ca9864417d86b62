#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>

namespace styled::web {

// The open connections. When the limit is reached, a connection that waits for its peer is closed
// to make room, so that requests that are never finished and replies that are never read cannot
// block others. Call on the loop's thread.
class Crowd {
 public:
  enum class State { kReading, kWriting, kBrowser };  // an HTTP request, its reply, a WebSocket

  // Registers a connection for the lifetime of this object. `close` requests the end of the
  // connection. It is called at most once, and from then on the connection does not count.
  class Member {
   public:
    Member(std::shared_ptr<Crowd> crowd, std::function<void()> close);
    ~Member();
    Member(const Member&) = delete;
    Member& operator=(const Member&) = delete;
    // Sets the state and restarts the connection's wait.
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
  // Closes the connection that has waited longest for the rest of a request, or, if there is none,
  // the one that has waited longest for its reply to be read. False if all connections are
  // WebSockets.
  bool MakeRoom();

 private:
  std::list<Member*> members_;  // the longest wait first
};

}  // namespace styled::web
