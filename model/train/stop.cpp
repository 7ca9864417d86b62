#include "model/train/stop.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <string_view>

namespace styled::train {
namespace {

std::atomic<int> asked = 0;  // lock-free, so a signal handler may set it
struct sigaction before_int, before_term;

// Only calls that a signal handler may make.
void Ask(int signal) {
  asked = signal;
  constexpr std::string_view kText =
      "\nstyletrain: ends after this step; once more to end at once, without a checkpoint\n";
  const ssize_t written = ::write(STDERR_FILENO, kText.data(), kText.size());
  static_cast<void>(written);
}

}  // namespace

StopOnSignal::StopOnSignal() {
  asked = 0;
  struct sigaction action {};
  action.sa_handler = Ask;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, &before_int);
  ::sigaction(SIGTERM, &action, &before_term);
}

StopOnSignal::~StopOnSignal() {
  ::sigaction(SIGINT, &before_int, nullptr);
  ::sigaction(SIGTERM, &before_term, nullptr);
}

int StopSignal() noexcept { return asked; }

}  // namespace styled::train
