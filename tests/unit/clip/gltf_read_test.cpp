#include "model/clip/gltf_read.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "model/clip/avatar.h"
#include "model/clip/glb_write.h"
#include "model/rig/calibration.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/rig/rigs.h"

namespace styled::clip {
namespace {

using body::kHumanoid;
using body::Random;
using nlohmann::json;
using rig::Quat;
using rig::Vec3;
using testing::HasSubstr;

json Floats(const Vec3& v) { return json::array({v.x(), v.y(), v.z()}); }
json Floats(const Quat& q) { return json::array({q.x(), q.y(), q.z(), q.w()}); }

// The canonical humanoid below a node of an exporter that uses centimetres and Z up, one metre
// aside, with two fingers of the same name; a camera and a hat are not bones.
json Avatar() {
  json nodes = json::array();
  const Quat z_up(Eigen::AngleAxisf(-1.5707963F, Vec3::UnitX()));
  nodes.push_back({{"name", "Armature"},
                   {"translation", {1, 0, 0}},
                   {"rotation", Floats(z_up)},
                   {"scale", {0.01, 0.01, 0.01}},
                   {"children", {1}}});
  for (int c = 0; c < body::kJointCount; ++c) {
    Vec3 offset = 100 * body::Offset(c);
    json node = {{"name", std::string(kHumanoid[static_cast<std::size_t>(c)].name)}};
    if (c == 0) {
      offset = z_up.conjugate() * Vec3(0, 95, 0);
      node["rotation"] = Floats(Quat(z_up.conjugate()));
    }
    node["translation"] = Floats(offset);
    for (int child = c + 1; child < body::kJointCount; ++child) {
      if (kHumanoid[static_cast<std::size_t>(child)].parent == c) {
        node["children"].push_back(child + 1);
      }
    }
    nodes.push_back(node);
  }
  for (int i = 0; i < 2; ++i) {
    nodes[1 + body::kLeftHand]["children"].push_back(nodes.size());
    nodes.push_back({{"name", "finger"}, {"translation", {8, 0, i}}});
  }
  nodes[1 + body::kHead]["children"].push_back(nodes.size());
  nodes.push_back({{"name", "hat"}, {"translation", {0, 20, 0}}});
  nodes.push_back({{"name", "camera"}});
  json joints = json::array();
  for (std::size_t i = 1; i < nodes.size() - 2; ++i) joints.push_back(i);
  return {{"asset", {{"version", "2.0"}}},
          {"nodes", nodes},
          {"skins", {{{"joints", joints}}}},
          {"scene", 0},
          {"scenes", {{{"nodes", {0, nodes.size() - 1}}}}}};
}

json Vrm(bool one) {
  json avatar = Avatar();
  for (std::size_t i = 1; i < avatar["nodes"].size(); ++i) {
    avatar["nodes"][i]["name"] = "bone" + std::to_string(i % 7);  // meaningless names
  }
  avatar.erase("skins");
  json object = json::object(), list = json::array();
  const auto add = [&](const std::string& bone, int node) {
    object[bone] = {{"node", node}};
    list.push_back({{"bone", bone}, {"node", node}, {"useDefaultValues", true}});
  };
  for (int c = 0; c < body::kJointCount; ++c) {
    add(std::string(kHumanoid[static_cast<std::size_t>(c)].name), c + 1);
  }
  add("leftIndexProximal", 1 + body::kJointCount);
  // The same bone of the thumb by the names of 1.0 and 0.x.
  add(one ? "leftThumbMetacarpal" : "leftThumbProximal", 2 + body::kJointCount);
  avatar["extensionsUsed"] = {one ? "VRMC_vrm" : "VRM"};
  avatar["extensions"] =
      one ? json{{"VRMC_vrm", {{"specVersion", "1.0"}, {"humanoid", {{"humanBones", object}}}}}}
          : json{{"VRM", {{"humanoid", {{"humanBones", list}}}}}};
  return avatar;
}

class GltfReadTest : public testing::Test {
 protected:
  Result<GltfSkeleton> Read(const std::string& text, const std::string& name = "avatar.gltf") {
    const std::string file = folder_ / name;
    std::ofstream(file, std::ios::binary) << text;
    return ReadGltfSkeleton(file);
  }
  void ExpectRefused(const std::function<void(json&)>& spoil, const std::string& why) {
    json avatar = Avatar();
    spoil(avatar);
    const auto read = Read(avatar.dump());
    ASSERT_FALSE(read.ok()) << why;
    EXPECT_THAT(read.status().message(), HasSubstr("avatar.gltf"));
    EXPECT_THAT(read.status().message(), HasSubstr(why));
  }

