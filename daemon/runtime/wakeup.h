#pragma once

namespace styled::runtime {

// Lets one thread end another thread's wait: an eventfd that the waiting thread polls for reading.
// Any thread may call Signal(), the waiting thread calls Clear(). Neither blocks. The constructor
// throws std::runtime_error when the system has no descriptor left.
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
