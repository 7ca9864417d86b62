#include <iostream>

#include "clients/stylectl/cli.h"

int main(int argc, char** argv) {
  return styled::stylectl::Run({argv + 1, argv + argc}, std::cout, std::cerr);
}