  support::TemporaryFolder folder_;
};

void ExpectHumanoid(const GltfSkeleton& read) {
  EXPECT_NEAR(read.above_scale, 0.01F, 1e-7F);
  EXPECT_LT((read.above_translation_m - Vec3(1, 0, 0)).norm(), 1e-6F);
  EXPECT_LT((read.skeleton.offsets[0] - Vec3(1, 0.95F, 0)).norm(), 1e-5F);
  std::vector<Vec3> positions;
  std::vector<Quat> rotations;
  rig::WorldTransforms(read.skeleton, read.stance, positions, rotations);
  body::WorldPose rest;
  body::Pose pose;
  pose.hips_position_m = Vec3(1, 0.95F, 0);
  body::ForwardKinematics(pose, rest);
  for (std::size_t c = 0; c < body::kJointCount; ++c) {
    const auto joint = static_cast<std::size_t>(read.source_joint[c]);
    ASSERT_LT(joint, positions.size()) << c;
    EXPECT_LT((positions[joint] - rest.positions_m[c]).norm(), 1e-5F) << kHumanoid[c].name;
    EXPECT_LT(body::Angle_rad(rotations[joint], Quat::Identity()), 1e-3F) << kHumanoid[c].name;
  }
  const auto binding =
      rig::BindStanding(read.skeleton, read.source_joint, read.stance, read.t_pose);
  ASSERT_TRUE(binding.ok()) << binding.status().message();
  body::Pose bound;
  binding.value().Bind(read.stance, bound);
  for (const Quat& q : bound.rotations) EXPECT_LT(body::Angle_rad(q, Quat::Identity()), 2e-3F);
}

TEST_F(GltfReadTest, ASkeletonByItsNamesWithWhatItHangsFrom) {
  const auto read = Read(Avatar().dump());
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_FALSE(read.value().t_pose);
  EXPECT_EQ(read.value().skeleton.joint_count(), body::kJointCount + 2);
  EXPECT_THAT(read.value().skeleton.names, testing::Contains("finger"));
  EXPECT_THAT(read.value().skeleton.names, testing::Contains("finger_23"));
  EXPECT_THAT(read.value().skeleton.names, testing::Not(testing::Contains("hat")));
  ExpectHumanoid(read.value());
}

// A stretched hat, a hidden sword, a mirrored earring, a lamp: no bone of the humanoid hangs there.
TEST_F(GltfReadTest, OddScalesBesideTheBonesAreLeftOut) {
  json avatar = Avatar();
  json& nodes = avatar["nodes"];
  const std::size_t hat = nodes.size() - 2, camera = nodes.size() - 1;
  ASSERT_EQ(nodes[hat]["name"], "hat");
  nodes[camera]["scale"] = {0, 0, 0};
  const auto hang = [&nodes](std::size_t from, const json& node) {
    nodes[from]["children"].push_back(nodes.size());
    nodes.push_back(node);
  };
  hang(hat, {{"name", "feather"}, {"translation", {0, 30, 0}}});
  hang(1 + body::kRightHand, {{"name", "sword"}, {"scale", {0, 0, 0}}});
  hang(1 + body::kHead, {{"name", "earring"}, {"scale", {-1, 1, 1}}});
  hang(1 + body::kHead, {{"name", "lamp"}, {"translation", {0, 1e60, 0}}});
  const auto control = Read(avatar.dump());
  // Also as joints of the skin, which are bones of the skeleton otherwise.
  json& joints = avatar["skins"][0]["joints"];
  for (std::size_t node = hat; node < nodes.size(); ++node) joints.push_back(node);
  nodes[hat]["scale"] = {1, 5, 1e-3};
  const auto read = Read(avatar.dump());
  for (const auto* const one : {&control, &read}) {
    ASSERT_TRUE(one->ok()) << one->status().message();
    EXPECT_EQ(one->value().skeleton.joint_count(), body::kJointCount + 2);
    ExpectHumanoid(one->value());
  }
  EXPECT_EQ(read.value().nodes, control.value().nodes);
  nodes[hat].erase("scale");
  const auto with_hat = Read(avatar.dump());
  ASSERT_TRUE(with_hat.ok()) << with_hat.status().message();
  EXPECT_THAT(with_hat.value().skeleton.names, testing::IsSupersetOf({"hat", "feather"}));
  // A finger is a bone.
  nodes[1 + body::kJointCount]["name"] = "leftIndexProximal";
  nodes[1 + body::kJointCount]["scale"] = {0, 0, 0};
  EXPECT_THAT(Read(avatar.dump()).status().message(), HasSubstr("\"leftIndexProximal\" has a tr"));
}

TEST_F(GltfReadTest, AVrmByItsOwnTableOfBones) {
  for (const bool one : {false, true}) {
    const auto read = Read(Vrm(one).dump());
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_TRUE(read.value().t_pose);
    EXPECT_EQ(read.value().skeleton.joint_count(), body::kJointCount + 2) << "hat and camera not";
    ExpectHumanoid(read.value());
    // Fingers by that table too, whatever they are called.
    const auto binding = rig::BindStanding(read.value().skeleton, read.value().source_joint,
                                           read.value().stance, read.value().t_pose);
    const rig::Tail tail = rig::Tail::Make(binding.value(), read.value().tail);
    ASSERT_EQ(tail.size(), 2U);
    EXPECT_EQ(rig::kTailNames[static_cast<std::size_t>(tail.joints()[0].joint)],
              "leftThumbMetacarpal");
    EXPECT_EQ(rig::kTailNames[static_cast<std::size_t>(tail.joints()[1].joint)],
              "leftIndexProximal");
  }
}

TEST_F(GltfReadTest, AMatrixIsATransformToo) {
  json avatar = Avatar();
  Eigen::Affine3f affine = Eigen::Affine3f::Identity();
  affine.translate(Vec3(1, 0, 0));
  affine.rotate(Quat(Eigen::AngleAxisf(-1.5707963F, Vec3::UnitX())));
  affine.scale(0.01F);
  json& armature = avatar["nodes"][0];
  for (const char* key : {"translation", "rotation", "scale"}) armature.erase(key);
  const Eigen::Matrix4f matrix = affine.matrix();
  armature["matrix"] = std::vector<float>(matrix.data(), matrix.data() + 16);
  const auto read = Read(avatar.dump());
  ASSERT_TRUE(read.ok()) << read.status().message();
  ExpectHumanoid(read.value());
}

TEST_F(GltfReadTest, ABinaryFileOfOurOwnIsRead) {
  Motion motion;
  motion.skeleton = rig::HumanoidSkeleton();
  motion.times_s = {0, 1};
  motion.frames = {rig::RigPose(motion.skeleton), rig::RigPose(motion.skeleton)};
  const auto bytes = FormatGlb(motion);
  ASSERT_TRUE(bytes.ok());
  const auto* text = reinterpret_cast<const char*>(bytes.value().data());
  const auto read = Read(std::string(text, bytes.value().size()), "ours.glb");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read.value().skeleton.names, motion.skeleton.names);
}

TEST_F(GltfReadTest, AnAPoseIsSwungAndAVrmOutOfTPoseIsRefused) {
  const auto hang = [](json avatar) {
    for (const auto& [arm, angle] :
         {std::pair{body::kLeftUpperArm, -0.8F}, std::pair{body::kRightUpperArm, 0.8F}}) {
      avatar["nodes"][static_cast<std::size_t>(1 + arm)]["rotation"] =
          Floats(Quat(Eigen::AngleAxisf(angle, Vec3::UnitZ())));
    }
    return avatar;
  };
  const auto read = Read(hang(Avatar()).dump());
  ASSERT_TRUE(read.ok());
  const auto binding = rig::BindStanding(read.value().skeleton, read.value().source_joint,
                                         read.value().stance, false);
  ASSERT_TRUE(binding.ok()) << binding.status().message();
  body::Pose bound;
  binding.value().Bind(read.value().stance, bound);
  const Quat arm = bound.rotations[body::kLeftUpperArm];
  EXPECT_LT(body::Angle_rad(arm, Quat(Eigen::AngleAxisf(-0.8F, Vec3::UnitZ()))), 0.02F);

  const auto vrm = Read(hang(Vrm(true)).dump());
  ASSERT_TRUE(vrm.ok());
  const auto refused = rig::BindStanding(vrm.value().skeleton, vrm.value().source_joint,
                                         vrm.value().stance, vrm.value().t_pose);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.status().message(), HasSubstr("46 degrees off a T-pose"));
}

