#include "model/clip/glb_write.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "model/rig/binding.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/body/random_pose.h"

namespace styled::clip {
namespace {

using body::Random;
using nlohmann::json;
using rig::Quat;
using rig::Vec3;
using testing::HasSubstr;

// Two chains in centimetres, Z up, with rest rotations, that drift.
Motion Wandering(int frames = 20) {
  Random random(5);
  Motion motion;
  motion.name = "walk";
  motion.skeleton.names = {"hips", "spine", "head", "leg", "foot"};
  motion.skeleton.parents = {-1, 0, 1, 0, 3};
  motion.skeleton.offsets = {Vec3(3, 4, 90), Vec3(0, 1, 30), Vec3(0, 0, 25), Vec3(9, 0, -5),
                             Vec3(0, 2, -80)};
  for (int joint = 0; joint < 5; ++joint) motion.rest.push_back(random.Turn(1));
  motion.metres_per_unit = 0.01F;
  motion.canonical_from_source = Quat(Eigen::AngleAxisf(-1.5707963F, Vec3::UnitX()));
  rig::RigPose pose(motion.skeleton);
  for (int frame = 0; frame < frames; ++frame) {
    for (Quat& q : pose.rotations) q = (q * random.Turn(0.2F)).normalized();
    pose.translations[0] += random.Vector(3);
    motion.frames.push_back(pose);
    motion.times_s.push_back(7 + frame / 30.0 + (frame % 3) * 0.002);
  }
  return motion;
}

// A .glb parsed by the specification alone.
struct Glb {
  json document;
  std::vector<std::byte> binary;

  explicit Glb(const std::vector<std::byte>& bytes) {
    const auto u32 = [&bytes](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, 4);
      return value;
    };
    EXPECT_EQ(u32(0), 0x46546C67U);
    EXPECT_EQ(u32(4), 2U);
    EXPECT_EQ(u32(8), bytes.size());
    const std::size_t length = u32(12);
    EXPECT_EQ(u32(16), 0x4E4F534AU);
    EXPECT_EQ(length % 4, 0U);
    const char* const text = reinterpret_cast<const char*>(bytes.data() + 20);
    document = json::parse(text, text + length);
    EXPECT_EQ(u32(20 + length), bytes.size() - 28 - length);
    EXPECT_EQ(u32(24 + length), 0x004E4942U);
    binary.assign(bytes.begin() + 28 + static_cast<std::ptrdiff_t>(length), bytes.end());
    EXPECT_EQ(document["buffers"].size(), 1U);
    EXPECT_EQ(document["buffers"][0]["byteLength"], binary.size());
  }

  template <typename T = float>
  std::vector<T> Values(int accessor_index) const {
    const json& accessor = document["accessors"][accessor_index];
    const json& view = document["bufferViews"][accessor["bufferView"].get<int>()];
    const std::size_t offset = view["byteOffset"], size = view["byteLength"];
    EXPECT_LE(offset + size, binary.size());
    EXPECT_EQ(offset % 4, 0U);
    std::vector<T> values(size / sizeof(T));
    std::memcpy(values.data(), binary.data() + offset, size);
    return values;
  }

