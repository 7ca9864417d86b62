#include <gtest/gtest.h>

#include "daemon/config/address.h"
#include "daemon/config/config.h"
#include "proto/rigs/types.h"

namespace styled::config {
namespace {

TEST(DefaultsTest, EverythingIsOnLoopbackUnlessToldOtherwise) {
  const Config config;
  EXPECT_TRUE(IsLocal(config.publish.address)) << config.publish.address;
  EXPECT_TRUE(IsLocal(config.control.address)) << config.control.address;
  EXPECT_FALSE(config.publish.allow_unauthenticated_remote);
  EXPECT_FALSE(config.control.allow_unauthenticated_remote);
  EXPECT_EQ(config.osc.listen, "") << "off";
  ASSERT_FALSE(config.sources.empty());
  for (const Source& source : config.sources) {
    EXPECT_TRUE(source.listen.starts_with("127.0.0.1:")) << source.listen;
  }
}

TEST(DefaultsTest, ARigThatIsNamedListensOnEveryInterface) {
  int rigs = 0;
  for (const auto& type : rigs::kSourceTypes) {
    if (type.usual_address.empty()) continue;
    EXPECT_TRUE(type.usual_address.starts_with("0.0.0.0:")) << type.name;
    ++rigs;
  }
  EXPECT_GT(rigs, 5);
}

}  // namespace
}  // namespace styled::config