TEST_F(GltfReadTest, AFileWithoutAnAvatarIsRefusedWithTheReason) {
  EXPECT_THAT(ReadGltfSkeleton("/nowhere/a.vrm").status().message(),
              HasSubstr("/nowhere/a.vrm: No such file"));
  EXPECT_THAT(ReadGltfSkeleton("/").status().message(), HasSubstr("is a folder"));
  constexpr const char* kExpected = ", expected an avatar's .vrm, .glb or .gltf";
  for (const auto& [text, found] : std::vector<std::pair<std::string, std::string>>{
           {"HIERARCHY\nROOT hips\n",
            "avatar.gltf: is not glTF 2.0: found a file that begins with \"HIERARCHY?ROOT h\""},
           {"\x7F"
            "ELF\x02",
            "found a file that begins with \"?ELF?\""},
           {"", "found an empty file"},
           {"  \n{\"asset\": {\"version\": 2,,", "found JSON that cannot be read"},
           {"glTF\x02", "is not glTF 2.0: "}}) {
    const std::string message = Read(text).status().message();
    EXPECT_THAT(message, HasSubstr(found));
    EXPECT_TRUE(message.ends_with(kExpected)) << message;
    EXPECT_THAT(message, testing::Not(HasSubstr("json.exception"))) << message;
  }
  const auto node = [](std::size_t index) {
    const std::string_view name = index == 0 ? "Armature" : kHumanoid[index - 1].name;
    return "node " + std::to_string(index) + " \"" + std::string(name) + "\" ";
  };
  constexpr const char* kRigid = "has a transform that is not a rotation and scale, expected the";
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{1} + body::kLeftUpperArm,
        std::size_t{1} + body::kHead}) {
    ExpectRefused(
        [at](json& a) {
          a["nodes"][at]["scale"] = {1, 2, 1};
        },
        node(at) + "is stretched unevenly, expected the same positive scale");
    for (const json& scale : {json{0, 0, 0}, json{1, 1, 0}, json{-1, 1, 1}, json{1e200, 1, 1}}) {
      ExpectRefused([&](json& a) { a["nodes"][at]["scale"] = scale; }, node(at) + kRigid);
    }
  }
  ExpectRefused([](json& a) { a["nodes"][3]["translation"] = {0, 1e60, 0}; }, node(3) + kRigid);
  ExpectRefused(
      [](json& a) {
        for (const int at : {1, 2, 3, 6, 7}) a["nodes"][at]["scale"] = {9e8, 9e8, 9e8};
      },
      "found nodes whose scales multiply to more than a number holds, expected the same");
  ExpectRefused([](json& a) { a["nodes"][3]["children"] = {0}; }, node(0) + "is its own ancestor");
  ExpectRefused([](json& a) { a["nodes"][3]["children"] = {999}; }, node(3) + "has a child that");
  ExpectRefused([](json& a) { a["nodes"][2]["children"].push_back(21); },
                node(21) + "hangs from two nodes");
  ExpectRefused(
      [](json& a) {
        for (json& node : a["nodes"]) {
          node["name"] = "x";
          node.erase("children");
        }
      },
      "no bone named like hips");
}

