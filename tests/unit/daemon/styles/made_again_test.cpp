// Styles of other weights, when there are more of them than a start may take.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "daemon/styles/library.h"
#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"
#include "model/base/write_file.h"
#include "model/net/load.h"
#include "model/synthetic/performer.h"
#include "tests/support/temporary_folder.h"

namespace styled::pipeline {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(MadeAgain, WhatTheTimeLimitLeavesOutTheNextReloadMakes) {
  const support::TemporaryFolder folder;
  RuntimeConfig config;
  const auto network = net::Load(std::filesystem::path(STYLED_SHIPPED) / "graph.safetensors");
  ASSERT_TRUE(network.ok()) << network.status().message();
  config.network = config.loaded = network.value();
  config.own_styles = static_cast<int>(config.network->model().styles.size());
  config.weights_hash = "crc32c:00000001";
  config.style.library = folder / "styles";

  synthetic::Performer performer({});
  std::vector<body::Pose> poses(90);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    performer.Pose(static_cast<double>(i) / 30, poses[i]);
  }
  const std::string example = ExampleText(poses, 30, std::size_t{1} << 20);
  RuntimeConfig other = config;
  other.weights_hash = "crc32c:00000002";
  MadeStyle style;
  style.name = "mine";
  style.seconds = 3;
  style.code = {1, 2, 3};
  style.example = HashOfExample(example);
  std::filesystem::create_directories(config.style.library);
  ASSERT_TRUE(WriteFileAtomically(folder / "styles/mine.json", FormatStyleFile(style, other)).ok());
  ASSERT_TRUE(WriteFileAtomically(folder / "styles/mine.bvh", example).ok());

  ReadLibrary(config, milliseconds(0));
  EXPECT_FALSE(config.made.contains("mine"));
  EXPECT_THAT(config.complaints, ElementsAre(HasSubstr("; a reload makes the others")));
  config.complaints.clear();
  ReadLibrary(config);
  EXPECT_TRUE(config.made.contains("mine"));
  EXPECT_THAT(config.complaints, ElementsAre(HasSubstr("and is made again from its example")));
  // It is there: no third time.
  config.complaints.clear();
  ReadLibrary(config, milliseconds(0));
  EXPECT_TRUE(config.made.contains("mine"));
  EXPECT_THAT(config.complaints, ElementsAre());
}

}  // namespace
}  // namespace styled::pipeline
