#include "model/clip/gltf_clip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "model/clip/glb_write.h"
#include "model/clip/gltf_meshopt.h"
#include "tests/unit/body/random_pose.h"

namespace styled::clip {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// The canonical humanoid in gentle poses, in metres.
Motion Humanoid(int frames = 31, double rate_hz = 30) {
  body::Random random(3);
  Motion motion;
  motion.rate_hz = rate_hz;
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    const body::JointRow& row = body::kHumanoid[joint];
    motion.skeleton.names.emplace_back(row.name);
    motion.skeleton.parents.push_back(row.parent);
    motion.skeleton.offsets.push_back(body::Offset(joint));
  }
  rig::RigPose pose(motion.skeleton);
  for (int frame = 0; frame < frames; ++frame) {
    for (rig::Quat& q : pose.rotations) q = (q * random.Turn(0.05F)).normalized();
    pose.translations[0] += random.Vector(0.02F);
    motion.frames.push_back(pose);
  }
  return motion;
}

std::string Text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
std::string Glb(const Motion& motion) {
  auto bytes = FormatGlb(motion);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  return Text(bytes.value());
}

// A file taken apart, changed, and put together again.
struct Parts {
  json document;
  std::string data;

  explicit Parts(const std::string& glb) {
    const std::size_t text = Word(glb, 12);
    document = json::parse(glb.substr(20, text));
    data = glb.substr(20 + text + 8, Word(glb, 20 + text));
  }
  static std::uint32_t Word(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  }
  std::string Join() const {
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto word = [](std::size_t value) {
      const auto word = static_cast<std::uint32_t>(value);
      return std::string(reinterpret_cast<const char*>(&word), 4);
    };
    return "glTF" + word(2) + word(28 + text.size() + data.size()) + word(text.size()) + "JSON" +
           text + word(data.size()) + std::string("BIN\0", 4) + data;
  }
  json& sampler(std::size_t i) { return document["animations"][0]["samplers"][i]; }
  json& input(std::size_t i) {
    return document["accessors"][sampler(i)["input"].get<std::size_t>()];
  }
  json& output(std::size_t i) {
    return document["accessors"][sampler(i)["output"].get<std::size_t>()];
  }
  // Where the accessor's data lie.
  char* At(const json& accessor) {
    const json& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    return data.data() + view.value("byteOffset", 0) + accessor.value("byteOffset", 0);
  }
};

void ExpectRefused(const std::string& bytes, const std::string& reason) {
  const auto clip = ParseGltfClip(bytes, "walk.glb");
  ASSERT_FALSE(clip.ok()) << reason;
  EXPECT_THAT(clip.status().message(), HasSubstr(reason));
  EXPECT_THAT(clip.status().message(), testing::StartsWith("walk.glb: "));
}

