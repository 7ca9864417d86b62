// stylize --sheet: the page of all outputs, read as a browser reads it.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/e2e/tools.h"
#include "tests/unit/net/offset/weights.h"

namespace styled::support {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class StylizeSheet : public ToolsTest {
 protected:
  StylizeSheet() {
    offset::WriteTestWeights(weights_);
    fs::create_directories(in_);
    fs::copy_file(Walk("30", "2"), in_ + "/a<!--b>.bvh");
    fs::copy_file(Walk("60", "12"), in_ + "/b.bvh");
    WriteText(in_ + "/broken.bvh", "HIERARCHY\n");
  }
  int Stylize(std::vector<std::string> words) {
    words.insert(words.begin(), {STYLIZE_BINARY, "--weights", weights_});
    return Run(words);
  }
  static nlohmann::json DataOf(const std::string& page) {
    const std::string begin = "id=\"data\">";
    const std::size_t at = page.find(begin) + begin.size();
    return nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at));
  }

  const std::string weights_ = folder_ / "weights", in_ = folder_ / "in";
  const std::string sheet_ = folder_ / "sheet.html";
};

TEST_F(StylizeSheet, EveryClipInEveryStyleIsInOneFileThatLoadsNothing) {
  EXPECT_EQ(Stylize({"-s", "bent,raised", "--sheet", sheet_, in_}), 1) << "one clip is broken";
  EXPECT_THAT(output_, HasSubstr("broken.bvh:2: found the end"));
  EXPECT_EQ(std::distance(fs::directory_iterator(in_), {}), 3) << "no clip is written";
  const std::string page = ReadText(sheet_);
  EXPECT_THAT(page, Not(HasSubstr("http:")));
  EXPECT_THAT(page, Not(HasSubstr("https:")));
  EXPECT_THAT(page, Not(HasSubstr("src=")));
  EXPECT_THAT(page, Not(HasSubstr("a<!--b"))) << "a name is no markup";
  const nlohmann::json data = DataOf(page);
  ASSERT_EQ(data["rows"].size(), 3U);
  const auto& row = data["rows"][0];
  EXPECT_THAT(row["clip"].get<std::string>(), HasSubstr("a<!--b>.bvh"));
  ASSERT_EQ(row["cells"].size(), 2U);
  EXPECT_EQ(row["cells"][0]["style"], "bent");
  EXPECT_NE(row["cells"][0]["figure"], row["cells"][1]["figure"]);
  EXPECT_NE(row["cells"][0]["figure"], row["input"]);
  EXPECT_THAT(row["cells"][0]["numbers"][0].get<std::string>(), HasSubstr("a foot stands in "));
  EXPECT_NEAR(data["rows"][1]["seconds"].get<double>(), 12, 0.1);
  EXPECT_THAT(data["rows"][2]["cells"][0]["error"].get<std::string>(), HasSubstr("expected ROOT"));
  // The first ten seconds, 2.5 kB each.
  const std::size_t bytes = data["rows"][1]["input"].get<std::string>().size();
  EXPECT_EQ(bytes, 151 * data["joints"].get<std::size_t>() * 6 * 4 / 3);
}

TEST_F(StylizeSheet, TheHipsAreWhereTheClipHasThem) {
  ASSERT_EQ(Stylize({"-q", "-s", "bent", "--sheet", sheet_, in_ + "/b.bvh"}), 0) << output_;
  const std::string text = DataOf(ReadText(sheet_))["rows"][0]["input"];
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto byte = [&](std::size_t i) {
    const std::size_t at = i / 3 * 4;
    unsigned group = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      group = group << 6U | static_cast<unsigned>(digits.find(text[at + k]));
    }
    return group >> (16 - 8 * (i % 3)) & 0xFFU;
  };
  const auto millimetres = [&](std::size_t frame, std::size_t axis) {
    const std::size_t at = 2 * (frame * 21 * 3 + axis);
    return static_cast<std::int16_t>(byte(at) | byte(at + 1) << 8U);
  };
  EXPECT_EQ(millimetres(0, 0), 0);
  EXPECT_EQ(millimetres(0, 2), 0);
  for (const std::size_t frame : {0U, 75U, 150U}) {
    EXPECT_NEAR(millimetres(frame, 1), 950, 60) << "above the floor";
  }
  const double way = std::hypot(millimetres(150, 0), millimetres(150, 2));
  EXPECT_GT(way, 5000) << "ten seconds of a walk";
  EXPECT_LT(way, 20000);
}

TEST_F(StylizeSheet, NothingToShowIsAnErrorAndNoFile) {
  const std::string empty = folder_ / "empty";
  fs::create_directory(empty);
  EXPECT_EQ(Stylize({"-s", "bent", "--sheet", sheet_, empty}), 1);
  EXPECT_THAT(output_, HasSubstr("empty: found a folder without .bvh, .glb and .vrma files"));
  EXPECT_THAT(output_, HasSubstr("sheet.html: is not written: found no output to show"));
  EXPECT_EQ(Stylize({"-s", "bent", "--sheet", sheet_, in_ + "/broken.bvh"}), 1);
  EXPECT_FALSE(fs::exists(sheet_));
  EXPECT_EQ(Stylize({"-s", "bent", "--sheet", folder_ / "sheet.pdf", in_}), 2);
  EXPECT_THAT(output_, HasSubstr("sheet.pdf: expected a file .html"));
  EXPECT_EQ(Stylize({"-s", "bent", "--sheet", sheet_}), 2);
  WriteText(sheet_, "precious");
  EXPECT_EQ(Stylize({"-s", "bent", "--sheet", sheet_, in_ + "/b.bvh"}), 1);
  EXPECT_THAT(output_, HasSubstr("sheet.html: exists, expected a new file"));
  EXPECT_EQ(ReadText(sheet_), "precious");
}

TEST_F(StylizeSheet, ClipsAreWrittenBesidesIfTheyAreNamed) {
  const std::string out = folder_ / "out";
  ASSERT_EQ(Stylize({"-s", "bent", "--sheet", sheet_, "-o", out + "/{name}.bvh", in_ + "/b.bvh"}),
            0)
      << output_;
  EXPECT_TRUE(fs::exists(out + "/b.bvh"));
  EXPECT_EQ(DataOf(ReadText(sheet_))["rows"].size(), 1U);
}

}  // namespace
}  // namespace styled::support
