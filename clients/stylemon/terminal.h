#pragma once

#include <memory>

#include "clients/stylemon/canvas.h"
#include "model/base/status.h"

namespace styled::stylemon {

// The terminal under curses; the destructor restores it. At most one instance at a time; one
// thread.
class Terminal {
 public:
  // Fails for a terminal that curses does not know. Set the locale before.
  static Result<std::unique_ptr<Terminal>> Open();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  int columns() const;  // current size; changes when the window is resized
  int rows() const;
  void Show(const Canvas& canvas);
  int Read();  // the next key, or -1 if none was pressed; never waits

  // Codes of keys that are not characters.
  static constexpr int kUp = 1001, kDown = 1002, kLeft = 1003, kRight = 1004, kBackTab = 1005;

 private:
  struct Impl;
  explicit Terminal(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace styled::stylemon