  // World matrices of the nodes at key `key` of the animation; key < 0: of the static nodes.
  std::vector<Eigen::Matrix4f> World(int key) const {
    const json& nodes = document["nodes"];
    std::vector<Eigen::Affine3f> local;
    for (const json& node : nodes) {
      Vec3 translation = Vec3::Zero();
      Quat rotation = Quat::Identity();
      if (node.contains("translation")) {
        for (int k = 0; k < 3; ++k) translation[k] = node["translation"][k];
      }
      if (node.contains("rotation")) {
        for (int k = 0; k < 4; ++k) rotation.coeffs()[k] = node["rotation"][k];
      }
      local.push_back(Eigen::Translation3f(translation) * rotation);
    }
    const json& animation = document["animations"][0];
    for (const json& channel : animation["channels"]) {
      if (key < 0) break;
      const json& sampler = animation["samplers"][channel["sampler"].get<int>()];
      const auto values = Values(sampler["output"]);
      const int node = channel["target"]["node"];
      if (channel["target"]["path"] == "rotation") {
        const Quat q(Eigen::Map<const Eigen::Vector4f>(values.data() + 4 * key));
        local[node].linear() = q.toRotationMatrix();
      } else {
        local[node].translation() = Eigen::Map<const Vec3>(values.data() + 3 * key);
      }
    }
    std::vector<Eigen::Matrix4f> world(nodes.size(), Eigen::Matrix4f::Identity());
    const auto visit = [&](const auto& self, int node, const Eigen::Affine3f& parent) -> void {
      const Eigen::Affine3f here = parent * local[node];
      world[node] = here.matrix();
      if (!nodes[node].contains("children")) return;
      for (const json& child : nodes[node]["children"]) self(self, child, here);
    };
    for (const json& root : document["scenes"][0]["nodes"]) {
      visit(visit, root, Eigen::Affine3f::Identity());
    }
    return world;
  }
};

Glb Format(const Motion& motion) {
  const auto bytes = FormatGlb(motion);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  return Glb(bytes.value());
}

TEST(WriteGlb, RefusesWhatIsNoMotionOneByOne) {
  const auto error = [](const std::function<void(Motion&)>& change) {
    Motion motion = Wandering(3);
    change(motion);
    return FormatGlb(motion).status().message();
  };
  EXPECT_EQ(error([](Motion&) {}), "");
  EXPECT_THAT(error([](Motion& m) { m.frames.clear(); }), HasSubstr("without joints or frames"));
  EXPECT_THAT(error([](Motion& m) { m.skeleton = {}; }), HasSubstr("without joints or frames"));
  EXPECT_THAT(error([](Motion& m) { m.skeleton.parents.pop_back(); }), HasSubstr("sizes"));
  EXPECT_THAT(error([](Motion& m) { m.rest.pop_back(); }), HasSubstr("sizes"));
  EXPECT_THAT(error([](Motion& m) { m.times_s.pop_back(); }), HasSubstr("sizes"));
  for (const float unit : {0.0F, -1.0F, std::nanf(""), INFINITY}) {
    EXPECT_THAT(error([&](Motion& m) { m.metres_per_unit = unit; }), HasSubstr("unit"));
  }
  EXPECT_THAT(error([](Motion& m) { m.skeleton.parents[1] = 2; }), HasSubstr("joint 1"));
  EXPECT_THAT(error([](Motion& m) { m.skeleton.parents[0] = 0; }), HasSubstr("joint 0"));
  EXPECT_THAT(error([](Motion& m) { m.skeleton.offsets[2].x() = NAN; }), HasSubstr("joint 2"));
  EXPECT_THAT(error([](Motion& m) { m.frames[1].rotations.pop_back(); }), HasSubstr("frame 1"));
  EXPECT_THAT(error([](Motion& m) { m.frames[2].rotations[3].x() = NAN; }),
              HasSubstr("frame 2, joint 3"));
  EXPECT_THAT(error([](Motion& m) { m.frames[2].rotations[3].coeffs().setZero(); }),
              HasSubstr("frame 2, joint 3"));
  EXPECT_THAT(error([](Motion& m) { m.frames[0].translations[0].y() = INFINITY; }),
              HasSubstr("frame 0, joint 0"));
  EXPECT_THAT(error([](Motion& m) { m.times_s[2] = m.times_s[1]; }), HasSubstr("frame 2"));
  EXPECT_THAT(error([](Motion& m) { m.times_s[1] = NAN; }), HasSubstr("frame 1"));
}

TEST(WriteGlb, NamesTheFileThatCannotBeWritten) {
  EXPECT_THAT(WriteGlb(Wandering(2), "/nonexistent/x.glb").message(),
              HasSubstr("/nonexistent/x.glb: cannot be opened for writing"));
  Motion none = Wandering(2);
  none.frames.clear();
  EXPECT_THAT(WriteGlb(none, "/tmp/x.glb").message(), HasSubstr("/tmp/x.glb: found a motion"));
}

TEST(WriteGlb, SaysWhoMadeItAndNamesTheJoints) {
  const Glb glb = Format(Wandering());
  EXPECT_EQ(glb.document["asset"]["version"], "2.0");
  EXPECT_EQ(glb.document["asset"]["generator"], "styled");
  EXPECT_EQ(glb.document["nodes"][2]["name"], "head");
  EXPECT_EQ(glb.document["nodes"][0]["children"], json({1, 3}));
  EXPECT_EQ(glb.document["animations"][0]["name"], "walk");
}

TEST(WriteGlb, TimesAreTheFramesOwnFromZero) {
  const Motion motion = Wandering();
  const Glb glb = Format(motion);
  const json& input =
      glb.document["accessors"][glb.document["animations"][0]["samplers"][0]["input"].get<int>()];
  const auto times = glb.Values(glb.document["animations"][0]["samplers"][0]["input"]);
  ASSERT_EQ(times.size(), motion.times_s.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(times[i], motion.times_s[i] - 7, 1e-6);
  }
  EXPECT_EQ(input["min"][0], 0.0F);
  EXPECT_EQ(input["max"][0], times.back());
}

TEST(WriteGlb, WithoutTimesTheFramesAreAtTheClipsRate) {
  Motion motion = Wandering(4);
  motion.times_s.clear();
  motion.rate_hz = 50;
  const Glb glb = Format(motion);
  EXPECT_EQ(glb.Values(glb.document["animations"][0]["samplers"][0]["input"]),
            (std::vector<float>{0, 0.02F, 0.04F, 0.06F}));
  for (const double rate_hz : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    motion.rate_hz = rate_hz;
    EXPECT_THAT(FormatGlb(motion).status().message(), HasSubstr("rate"));
  }
}

TEST(WriteGlb, FramesThatFloatSecondsCannotTellApartAreLeftOut) {
  Motion motion = Wandering(4);
  motion.times_s = {0, 36000, 36000.0001, 36001};
  const Glb glb = Format(motion);
  EXPECT_EQ(glb.Values(glb.document["animations"][0]["samplers"][0]["input"]),
            (std::vector<float>{0, 36000, 36001}));
}

// Forward kinematics of the file against the project's own, in metres and glTF's axes.
TEST(WriteGlb, EveryJointIsWhereTheMotionHasIt) {
  const Motion motion = Wandering();
  const Glb glb = Format(motion);
  std::vector<Vec3> positions;
  std::vector<Quat> rotations;
  for (std::size_t frame = 0; frame < motion.frames.size(); ++frame) {
    const auto world = glb.World(static_cast<int>(frame));
    rig::WorldTransforms(motion.skeleton, motion.frames[frame], positions, rotations);
    for (std::size_t j = 0; j < positions.size(); ++j) {
      const Vec3 expected_m = motion.canonical_from_source * (positions[j] * 0.01F);
      EXPECT_LT((Vec3(world[j].topRightCorner<3, 1>()) - expected_m).norm(), 1e-5F);
      const Eigen::Matrix3f turn = (motion.canonical_from_source * rotations[j]).toRotationMatrix();
      EXPECT_LT((world[j].topLeftCorner<3, 3>() - turn).norm(), 1e-4F);
    }
  }
}

TEST(WriteGlb, WithoutAnAnimationTheNodesStandInTheRestPose) {
  const Motion motion = Wandering();
  const auto world = Format(motion).World(-1);
  for (std::size_t j = 0; j < motion.rest.size(); ++j) {
    const Eigen::Matrix3f turn = (motion.canonical_from_source * motion.rest[j]).toRotationMatrix();
    EXPECT_LT((world[j].topLeftCorner<3, 3>() - turn).norm(), 1e-5F);
  }
}

// Skinning by the specification: at rest the mesh is unchanged; in a frame the first corner of
// every bone, its head, is at its joint.
TEST(WriteGlb, BonesMoveWithTheirJoints) {
  const Motion motion = Wandering();
  const Glb glb = Format(motion);
  const json& attributes = glb.document["meshes"][0]["primitives"][0]["attributes"];
  const auto vertices = glb.Values(attributes["POSITION"]);
  const auto weights = glb.Values(attributes["WEIGHTS_0"]);
  const auto joints = glb.Values<std::uint16_t>(attributes["JOINTS_0"]);
  const auto inverse = glb.Values(glb.document["skins"][0]["inverseBindMatrices"]);
  ASSERT_EQ(vertices.size() % (3 * 24), 0U) << "24 corners a bone";
  EXPECT_EQ(vertices.size() / 72, 4U + 2U) << "a bone per child, and one per end";
  for (const int key : {-1, 0, 11}) {
    const auto world = glb.World(key);
    for (std::size_t v = 0; v < vertices.size() / 3; v += 24) {
      ASSERT_EQ(weights[4 * v], 1.0F);
      const auto joint = joints[4 * v];
      const Eigen::Map<const Eigen::Matrix4f> bind(inverse.data() + 16 * joint);
      const Eigen::Vector4f corner(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2], 1);
      const Eigen::Vector4f moved = world[joint] * bind * corner;
      EXPECT_LT((moved.head<3>() - world[joint].topRightCorner<3, 1>()).norm(), 1e-5F);
      if (key < 0) {
        const Vec3 modelled = motion.canonical_from_source * Vec3(corner.head<3>());
        EXPECT_LT((moved.head<3>() - modelled).norm(), 1e-5F);
      }
    }
  }
}

