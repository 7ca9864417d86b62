#include <iostream>

#include "clients/cpp/stop.h"
#include "clients/nats/cli.h"

int main(int argc, char** argv) {
  return styled::stylenats::Run({argv + 1, argv + argc}, styled::client::StopOnSignals(), std::cout,
                                std::cerr);
}
