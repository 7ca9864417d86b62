#include "clients/cpp/stop.h"

#include <google/protobuf/stubs/logging.h>

#include <csignal>

namespace styled::client {
namespace {

std::atomic<bool> stop_requested{false};

extern "C" void RequestStop(int) { stop_requested = true; }

}  // namespace

const std::atomic<bool>& StopOnSignals() {
  google::protobuf::SetLogHandler(nullptr);
  // Without SA_RESTART a signal ends a wait.
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return stop_requested;
}

}  // namespace styled::client