TEST_F(GltfReadTest, Gltf1IsRefusedByItsName) {
  json avatar = Avatar();
  avatar["asset"]["version"] = "1.0";
  EXPECT_THAT(Read(avatar.dump()).status().message(),
              HasSubstr("avatar.gltf: is glTF 1.0, expected glTF 2.0"));
  avatar.erase("asset");
  EXPECT_THAT(Read(avatar.dump()).status().message(), HasSubstr("no asset.version"));
  // Binary glTF 1: version 1, then the lengths of the file and of its JSON, and the JSON's format.
  const std::string text = R"({"asset": {"version": "1.0"}, "nodes": {}})";
  std::string binary = "glTF";
  for (const std::uint32_t word : {std::uint32_t{1}, static_cast<std::uint32_t>(20 + text.size()),
                                   static_cast<std::uint32_t>(text.size()), std::uint32_t{0}}) {
    binary.append(reinterpret_cast<const char*>(&word), sizeof word);
  }
  EXPECT_THAT(Read(binary + text, "old.glb").status().message(),
              HasSubstr("old.glb: is glTF 1 in binary form, expected glTF 2.0"));
}

TEST_F(GltfReadTest, AFileThatWantsAnotherFromOutsideItsFolderIsRefused) {
  std::filesystem::create_directories(folder_ / "home/sub");
  std::ofstream(folder_ / "secret.bin") << "secret";
  std::ofstream(folder_ / "home/in.bin") << "in";
  std::filesystem::create_symlink(folder_ / "secret.bin", folder_ / "home/link.bin");
  std::filesystem::create_symlink(folder_ / "home/in.bin", folder_ / "home/sub/good.bin");
  ASSERT_EQ(mkfifo((folder_ / "home/pipe.bin").c_str(), 0600), 0);
  const auto with = [this](const char* list, const std::string& uri) {
    json avatar = Avatar();
    avatar[list] = json::array({{{"uri", uri}, {"byteLength", 2}}});
    return Read(avatar.dump(), "home/avatar.gltf");
  };
  for (const auto& [uri, why] : std::vector<std::pair<std::string, std::string>>{
           {"../secret.bin", "leads out of the avatar's folder"},
           {"sub/../../secret.bin", "leads out of the avatar's folder"},
           {"%2e%2E/secret.bin", "leads out of the avatar's folder"},
           {"..%2fsecret.bin", "leads out of the avatar's folder"},
           {"..\\secret.bin", "leads out of the avatar's folder"},
           {"/etc/passwd", "is an absolute path"},
           {"%2Fetc/passwd", "is an absolute path"},
           {"file:///etc/passwd", "is not a file beside the avatar"},
           {"http://a.example/b.bin", "is not a file beside the avatar"},
           {"in.bin%00.png", "is not a file beside the avatar"},
           {"link.bin", "is a link that leads out of the avatar's folder"},
           {"pipe.bin", "is not an ordinary file"},
           {"sub", "is not an ordinary file"}}) {
    for (const char* const list : {"buffers", "images"}) {
      const auto read = with(list, uri);
      ASSERT_FALSE(read.ok()) << list << " " << uri;
      EXPECT_THAT(read.status().message(), HasSubstr("avatar.gltf: " + std::string(list) + "[0]"));
      EXPECT_THAT(read.status().message(), HasSubstr(why)) << uri;
    }
  }
  for (const std::string uri : {"in.bin", "./in.bin", "sub/good.bin", "gone.bin", "a%20b.bin",
                                "100%.bin", "data:application/octet-stream;base64,AAAA"}) {
    const auto read = with("buffers", uri);
    EXPECT_TRUE(read.ok()) << uri << ": " << read.status().message();
  }
}