TEST(WriteGlb, NormalsPointOutwards) {
  const Glb glb = Format(Wandering());
  const json& attributes = glb.document["meshes"][0]["primitives"][0]["attributes"];
  const auto vertices = glb.Values(attributes["POSITION"]);
  const auto normals = glb.Values(attributes["NORMAL"]);
  const auto at = [](const std::vector<float>& values, std::size_t v) {
    return Vec3(values[3 * v], values[3 * v + 1], values[3 * v + 2]);
  };
  for (std::size_t bone = 0; bone < vertices.size() / 3; bone += 24) {
    Vec3 middle = Vec3::Zero();
    for (std::size_t v = bone; v < bone + 24; ++v) middle += at(vertices, v) / 24;
    for (std::size_t v = bone; v < bone + 24; v += 3) {
      const Vec3 face = (at(vertices, v) + at(vertices, v + 1) + at(vertices, v + 2)) / 3;
      EXPECT_GT(at(normals, v).dot(face - middle), 0);
      const Vec3 winding =
          (at(vertices, v + 1) - at(vertices, v)).cross(at(vertices, v + 2) - at(vertices, v));
      EXPECT_GT(winding.dot(at(normals, v)), 0);
    }
  }
}

TEST(WriteGlb, AJointThatMovesGetsATranslationAndTheOthersDoNot) {
  Motion motion = Wandering();
  const auto translated = [](const Motion& m) {
    std::vector<int> nodes;
    const Glb glb = Format(m);
    for (const json& channel : glb.document["animations"][0]["channels"]) {
      if (channel["target"]["path"] == "translation") nodes.push_back(channel["target"]["node"]);
    }
    return nodes;
  };
  EXPECT_THAT(translated(motion), testing::ElementsAre(0));
  motion.frames[4].translations[2].z() += 1;
  EXPECT_THAT(translated(motion), testing::ElementsAre(0, 2));
}

