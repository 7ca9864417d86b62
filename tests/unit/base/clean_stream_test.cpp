#include "model/base/clean_stream.h"

#include <gtest/gtest.h>

#include <sstream>

namespace styled {
namespace {

std::string Clean(const std::string& text) {
  std::ostringstream target;
  CleanStream clean(target);
  clean << text << std::flush;
  return target.str();
}

TEST(CleanStream, LeavesTextAsItIs) {
  EXPECT_EQ(Clean("Tänzerin: 3 °\nnext\n"), "Tänzerin: 3 °\nnext\n");
  EXPECT_EQ(Clean("half a line"), "half a line");
  EXPECT_EQ(Clean(""), "");
}

TEST(CleanStream, NothingMovesTheCursor) {
  EXPECT_EQ(Clean("\x1b[31mred\a\r"), "\\x1b[31mred\\x07\\x0d");
  EXPECT_EQ(Clean("\xff\n"), "\xEF\xBF\xBD\n");
  EXPECT_EQ(Clean("a\u202Eb"), "a\\u202eb");
}

TEST(CleanStream, JsonStaysJson) {
  EXPECT_EQ(Clean("{\"name\":\"\u009b\x7f\"}\n"), "{\"name\":\"\\u009b\\u007f\"}\n");
}

TEST(CleanStream, FailsAsItsTargetDoes) {
  std::ostringstream target;
  CleanStream clean(target);
  target.setstate(std::ios::badbit);
  clean << "text\n" << std::flush;
  EXPECT_FALSE(clean);
}

}  // namespace
}  // namespace styled
