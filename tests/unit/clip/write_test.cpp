#include "model/clip/write.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "model/clip/glb_write.h"
#include "tests/support/temporary_folder.h"

namespace styled::clip {
namespace {

using testing::HasSubstr;

Motion Standing() {
  Motion motion;
  for (const body::JointRow& row : body::kHumanoid) {
    motion.skeleton.names.emplace_back(row.name);
    motion.skeleton.parents.push_back(row.parent);
    motion.skeleton.offsets.emplace_back(row.x_m, row.y_m, row.z_m);
  }
  motion.rate_hz = 60;
  motion.frames.assign(3, rig::RigPose(motion.skeleton));
  return motion;
}

std::string Read(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Write, ChoosesTheFormatByTheExtension) {
  const support::TemporaryFolder folder;
  const Motion motion = Standing();
  const auto glb = FormatGlb(motion).value();
  const std::string glb_text(reinterpret_cast<const char*>(glb.data()), glb.size());
  for (const auto& [name, expected] :
       {std::pair{"a.bvh", FormatBvh(motion)}, std::pair{"b.BVH", FormatBvh(motion)},
        std::pair{"a.glb", glb_text}, std::pair{"a.bvh.Glb", glb_text}}) {
    const Status status = Write(folder / name, motion);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(Read(folder / name), expected) << name;
  }
}

TEST(Write, RefusesAnUnknownExtensionAndListsTheKnownOnes) {
  const support::TemporaryFolder folder;
  for (const auto& [name, found] :
       {std::pair{"a.fbx", "extension .fbx"}, std::pair{"a", "no extension"},
        std::pair{".bvh", "no extension"}, std::pair{"a.", "extension ."}}) {
    const std::string file = folder / name;
    EXPECT_EQ(Write(file, Standing()).message(),
              file + ": found " + found + ", expected one of " + FormatNames());
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

TEST(Write, ErrorsNameTheFile) {
  for (const Format& format : Formats()) {
    const std::string file = "/nonexistent/a" + std::string(format.extension);
    EXPECT_THAT(Write(file, Standing()).message(), HasSubstr(file));
    EXPECT_THAT(FormatNames(), HasSubstr(format.extension));
  }
}

TEST(Write, AFormatOfAConstantRateRefusesTimesPerFrame) {
  const support::TemporaryFolder folder;
  Motion motion = Standing();
  motion.times_s = {0, 0.1, 0.2};
  for (const Format& format : Formats()) {
    const Status status = Write(folder / "a" + std::string(format.extension), motion);
    EXPECT_EQ(status.ok(), !format.constant_rate) << status.message();
  }
}

}  // namespace
}  // namespace styled::clip