TEST(GltfClip, AFileWithoutAClipIsRefusedWithTheReason) {
  const std::string glb = Glb(Humanoid());
  ExpectRefused("", "expected glTF binary");
  ExpectRefused("HIERARCHY", "expected glTF binary");
  for (std::size_t size = 4; size + 4 < glb.size(); size += 97) {
    const auto clip = ParseGltfClip(glb.substr(0, size), "walk.glb");
    EXPECT_FALSE(clip.ok()) << size;
  }
  std::string one = glb;
  one[4] = 1;
  ExpectRefused(one, "is glTF 1 in binary form, expected glTF 2.0");
  const auto with = [&glb](const auto& change, const std::string& reason) {
    Parts parts(glb);
    change(parts);
    ExpectRefused(parts.Join(), reason);
  };
  with([](Parts& p) { p.document.erase("animations"); }, "found no animation, expected one of");
  with([](Parts& p) { p.document["animations"] = json::array(); }, "found no animation");
  with([](Parts& p) { p.document["animations"][0]["channels"] = json::array(); },
       "found no animation that turns the humanoid's bones");
  with(
      [](Parts& p) {
        for (auto& node : p.document["nodes"]) {
          node["name"] = "thing";
          node.erase("children");
        }
      },
      "found no bone named like hips, expected a humanoid");
  with(
      [](Parts& p) {
        p.output(1)["sparse"] = {{"count", 1}};
      },
      "found a sparse one, expected a dense one");
  with([](Parts& p) { p.document["buffers"][0]["uri"] = "walk.bin"; },
       "found its data in another file, or in the text");
  with(
      [](Parts& p) {
        for (json& view : p.document["bufferViews"]) view["buffer"] = 1;
      },
      "in another file");
  with([](Parts& p) { p.data.resize(8); }, "expected its data within the file");
  with([](Parts& p) { p.output(0)["count"] = 2'000'000'000; }, "expected its data within the file");
  with([](Parts& p) { p.output(0)["count"] = 0; }, "expected a count of 1 or more");
  with([](Parts& p) { p.output(0)["byteOffset"] = 2'000'000'000; }, "within the file");
  with([](Parts& p) { p.output(0)["bufferView"] = 99; }, "expected a bufferView");
  with([](Parts& p) { p.output(0)["componentType"] = 5125; }, "expected floats, or normalized");
  with([](Parts& p) { p.output(0)["componentType"] = 5122; }, "expected floats, or normalized");
  with([](Parts& p) { p.output(0)["type"] = "MAT4"; }, "expected type VEC");
  with([](Parts& p) { p.output(0)["count"] = 7; }, "found 31 times for 7 values");
  with([](Parts& p) { p.sampler(0)["interpolation"] = "CUBICSPLINE"; }, "found 31 times for 10");
  with([](Parts& p) { p.sampler(0).erase("input"); }, "found a sampler without input or output");
  with([](Parts& p) { p.sampler(0)["input"] = 999; }, "accessor 999: there is none");
  with([](Parts& p) { p.document["animations"][0]["channels"][0]["sampler"] = 999; },
       "found a channel whose node or sampler does not exist");
  with([](Parts& p) { p.document["animations"][0]["channels"][0]["target"]["node"] = 999; },
       "found a channel whose node or sampler does not exist");
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity(), 1e9F}) {
    with([bad](Parts& p) { std::memcpy(p.At(p.output(0)) + 8, &bad, 4); },
         "expected finite numbers below 1000000");
    with([bad](Parts& p) { std::memcpy(p.At(p.input(0)) + 8, &bad, 4); }, "expected finite");
  }
  with(
      [](Parts& p) {
        for (std::size_t at = 0; at < 4; ++at) p.document["nodes"][at]["scale"] = {9e8, 9e8, 9e8};
        for (std::size_t i = 0; i < 4; ++i) {
          json& channel = p.document["animations"][0]["channels"][i];
          if (channel["target"]["path"] != "translation") continue;
          channel["target"]["node"] = 4;
          for (int key = 0; key < 31; ++key) {
            const float far = 9e5F;
            std::memcpy(p.At(p.output(i)) + 12 * key, &far, 4);
          }
        }
      },
      "more than a number holds");
  with([](Parts& p) { std::memset(p.At(p.input(0)) + 8, 0, 4); }, "found times that do not rise");
  with(
      [](Parts& p) {
        const float late = 86401;
        std::memcpy(p.At(p.input(0)) + 30 * 4, &late, 4);
      },
      "found a key at 86401 s, expected at most 86400");
  // A day of 31 keys.
  with(
      [](Parts& p) {
        const float late = 86400;
        std::memcpy(p.At(p.input(0)) + 30 * 4, &late, 4);
      },
      "s of hardly a key, expected a motion");
}

TEST(GltfClip, OfALongMotionTheBeginIsReadIfThatIsTheLimit) {
  Parts parts(Glb(Humanoid()));
  const float late = 75;
  std::memcpy(parts.At(parts.input(0)) + 30 * 4, &late, 4);
  const auto whole = ParseGltfClip(parts.Join(), "walk.glb");
  ASSERT_TRUE(whole.ok()) << whole.status().message();
  EXPECT_EQ(whole.value().clip.remark, "");
  const auto cut = ParseGltfClip(parts.Join(), "walk.glb", {.longest_s = 60, .work = {}});
  ASSERT_TRUE(cut.ok()) << cut.status().message();
  EXPECT_EQ(cut.value().clip.remark, "only its first 60 s are read");
  const auto length_s = [](const Clip& clip) {
    return static_cast<double>(clip.frames.size() - 1) / clip.rate_hz;
  };
  EXPECT_NEAR(length_s(whole.value().clip), 75, 0.1);
  EXPECT_NEAR(length_s(cut.value().clip), 60, 1e-6);
}

// The writer's own files.
TEST(GltfClip, AMotionComesBackAsItWas) {
  const Motion motion = Humanoid();
  const auto clip = ParseGltfClip(Glb(motion), "walk.glb");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_EQ(clip.value().clip.rate_hz, 30);
  ASSERT_EQ(clip.value().clip.frames.size(), motion.frames.size());
  const auto bound = BindGltf(clip.value());
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  const auto poses = ToCanonical(clip.value().clip, bound.value());
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      EXPECT_LT(poses[frame].rotations[j].angularDistance(motion.frames[frame].rotations[j]), 2e-3F)
          << frame << " " << j;
    }
    EXPECT_LT((poses[frame].hips_position_m - motion.frames[frame].translations[0]).norm(), 2e-3F);
  }
  EXPECT_TRUE(BindGltf(clip.value(), "canonical").ok());
  EXPECT_FALSE(BindGltf(clip.value(), "octopus").ok());
}

