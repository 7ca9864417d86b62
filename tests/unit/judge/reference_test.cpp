#include "model/train/judge/reference.h"

#include <gtest/gtest.h>

#include <fstream>

#include "model/net/load.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/judge/walk.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::judge {
namespace {

TEST(WriteReference, RaisesTheVersionAndKeepsAllElse) {
  const support::TemporaryFolder folder;
  const std::filesystem::path file = folder / "old.safetensors";
  erd::WeightsFile made = erd::RandomWeights(3, 1);
  made.metadata["version"] = 1;
  made.metadata.erase("family");
  const auto bytes = made.Bytes();
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  ASSERT_FALSE(net::Load(file).value()->model().reference);
  neutral::Reference reference;
  reference.walking.rotations[body::kHead] = body::Exp(body::Vec3(0.2F, 0, 0));
  const Status status = WriteReference(reference, file);
  ASSERT_TRUE(status.ok()) << status.message();
  const auto network = net::Load(file);
  ASSERT_TRUE(network.ok()) << network.status().message();
  ASSERT_TRUE(network.value()->model().reference);
  EXPECT_TRUE(network.value()->model().reference->standing == reference.standing);
  EXPECT_LT(body::Angle_rad(network.value()->model().reference->walking.rotations[body::kHead],
                            reference.walking.rotations[body::kHead]),
            1e-5);
  EXPECT_EQ(network.value()->model().styles.size(), 3U);
}

}  // namespace
}  // namespace styled::judge
