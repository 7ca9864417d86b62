#include "tests/e2e/recordings/fixture.h"

namespace styled::support {

std::string StylerecBinary() { return STYLEREC_BINARY; }
std::string StylesimBinary() { return STYLESIM_BINARY; }

}  // namespace styled::support