// The motion as a VRM Animation, with bones by its table, and names that say nothing.
Parts Vrma(const Motion& motion) {
  Parts parts(Glb(motion));
  json bones;
  json& nodes = parts.document["nodes"];
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].contains("name")) continue;
    const auto name = nodes[i]["name"].get<std::string>();
    for (const auto& row : body::kHumanoid) {
      if (row.name == name) bones[name] = {{"node", i}};
    }
    nodes[i]["name"] = "thing";
  }
  parts.document["extensions"]["VRMC_vrm_animation"] = {{"specVersion", "1.0"},
                                                        {"humanoid", {{"humanBones", bones}}}};
  return parts;
}

// The nodes stand in the T-pose.
TEST(GltfClip, AVrmaIsReadByItsTable) {
  const Motion motion = Humanoid();
  const auto clip = ParseGltfClip(Vrma(motion).Join(), "walk.vrma");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_TRUE(clip.value().skeleton.t_pose);
  EXPECT_EQ(clip.value().clip.remark, "");
  const auto bound = BindGltf(clip.value());
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  const auto poses = ToCanonical(clip.value().clip, bound.value());
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    EXPECT_LT(poses[9].rotations[j].angularDistance(motion.frames[9].rotations[j]), 1e-3F) << j;
  }
}

// Nodes that stand with their arms down, in spite of the format's definition.
TEST(GltfClip, AVrmaOutOfTPoseIsBoundAsItStandsWithARemark) {
  const Motion motion = Humanoid();
  using Turns = std::vector<std::pair<body::Joint, float>>;  // about Z, radians
  const auto standing = [&](const Turns& turns) {
    Parts parts = Vrma(motion);
    for (const auto& [joint, angle_rad] : turns) {
      const rig::Quat turn(Eigen::AngleAxisf(angle_rad, rig::Vec3::UnitZ()));
      parts.document["nodes"][static_cast<std::size_t>(joint)]["rotation"] = {turn.x(), turn.y(),
                                                                              turn.z(), turn.w()};
    }
    return ParseGltfClip(parts.Join(), "walk.vrma");
  };
  for (const float angle_rad : {0.8F, 1.4F}) {
    const auto clip =
        standing({{body::kLeftUpperArm, -angle_rad}, {body::kRightUpperArm, angle_rad}});
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    EXPECT_THAT(clip.value().clip.remark, HasSubstr("stand in no T-pose"));
    const auto bound = BindGltf(clip.value());
    ASSERT_TRUE(bound.ok()) << bound.status().message();
    const auto poses = ToCanonical(clip.value().clip, bound.value());
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      EXPECT_LT(poses[9].rotations[j].angularDistance(motion.frames[9].rotations[j]), 2e-2F) << j;
    }
  }
  // A pose that does not stand is refused as what it should be.
  const auto lying = standing({{body::kLeftUpperLeg, 1.5F}});
  ASSERT_TRUE(lying.ok()) << lying.status().message();
  EXPECT_EQ(lying.value().clip.remark, "");
  EXPECT_THAT(BindGltf(lying.value()).status().message(), HasSubstr("a T-pose"));
}

// Motion of the nodes above the hips moves the hips; a node's scale counts.
TEST(GltfClip, NodesAboveTheHipsMoveThem) {
  Parts parts(Glb(Humanoid()));
  json& nodes = parts.document["nodes"];
  std::size_t hips = 0;
  while (nodes[hips].value("name", "") != "hips") ++hips;
  nodes.push_back({{"name", "above"},
                   {"children", {hips}},
                   {"scale", {2, 2, 2}},
                   {"translation", {0, 0, 1}},
                   {"rotation", {0, 1, 0, 0}}});
  const auto clip = ParseGltfClip(parts.Join(), "walk.glb");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  const auto plain = ParseGltfClip(Glb(Humanoid()), "walk.glb");
  const auto& moved = clip.value().clip.frames[5].translations[0];
  const auto& was = plain.value().clip.frames[5].translations[0];
  EXPECT_NEAR(moved.x(), -2 * was.x(), 1e-5);
  EXPECT_NEAR(moved.y(), 2 * was.y(), 1e-5);
  EXPECT_NEAR(moved.z(), 1 - 2 * was.z(), 1e-5);
}

