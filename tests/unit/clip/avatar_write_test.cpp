#include "model/clip/avatar_write.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "model/clip/glb_write.h"
#include "model/clip/gltf_clip.h"
#include "model/synthetic/performer.h"
#include "model/synthetic/script.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/rig/rigs.h"

namespace styled::clip {
namespace {

using nlohmann::json;
using rig::Quat;
using rig::Vec3;
using testing::HasSubstr;

// The JSON of a .glb.
json DocumentOf(const std::string& bytes) {
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  return json::parse(bytes.substr(20, length));
}

Status WriteInto(const std::string& avatar_file, const AvatarSkeleton& avatar, const Motion& motion,
                 const std::string& file) {
  const auto read = AvatarFile::Read(avatar_file, avatar);
  return read.ok() ? read.value().Write(avatar, motion, file) : read.status();
}

class AvatarWrite : public testing::Test {
 protected:
  // An avatar with a mesh (that of FormatGlb), extras, and its nodes below one that scales, turns
  // and moves them. The spine has a matrix, which doubles what is below it; the bones there are
  // half as long.
  void SetUp() override {
    Motion still;
    still.skeleton = rig::HumanoidSkeleton();
    still.frames.emplace_back(still.skeleton);
    const auto bytes = FormatGlb(still).value();
    const std::string glb(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    json document = DocumentOf(glb);
    const auto nodes = document["nodes"].size();
    document["nodes"].push_back({{"name", "above"},
                                 {"children", {0}},
                                 {"translation", {0.5, 0.2, -1}},
                                 {"rotation", {0, 0.70710678, 0, 0.70710678}},
                                 {"scale", {2, 2, 2}}});
    document["scenes"][0]["nodes"] = {nodes, nodes - 1};
    json& spine = document["nodes"][body::kSpine];
    const auto at = spine["translation"];
    spine.erase("translation");
    spine.erase("rotation");
    spine["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, at[0], at[1], at[2], 1};
    std::vector<int> below = spine["children"];
    while (!below.empty()) {
      json& node = document["nodes"][static_cast<std::size_t>(below.back())];
      below.pop_back();
      for (auto& value : node["translation"]) value = value.get<float>() / 2;
      for (const int child : node.value("children", std::vector<int>())) below.push_back(child);
    }
    document["extras"] = {{"made_by", "an artist"}};
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, 4);
    Save(document, glb.substr(20 + length + 8));
  }
  void Save(const json& document, const std::string& binary) {
    binary_ = binary;
    ASSERT_TRUE(
        WriteBytes(JoinGlb(document.dump(), std::as_bytes(std::span(binary))).value(), file_).ok());
  }
  static std::string Bytes(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // The avatar, walking: in its own skeleton, metres, world space.
  static Motion Walk(const AvatarSkeleton& avatar) {
    Motion motion;
    motion.name = "walk elderly";
    motion.skeleton = avatar.binding->skeleton();
    motion.rate_hz = 30;
    synthetic::Options options;
    options.script = synthetic::ParseScript("walk:60").value();
    synthetic::Performer performer(options);
    body::Pose pose;
    for (int i = 0; i < 40; ++i) {
      performer.Pose(i / 30.0, pose);
      rig::RigPose frame(motion.skeleton);
      avatar.binding->Unbind(pose, avatar.rest, frame);
      motion.frames.push_back(frame);
    }
    return motion;
  }

  support::TemporaryFolder folder_;
  const std::string file_ = folder_ / "avatar.glb", out_ = folder_ / "out.glb";
  std::string binary_;
};

TEST_F(AvatarWrite, RefusesWhatIsNotTheAvatars) {
  const auto avatar = ReadAvatar(file_, "auto", {}).value();
  Motion other = Walk(avatar);
  other.frames[3].rotations.pop_back();
  EXPECT_THAT(WriteInto(file_, avatar, other, out_).message(),
              HasSubstr("out.glb: found no motion"));
  other = Walk(avatar);
  other.frames.clear();
  EXPECT_FALSE(WriteInto(file_, avatar, other, out_).ok());
  const Motion motion = Walk(avatar);
  json document = DocumentOf(Bytes(file_));
  document["images"] = {{{"uri", "skin.png"}}};
  Save(document, binary_);
  EXPECT_THAT(AvatarFile::Read(file_, avatar).status().message(),
              HasSubstr("avatar.glb: has images in other files"));
  EXPECT_FALSE(WriteInto(file_, avatar, motion, out_).ok());
  for (const std::string& broken :
       {std::string(), std::string("glTF"), Bytes(file_).substr(0, 60)}) {
    std::ofstream(file_, std::ios::binary) << broken;
    EXPECT_FALSE(WriteInto(file_, avatar, motion, out_).ok()) << broken.size();
  }
  EXPECT_THAT(WriteInto(folder_ / "none.glb", avatar, motion, out_).message(),
              HasSubstr("none.glb"));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

// Keys are kept in their order, for which each is compared with those before it.
TEST_F(AvatarWrite, RefusesJsonWhoseReadingTakesTooLong) {
  const auto avatar = ReadAvatar(file_, "auto", {}).value();
  const json good = DocumentOf(Bytes(file_));
  json document = good;
  for (int i = 0; i < 1024; ++i) document["extras"][std::to_string(i)] = 0;
  Save(document, binary_);
  EXPECT_THAT(AvatarFile::Read(file_, avatar).status().message(),
              HasSubstr("avatar.glb: found a JSON object of more than 1024 keys, expected"));
  document["extras"].erase("made_by");
  Save(document, binary_);
  EXPECT_TRUE(AvatarFile::Read(file_, avatar).ok());
  document = good;
  for (int i = 0; i < 64; ++i) document["extras"] = json::array({document["extras"]});
  Save(document, binary_);
  EXPECT_THAT(AvatarFile::Read(file_, avatar).status().message(),
              HasSubstr("avatar.glb: found JSON that is nested more than 64 deep, expected"));
  EXPECT_FALSE(WriteInto(file_, avatar, Walk(avatar), out_).ok());
}

// Many outputs of one avatar do not read its file again.
TEST_F(AvatarWrite, TheFileIsReadOnce) {
  const auto avatar = ReadAvatar(file_, "auto", {}).value();
  const auto read = AvatarFile::Read(file_, avatar);
  ASSERT_TRUE(read.ok()) << read.status().message();
  std::filesystem::remove(file_);
  std::string first;
  for (int i = 0; i < 2; ++i) {
    const Status written = read.value().Write(avatar, Walk(avatar), out_);
    ASSERT_TRUE(written.ok()) << written.message();
    if (i == 0) first = Bytes(out_);
  }
  EXPECT_EQ(Bytes(out_), first) << "the second as the first";
}

// What is no bone is written as it was, whatever its scale, and a matrix stays one.
TEST_F(AvatarWrite, NodesOfOddScaleStayAsTheyAre) {
  json document = DocumentOf(Bytes(file_));
  json& nodes = document["nodes"];
  const std::size_t first = nodes.size();
  for (const json& odd :
       {json{{"name", "hat"}, {"scale", {1, 1.5, 1}}},
        json{{"name", "sword"}, {"scale", {0, 0, 0}}},
        json{{"name", "earring"}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1}}}}) {
    nodes[body::kHead]["children"].push_back(nodes.size());
    document["skins"][0]["joints"].push_back(nodes.size());
    nodes.push_back(odd);
  }
  const json before = nodes;
  Save(document, binary_);
  const auto avatar = ReadAvatar(file_, "auto", {});
  ASSERT_TRUE(avatar.ok()) << avatar.status().message();
  const Status status = WriteInto(file_, avatar.value(), Walk(avatar.value()), out_);
  ASSERT_TRUE(status.ok()) << status.message();
  const json after = DocumentOf(Bytes(out_));
  for (std::size_t node = first; node < before.size(); ++node) {
    EXPECT_EQ(after["nodes"][node], before[node]);
  }
  for (const json& channel : after["animations"][0]["channels"]) {
    EXPECT_LT(channel["target"]["node"].get<std::size_t>(), first);
  }
  const auto read = ParseGltfClip(Bytes(out_), "out.glb");
  EXPECT_TRUE(read.ok()) << read.status().message();
}

TEST_F(AvatarWrite, KeepsMeshesAndAddsTheMotion) {
  const auto avatar = ReadAvatar(file_, "auto", {});
  ASSERT_TRUE(avatar.ok()) << avatar.status().message();
  const Motion motion = Walk(avatar.value());
  const Status status = WriteInto(file_, avatar.value(), motion, out_);
  ASSERT_TRUE(status.ok()) << status.message();
  const json before = DocumentOf(Bytes(file_)), after = DocumentOf(Bytes(out_));
  for (const char* const kept : {"meshes", "materials", "skins", "scenes", "extras"}) {
    EXPECT_EQ(after[kept], before[kept]) << kept;
  }
  EXPECT_EQ(after["animations"].size(), before["animations"].size() + 1);
  EXPECT_EQ(after["animations"][0]["name"], "walk elderly");
  EXPECT_FALSE(after["nodes"][body::kSpine].contains("matrix"));
  EXPECT_THAT(Bytes(out_), HasSubstr(binary_.substr(0, 4096))) << "its data are there";

  // Read back, every joint is where the motion has it.
  const auto read = ParseGltfClip(Bytes(out_), "out.glb");
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read.value().clip.frames.size(), motion.frames.size());
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    std::vector<Vec3> expected, found;
    std::vector<Quat> turns;
    rig::WorldTransforms(motion.skeleton, motion.frames[i], expected, turns);
    rig::WorldTransforms(read.value().clip.skeleton, read.value().clip.frames[i], found, turns);
    for (std::size_t joint = 0; joint < expected.size(); ++joint) {
      ASSERT_LT((expected[joint] - found[joint]).norm(), 1e-4F) << i << " " << joint;
    }
  }
}

}  // namespace
}  // namespace styled::clip
