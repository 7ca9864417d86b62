#include <iostream>

#include "clients/cpp/stop.h"
#include "clients/oscquery/cli.h"

int main(int argc, char** argv) {
  return styled::oscquery::Run({argv + 1, argv + argc}, styled::client::StopOnSignals(), std::cout,
                               std::cerr);
}
