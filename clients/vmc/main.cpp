#include <iostream>

#include "clients/cpp/stop.h"
#include "clients/vmc/cli.h"

int main(int argc, char** argv) {
  return styled::stylevmc::Run({argv + 1, argv + argc}, styled::client::StopOnSignals(), std::cout,
                               std::cerr);
}
