// styled_freeze PID THREAD: stops that thread, reports it, and waits until the process has been
// killed.
#include <cstdlib>
#include <iostream>

#include "tests/support/frozen_thread.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: styled_freeze PID THREAD\n";
    return 2;
  }
  styled::support::FrozenThread thread(std::atoi(argv[1]), argv[2]);
  if (!thread.frozen()) {
    std::cerr << "styled_freeze: " << thread.error() << "\n";
    return 1;
  }
  std::cout << "frozen" << std::endl;
  thread.AwaitDeath();
  return 0;
}