// Opening a pipe would block the daemon until another process writes to it.
TEST_F(GltfReadTest, PipesDevicesAndFoldersAreRefusedAndNobodyIsWaitedFor) {
  for (const std::string name : {"pipe.glb", "pipe.bvh"}) {
    const std::string pipe = folder_ / name;
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    // Releases a reader that does block.
    std::atomic<bool> done = false;
    std::thread rescue([&] {
      while (!done) {
        const int fd = open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
        if (fd >= 0) close(fd);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
    const auto read = ReadAvatar(pipe, "auto", {});
    done = true;
    rescue.join();
    ASSERT_FALSE(read.ok());
    EXPECT_THAT(read.status().message(), HasSubstr(name + ": is a pipe, expected an avatar's"));
  }
  EXPECT_THAT(ReadAvatar("/dev/zero", "auto", {}).status().message(),
              HasSubstr("/dev/zero: is a device"));
  std::filesystem::create_directory(folder_ / "folder.bvh");
  EXPECT_THAT(ReadAvatar(folder_ / "folder.bvh", "auto", {}).status().message(),
              HasSubstr("folder.bvh: is a folder"));
}

TEST_F(GltfReadTest, DeeplyNestedJsonIsRefused) {
  for (const char* const key : {"nodes", "meshes"}) {
    std::string text = R"({"asset": {"version": "2.0"}, ")" + std::string(key) + "\": ";
    text += std::string(1'000'000, '[') + std::string(1'000'000, ']') + "}";
    EXPECT_THAT(Read(text).status().message(), HasSubstr("found JSON that cannot be read"));
  }
}

// A list of `count` equal entries.
std::string Many(const std::string& entry, int count) {
  std::string text = entry;
  for (int i = 1; i < count; ++i) text += "," + entry;
  return "[" + text + "]";
}

std::string Times(int count, const std::string& text) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

// A daemon reads avatars on the thread that feeds its watchdog. The time limits are the watchdog's,
// not performance goals: work proportional to the file takes a tenth of them. They are of processor
// time, since a busy machine may stop a test for as long as it likes.
class GltfWorkTest : public GltfReadTest {
 protected:
  // Most of a large avatar.
  const std::string kMeshes = R"(, "extras": ")" + std::string(24 << 20, 'x') + "\"";

  // Reads a glTF 2.0 file with these members. Expects a refusal in time for this reason, or, if
  // `why` is empty, success in time.
  void Expect(const std::string& members, const std::string& why) {
    const std::clock_t start = std::clock();
    const auto read = Read(R"({"asset": {"version": "2.0"}, )" + members + "}");
    EXPECT_LT(std::clock() - start, 5 * CLOCKS_PER_SEC) << why;
    EXPECT_EQ(read.ok(), why.empty()) << read.status().message();
    EXPECT_THAT(read.status().message(), HasSubstr(why));
  }
};

TEST_F(GltfWorkTest, TooManyEntriesAreRefusedByTheirNumber) {
  for (const std::string list : {"buffers", "images"}) {
    Expect("\"" + list + "\": " + Many("{}", 5'000),
           "avatar.gltf: found 5000 " + list + ", expected at most 4096");
  }
  // As many as a large file may have; in a small one they are refused before they are kept.
  Expect(R"("nodes": )" + Many("{}", 70'000) + kMeshes,
         "found 70000 nodes, expected at most 65536");
  Expect(R"("skins": )" + Many(R"({"joints": [0]})", 400'000) + kMeshes,
         "found more than 1048576 values in its nodes, skins, buffers, images and humanoid");
  for (const char* const list : {"nodes", "skins", "buffers", "images"}) {
    Expect("\"" + std::string(list) + "\": " + Many("{}", 300'000),
           "avatar.gltf: found more nodes, skins, buffers and images than a file of ");
  }
}

TEST_F(GltfWorkTest, ManySmallEntriesTakeWorkInProportion) {
  for (const std::string list : {"meshes", "animations", "skins"}) {
    json other = Avatar();
    if (list == "skins") other.erase("skins");
    other.erase("asset");
    const std::string members = other.dump();
    Expect("\"" + list + "\": " + Many(R"({"a": {}})", 100'000) + "," +
               members.substr(1, members.size() - 2) + kMeshes,
           "");
  }
  // No bone has a name, so all nodes are searched.
  Expect(R"("nodes": )" + Many(R"({"name": "x", "extras": {}})", 60'000) + kMeshes,
         "no bone named like hips");
}

TEST_F(GltfWorkTest, AChainOfNodesTakesWorkInProportion) {
  constexpr int kNodes = 60'000;
  std::string chain = R"({"name": "hips", "children": [1]})";
  for (int i = 1; i < kNodes; ++i) {
    chain += R"(,{"children": [)" + (i + 1 < kNodes ? std::to_string(i + 1) : "") + "]}";
  }
  Expect(R"("nodes": [)" + chain + "]" + kMeshes, "");
}

TEST_F(GltfWorkTest, APathOfManyFoldersIsRefused) {
  Expect(R"("buffers": [{"uri": ")" + Times(100, "./") + "a.bin\"}]",
         "lies more than 16 folders deep");
  Expect(R"("images": [{"uri": ")" + std::string(5000, 'a') + "\"}]",
         "has more than 1024 characters, expected a file in the avatar's own folder");
}

// A link through 39 others, each of which has 2,000 folders on its way.
TEST_F(GltfWorkTest, PathsThroughManyLinksAreFollowedForASecond) {
  constexpr int kLinks = 39;
  std::filesystem::create_directory(folder_ / "end");
  for (int i = 0; i < kLinks; ++i) {
    const std::string next = i + 1 < kLinks ? "link" + std::to_string(i + 1) : "end";
    std::filesystem::create_symlink(Times(2000, "./") + next,
                                    folder_ / ("link" + std::to_string(i)));
  }
  const std::string uri = R"({"uri": "link0)" + Times(13, "/.") + "/x.bin\"}";
  Expect(
      "\"buffers\": " + Many(uri, 4096) + ", \"images\": " + Many(uri, 4096),
      "avatar.gltf: took longer than 1 s, expected buffers and images at the end of short paths");
}

// The header of a .glb states the length of its JSON; the file itself may be smaller.
TEST_F(GltfWorkTest, MoreJsonThanAnAvatarHasIsRefused) {
  std::string binary = "glTF";
  for (const std::uint32_t word : {2U, 20U, (64U << 20) + 1, 0x4E4F534AU}) {
    binary.append(reinterpret_cast<const char*>(&word), sizeof word);
  }
  EXPECT_THAT(Read(binary, "large.glb").status().message(),
              HasSubstr("large.glb: found more than 64 MiB of JSON"));
}

TEST_F(GltfReadTest, DamagedFilesAreReadOrRefused) {
  Random random(3);
  const std::string good = Vrm(true).dump();
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string bad = good;
    for (int k = 0; k < 3; ++k) {
      const auto at =
          static_cast<std::size_t>(random.Between(0, 1) * 0.999F * static_cast<float>(bad.size()));
      bad[at] = static_cast<char>(random.Between(32, 126));
    }
    const auto read = Read(bad);
    if (!read.ok()) {
      ++refused;
      EXPECT_THAT(read.status().message(), HasSubstr("avatar.gltf: "));
      continue;
    }
    (void)rig::BindStanding(read.value().skeleton, read.value().source_joint, read.value().stance,
                            read.value().t_pose);
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace styled::clip
