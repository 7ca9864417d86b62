#pragma once

namespace styled::support {

// Counts calls of operator new and malloc while it exists (a sanitizer's malloc is not counted).
// Code that must not allocate passes if calls() is 0. The binary needs count_new.cpp among its
// sources. One instance at a time.
class CountNew {
 public:
  CountNew();
  ~CountNew();
  CountNew(const CountNew&) = delete;
  CountNew& operator=(const CountNew&) = delete;
  int calls() const;
  static bool CountsMalloc();
};

}  // namespace styled::support