TEST(GltfClip, StepsAreHeldAndTimesMayBeginLate) {
  Parts parts(Glb(Humanoid(3, 10)));
  for (std::size_t i = 0; i < parts.document["animations"][0]["samplers"].size(); ++i) {
    parts.sampler(i)["interpolation"] = "STEP";
  }
  for (int key = 0; key < 3; ++key) {
    const float time = 100.0F + static_cast<float>(key) / 10;
    std::memcpy(parts.At(parts.input(0)) + 4 * key, &time, 4);
  }
  const auto clip = ParseGltfClip(parts.Join(), "walk.glb");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_EQ(clip.value().clip.frames.size(), 3U);
}

// Rows as meshoptimizer packs them.
std::string Packed(const void* rows, std::size_t count, std::size_t stride) {
  std::string packed(meshopt_encodeVertexBufferBound(count, stride), '\0');
  packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
                                           packed.size(), rows, count, stride));
  return packed;
}
// The extension's object for `count` rows in the binary chunk.
json Meshopt(std::size_t offset, std::size_t bytes, std::size_t count, std::size_t stride,
             const std::string& filter) {
  json packed{{"buffer", 0},          {"byteOffset", offset}, {"byteLength", bytes},
              {"byteStride", stride}, {"count", count},       {"mode", "ATTRIBUTES"}};
  if (filter != "NONE") packed["filter"] = filter;
  return packed;
}

// The file with each accessor's data packed, as gltfpack does; with filters, rotations have 16 bits
// and numbers of 3 have 24.
Parts Pack(Parts parts, bool filters) {
  std::string data;
  for (json& accessor : parts.document["accessors"]) {
    if (accessor["componentType"] != 5126 || accessor["type"] == "MAT4") continue;
    json& view = parts.document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const auto count = accessor["count"].get<std::size_t>();
    const std::size_t size = view["byteLength"].get<std::size_t>();
    std::vector<float> values(size / 4);
    std::memcpy(values.data(), parts.At(accessor), size);
    std::size_t stride = size / count;
    std::string filter = "NONE", rows(size, '\0');
    if (filters && accessor["type"] == "VEC4") {
      filter = "QUATERNION";
      stride = 8;
      meshopt_encodeFilterQuat(rows.data(), count, stride, 16, values.data());
      accessor["componentType"] = 5122;
      accessor["normalized"] = true;
    } else if (filters && accessor["type"] == "VEC3") {
      filter = "EXPONENTIAL";
#if MESHOPTIMIZER_VERSION >= 200  // Debian 13's; 12's shares the exponent without being asked
      meshopt_encodeFilterExp(rows.data(), count, stride, 24, values.data(),
                              meshopt_EncodeExpSharedVector);
#else
      meshopt_encodeFilterExp(rows.data(), count, stride, 24, values.data());
#endif
    } else {
      std::memcpy(rows.data(), values.data(), size);
    }
    const std::string packed = Packed(rows.data(), count, stride);
    view = {{"buffer", 1},
            {"byteLength", count * stride},
            {"extensions",
             {{gltf::kMeshopt, Meshopt(data.size(), packed.size(), count, stride, filter)}}}};
    data += packed;
  }
  parts.data = data;
  parts.document["buffers"] = {{{"byteLength", data.size()}}, {{"byteLength", 1 << 20}}};
  parts.document["extensionsRequired"] = {gltf::kMeshopt};
  return parts;
}

TEST(GltfClip, PackedDataAreUnpacked) {
  const Motion motion = Humanoid();
  const auto plain = ParseGltfClip(Glb(motion), "walk.glb");
  ASSERT_TRUE(plain.ok()) << plain.status().message();
  for (const bool filters : {false, true}) {
    const auto clip = ParseGltfClip(Pack(Parts(Glb(motion)), filters).Join(), "walk.glb");
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    ASSERT_EQ(clip.value().clip.frames.size(), plain.value().clip.frames.size());
    for (std::size_t frame = 0; frame < plain.value().clip.frames.size(); ++frame) {
      const auto &found = clip.value().clip.frames[frame], &was = plain.value().clip.frames[frame];
      for (std::size_t j = 0; j < was.rotations.size(); ++j) {
        EXPECT_LT(found.rotations[j].angularDistance(was.rotations[j]), filters ? 2e-4F : 1e-6F);
      }
      EXPECT_LT((found.translations[0] - was.translations[0]).norm(), filters ? 1e-6F : 1e-9F);
    }
  }
}

