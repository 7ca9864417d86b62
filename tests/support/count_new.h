#pragma once

#include <cstddef>

namespace styled::support {

// Counts calls of operator new and malloc while it exists (a sanitizer's malloc is not counted),
// and the most bytes that all threads together had taken more than at its beginning. Code that must
// not allocate passes if calls() is 0. The binary needs count_new.cpp among its sources. One
// instance at a time.
class CountNew {
 public:
  CountNew();
  ~CountNew();
  CountNew(const CountNew&) = delete;
  CountNew& operator=(const CountNew&) = delete;
  int calls() const;
  std::size_t peak_bytes() const;  // 0 unless CountsMalloc()
  static bool CountsMalloc();
};

}  // namespace styled::support
