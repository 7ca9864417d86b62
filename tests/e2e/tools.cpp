#include "tests/e2e/tools.h"

namespace styled::support {

std::string ToolsTest::Walk(const std::string& rate_hz, const std::string& seconds) {
  const std::string file = folder_ / ("walk" + rate_hz + ".bvh");
  EXPECT_EQ(Run({STYLESIM_BINARY, "--script", "walk:60", "--write", file, "--seconds", seconds,
                 "--rate", rate_hz}),
            0)
      << output_;
  return file;
}

}  // namespace styled::support
