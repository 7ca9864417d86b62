#include "model/train/stgcn_causal/style_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace styled::train::st_gcn_causal {
namespace {

using testing::HasSubstr;

class StyleFileTest : public testing::Test {
 protected:
  StyleFileTest()
      : folder_(std::filesystem::temp_directory_path() / ("style" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~StyleFileTest() override { std::filesystem::remove_all(folder_); }

  std::string Refusal(const std::string& text) {
    std::ofstream(folder_ / "bad.json") << text;
    const auto read = ReadStyleFile(folder_ / "bad.json");
    EXPECT_FALSE(read.ok()) << text;
    EXPECT_THAT(read.status().message(), HasSubstr("bad.json: "));
    return read.ok() ? "" : read.status().message();
  }

  const std::filesystem::path folder_;
};

TEST_F(StyleFileTest, BrokenFilesAreRefused) {
  EXPECT_THAT(ReadStyleFile(folder_ / "none.json").status().message(), HasSubstr("none.json"));
  EXPECT_THAT(ReadStyleFile(folder_).status().message(), HasSubstr("folder"));
  const std::string format = R"("format": "styled style 1", )";
  for (const std::string text :
       {std::string(), std::string("[]"), std::string("{"), std::string("{}"),
        std::string("{\"format\": 1}"), std::string("{\"format\": \"styled style 2\"}")}) {
    EXPECT_THAT(Refusal(text), HasSubstr("expected a JSON object with \"format\""));
  }
  EXPECT_THAT(Refusal("{" + format + R"("name": "a", "code": [1]})"), HasSubstr("\"weights\""));
  EXPECT_THAT(Refusal("{" + format + R"("name": 3, "weights": "w", "code": [1]})"),
              HasSubstr("\"name\""));
  for (const std::string code : {"", R"(, "code": 1)", R"(, "code": [])", R"(, "code": [1, "2"])",
                                 R"(, "code": [1e300])", R"(, "code": [null])"}) {
    EXPECT_THAT(Refusal("{" + format + R"("name": "a", "weights": "w")" + code + "}"),
                HasSubstr("\"code\" with finite numbers"));
  }
  EXPECT_THAT(Refusal("{" + std::string(300000, ' ') + "}"), HasSubstr("larger than the limit"));
}

TEST_F(StyleFileTest, UnknownKeysAreKept) {
  std::ofstream(folder_ / "pirate.json")
      << R"({"format": "styled style 1", "name": "pirate", "weights": "crc32c:1", "code": [1, 2],
            "licence": "mine", "source": "p.bvh"})";
  auto read = ReadStyleFile(folder_ / "pirate.json");
  ASSERT_TRUE(read.ok()) << read.status().message();
  read.value().code = {0.5F, -1.25F, 3};
  ASSERT_TRUE(WriteStyleFile(read.value(), folder_ / "other.json").ok());
  const auto again = ReadStyleFile(folder_ / "other.json");
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(again.value().code, read.value().code);
  EXPECT_EQ(again.value().name, "other") << "of the file";
  EXPECT_EQ(again.value().weights, "crc32c:1");
  EXPECT_EQ(again.value().all["licence"], "mine");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_),
                          std::filesystem::directory_iterator()),
            2)
      << "no partial file";
}

TEST_F(StyleFileTest, AFolderThatIsMissingIsAnError) {
  StyleFile style;
  style.all = {{"format", "styled style 1"}};
  EXPECT_THAT(WriteStyleFile(style, folder_ / "none" / "a.json").message(), HasSubstr("a.json"));
}

}  // namespace
}  // namespace styled::train::st_gcn_causal
