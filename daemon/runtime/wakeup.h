#pragma once

namespace styled::runtime {

// Lets one thread end another's wait: an eventfd to poll for reading. Signal() from any thread,
// Clear() by the waiting one. Neither blocks. Throws std::runtime_error when the system has no
// descriptor left at construction.
class Wakeup {
 public:
  Wakeup();
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  void Signal() noexcept;
  void Clear() noexcept;
  int fd() const { return fd_; }

 private:
  int fd_;
};

}  // namespace styled::runtime
