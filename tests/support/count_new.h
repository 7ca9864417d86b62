#pragma once

namespace styled::support {

// How often the scope's code asked for memory, with operator new or malloc (a sanitizer's malloc is
// not counted): a promise not to allocate is kept where calls() is 0. The binary needs
// count_new.cpp among its sources. One scope at a time.
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