TEST(WriteGlb, RotationsGoTheShorterWay) {
  Motion motion = Wandering();
  for (std::size_t i = 1; i < motion.frames.size(); i += 2) {
    motion.frames[i].rotations[1].coeffs() *= -1;
  }
  const Glb glb = Format(motion);
  const json& animation = glb.document["animations"][0];
  for (const json& channel : animation["channels"]) {
    if (channel["target"]["path"] != "rotation") continue;
    const auto values = glb.Values(animation["samplers"][channel["sampler"].get<int>()]["output"]);
    for (std::size_t i = 4; i < values.size(); i += 4) {
      float dot = 0;
      for (std::size_t k = 0; k < 4; ++k) dot += values[i + k] * values[i + k - 4];
      EXPECT_GT(dot, 0);
    }
  }
}

TEST(WriteGlb, ASingleJointWithANameOfNoEncodingIsShown) {
  Motion motion;
  motion.skeleton = {{"h\xFC\x66te"}, {-1}, {Vec3(0, 1, 0)}};
  motion.frames.emplace_back(motion.skeleton);
  motion.times_s = {0};
  const Glb glb = Format(motion);
  EXPECT_EQ(glb.document["nodes"][0]["name"], "h\xEF\xBF\xBD\x66te");
  EXPECT_GT(glb.document["meshes"][0]["primitives"].size(), 0U);
  EXPECT_EQ(glb.document["scenes"][0]["nodes"], json({0, 1})) << "no node for the axes";
}

TEST(WriteGlb, WritesTheFile) {
  const support::TemporaryFolder folder;
  const std::string file = folder / "x.glb";
  ASSERT_TRUE(WriteGlb(Wandering(), file).ok());
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto expected = FormatGlb(Wandering()).value();
  ASSERT_EQ(text.size(), expected.size());
  EXPECT_EQ(std::memcmp(text.data(), expected.data(), expected.size()), 0);
}

}  // namespace
}  // namespace styled::clip