// No animation has directions; the filter is one of the extension all the same.
TEST(GltfClip, PackedDirectionsAreUnpacked) {
  const std::vector<float> directions{0.6F, 0, 0.8F, 1, 0, -1, 0, 1, -0.36F, 0.48F, -0.8F, 1};
  for (const std::size_t bytes : {1U, 2U}) {
    std::string rows(3 * 4 * bytes, '\0');
    meshopt_encodeFilterOct(rows.data(), 3, 4 * bytes, static_cast<int>(8 * bytes),
                            directions.data());
    const std::string packed = Packed(rows.data(), 3, 4 * bytes);
    const auto unpacked = gltf::UnpackView(Meshopt(0, packed.size(), 3, 4 * bytes, "OCTAHEDRAL"),
                                           packed, rows.size(), rows.size());
    ASSERT_TRUE(unpacked.ok()) << unpacked.status().message();
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const char* const at = unpacked.value().data() + i * bytes;
      std::int16_t wide = 0;
      std::memcpy(&wide, at, sizeof wide * bytes / 2);
      const float found = bytes == 1 ? static_cast<float>(static_cast<signed char>(*at)) / 127
                                     : static_cast<float>(wide) / 32767;
      EXPECT_NEAR(found, directions[i], bytes == 1 ? 0.02F : 1e-4F) << i;
    }
  }
}

TEST(GltfClip, BrokenPackedDataAreRefusedWithTheReason) {
  const Parts packed = Pack(Parts(Glb(Humanoid())), true);
  ASSERT_TRUE(ParseGltfClip(packed.Join(), "walk.glb").ok());
  const auto with = [&packed](const auto& change, const std::string& reason) {
    Parts parts = packed;
    json& view = parts.document["bufferViews"][parts.output(0)["bufferView"].get<std::size_t>()];
    change(view, view["extensions"][gltf::kMeshopt], parts);
    ExpectRefused(parts.Join(), reason);
  };
  for (const char* const mode : {"TRIANGLES", "INDICES", "", "\n"}) {
    with([mode](json&, json& p, Parts&) { p["mode"] = mode; },
         "EXT_meshopt_compression: found mode \"");
  }
  with([](json&, json& p, Parts&) { p.erase("mode"); }, "found mode \"\"");
  with([](json&, json& p, Parts&) { p["filter"] = "COLOR"; }, "found filter \"COLOR\", expected");
  for (const int stride : {0, -8, 3, 6, 12, 260, 1 << 30}) {
    with([stride](json&, json& p, Parts&) { p["byteStride"] = stride; }, "found a byteStride of");
  }
  with(
      [](json&, json& p, Parts&) {
        p["filter"] = "OCTAHEDRAL";
        p["byteStride"] = 12;
      },
      "found a byteStride of 12");
  for (const int count : {0, -1, 30, 32, 2'000'000'000}) {
    with([count](json&, json& p, Parts&) { p["count"] = count; }, "found ");
  }
  with([](json& view, json&, Parts&) { view["byteLength"] = 100; },
       "found 31 rows of 8 bytes, expected the view's 100 bytes");
  with([](json&, json& p, Parts&) { p["buffer"] = 1; }, "expected its data within");
  with([](json&, json& p, Parts&) { p["byteOffset"] = 1'000'000; }, "expected its data within");
  with([](json&, json& p, Parts&) { p["byteLength"] = 1'000'000; }, "expected its data within");
  for (const int bytes : {0, 1, 40}) {
    with([bytes](json&, json& p, Parts&) { p["byteLength"] = bytes; },
         "bytes that cannot be unpacked");
  }
  with(
      [](json&, json& p, Parts& parts) {
        parts.data[p["byteOffset"].get<std::size_t>()] = '\xA1';  // of a later version
      },
      "bytes that cannot be unpacked, expected those of 31 rows in version 0 of the format");
  // Damage is refused or read as other numbers.
  for (std::size_t at = 0; at < packed.data.size(); at += 7) {
    Parts parts = packed;
    parts.data[at] = static_cast<char>(parts.data[at] ^ 0x55);
    const auto clip = ParseGltfClip(parts.Join(), "walk.glb");
    if (!clip.ok()) EXPECT_THAT(clip.status().message(), HasSubstr("walk.glb: "));
  }
}

// An extension that a file cannot be read without is named where it cannot be.
TEST(GltfClip, UnknownExtensionsAreNamedByARefusal) {
  Parts parts(Glb(Humanoid()));
  parts.document["extensionsRequired"] = {"KHR_other", "KHR_draco_mesh_compression", 7};
  EXPECT_TRUE(ParseGltfClip(parts.Join(), "walk.glb").ok()) << "it may be about meshes";
  parts.document["buffers"][0]["uri"] = "walk.bin";
  ExpectRefused(parts.Join(),
                "in this file's binary chunk; it requires KHR_other, which is not read");
}

}  // namespace
}  // namespace styled::clip
