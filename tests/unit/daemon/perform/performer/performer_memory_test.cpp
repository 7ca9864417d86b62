// A performer's share of the memory that the unit limits, and the daemon's report of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "daemon/config/machine.h"
#include "daemon/perform/roster.h"
#include "model/net/load.h"
#include "tests/support/child.h"
#include "tests/support/count_new.h"
#include "tests/support/rig.h"
#include "tests/support/temporary_folder.h"

namespace styled::pipeline {
namespace {

using testing::HasSubstr;

source::SourceFrame BodyOf(const support::Rig& rig) {
  source::SourceFrame frame;
  frame.is_body = true;
  frame.body = std::make_shared<const v1::Body>(rig.MakeBody());
  frame.body_crc = 1;
  return frame;
}

// With every network that is shipped. Once each performer had a second stylist, only to bring data
// into the caches before a frame, this was 3.4 MB.
TEST(PerformerMemory, APerformerNeedsTheMemoryThatTheWarningAssumes) {
  if (!support::CountNew::CountsMalloc()) GTEST_SKIP() << "malloc is a sanitizer's here";
  for (const auto& file : std::filesystem::directory_iterator(STYLED_SHIPPED)) {
    if (file.path().extension() != ".safetensors") continue;
    const auto network = net::Load(file.path());
    if (!network.ok()) continue;  // of clips alone
    auto config = std::make_shared<RuntimeConfig>();
    config->network = network.value();
    config->performers.max_performers = 64;
    runtime::Counters counters;
    publish::Subscriptions subscriptions(10, counters);
    Roster roster({"rig"}, config, 1, subscriptions, counters);
    const auto add = [&](int number) {
      const std::string name = "p" + std::to_string(number);
      Performer* const performer = roster.Add(0, name, 1);
      ASSERT_NE(performer, nullptr);
      const Status bound = performer->AcceptBody(BodyOf(support::Rig(name)), *config);
      ASSERT_TRUE(bound.ok()) << bound.message();
    };
    add(0);  // what all share
    constexpr int kMore = 16;
    const support::CountNew count;
    for (int i = 1; i <= kMore; ++i) add(i);
    EXPECT_LE(count.peak_bytes(), kMore * config::kPerformerBytes) << file.path();
    std::printf("%s: %zu bytes per performer\n", file.path().filename().c_str(),
                count.peak_bytes() / kMore);
  }
}

TEST(PerformerMemory, ALimitThatIsTooSmallIsNamedWithWhatFits) {
  constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
  EXPECT_EQ(config::MemoryWarning(64, kGiB), "");
  EXPECT_EQ(config::MemoryWarning(1024, std::nullopt), "");
  EXPECT_EQ(config::MemoryWarning(1024, 4 * kGiB), "");
  const std::string said = config::MemoryWarning(1024, kGiB);
  EXPECT_EQ(
      said,
      "performers.max_performers: found 1024, which need about 2208M of memory, but the limit "
      "is 1024M, enough for 432; expected MemoryMax=2208M in the unit, or fewer performers");
  EXPECT_THAT(config::MemoryWarning(1, 1000), HasSubstr("enough for 0;"));
}

TEST(PerformerMemory, TheSmallestLimitOfTheControlGroupsCounts) {
  support::TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    support::WriteText(folder.path() / name, text);
  };
  const auto limit = [&] {
    return config::MemoryLimit(folder.path() / "cgroup", folder.path() / "fs");
  };
  EXPECT_EQ(limit(), std::nullopt) << "no control groups";
  write("cgroup", "12:memory:/old\n0::/a.slice/styled.service\n");
  EXPECT_EQ(limit(), std::nullopt) << "no limits";
  write("fs/a.slice/styled.service/memory.max", "max\n");
  EXPECT_EQ(limit(), std::nullopt);
  write("fs/a.slice/memory.max", "2147483648\n");
  EXPECT_EQ(limit(), 2147483648U);
  write("fs/a.slice/styled.service/memory.max", "1073741824\n");
  EXPECT_EQ(limit(), 1073741824U);
  write("cgroup", "12:memory:/old\n");
  EXPECT_EQ(limit(), std::nullopt) << "of version 1";
}

}  // namespace
}  // namespace styled::pipeline
