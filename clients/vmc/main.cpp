#include <google/protobuf/stubs/logging.h>

#include <csignal>
#include <iostream>

#include "clients/vmc/cli.h"

namespace {

std::atomic<bool> stop_requested{false};

extern "C" void RequestStop(int) { stop_requested = true; }

}  // namespace

int main(int argc, char** argv) {
  // What does not parse is counted and dropped.
  google::protobuf::SetLogHandler(nullptr);
  // No SA_RESTART: a wait ends with the signal.
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return styled::stylevmc::Run({argv + 1, argv + argc}, stop_requested, std::cout, std::cerr);
}
