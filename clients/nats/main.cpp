#include <google/protobuf/stubs/logging.h>

#include <csignal>
#include <iostream>

#include "clients/nats/cli.h"

namespace {

std::atomic<bool> stop_requested{false};

extern "C" void RequestStop(int) { stop_requested = true; }

}  // namespace

int main(int argc, char** argv) {
  // Unparseable messages are counted and dropped, not logged.
  google::protobuf::SetLogHandler(nullptr);
  // Without SA_RESTART a signal ends a wait.
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return styled::stylenats::Run({argv + 1, argv + argc}, stop_requested, std::cout, std::cerr);
}
