// Files of clients whose contents ask for more memory or time than their size justifies.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "model/body/humanoid.h"
#include "model/clip/avatar.h"
#include "model/clip/clip.h"
#include "model/clip/gltf_clip.h"
#include "model/rig/dialects.h"
#include "tests/support/count_new.h"
#include "tests/support/temporary_folder.h"

namespace styled::clip {
namespace {

using testing::HasSubstr;

constexpr std::size_t kFile = std::size_t{8} << 20;  // bytes that a request's file may have
constexpr std::size_t kMemoryPerByte = 8;
// The memory that even the smallest file may use: 4 MiB of frames, or of nodes, and the 60 s of
// canonical poses that an example ends as.
constexpr std::size_t kFixed = std::size_t{8} << 20;
constexpr auto kMostTime = std::chrono::seconds(5);  // on a machine that is busy with other tests

struct HostileFile {
  std::string name, bytes;
  std::string message;  // of the refusal; "": it is read
};

std::string Times(std::size_t count, const std::string& text) {
  std::string all;
  all.reserve(count * text.size());
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

// An example as the daemon reads it: "" or why it was refused.
std::string ReadExample(const std::string& bytes) {
  constexpr double kRate_hz = 60;
  const ReadLimits limits{.longest_s = 60, .work = {}};
  const auto resample = [](Clip&& clip, const Result<rig::Binding>& bound) -> std::string {
    if (!bound.ok()) return bound.status().message();
    const double rate_hz = clip.rate_hz;
    const auto poses = ToCanonical(std::move(clip), bound.value(), {}, "x");
    const auto resampled = ResamplePoses(poses.value(), rate_hz, kRate_hz, {}, "x");
    return resampled.ok() ? "" : resampled.status().message();
  };
  if (IsGltfBinary(bytes)) {
    auto clip = ParseGltfClip(bytes, "x", limits);
    if (!clip.ok()) return clip.status().message();
    const auto bound = BindGltf(clip.value());
    return resample(std::move(clip.value().clip), bound);
  }
  auto clip = ParseBvh(bytes, "x", limits);
  if (!clip.ok()) return clip.status().message();
  const auto bound = rig::BindDialect(clip.value().skeleton);
  return resample(std::move(clip.value()), bound);
}

void ExpectInProportion(const HostileFile& file) {
  SCOPED_TRACE(file.name + ", " + std::to_string(file.bytes.size()) + " bytes");
  const auto begin = std::chrono::steady_clock::now();
  std::string message;
  std::size_t peak_bytes = 0;
  {
    const support::CountNew count;
    message = ReadExample(file.bytes);
    peak_bytes = count.peak_bytes();
  }
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(peak_bytes, kMemoryPerByte * file.bytes.size() + kFixed);
  EXPECT_LT(took, kMostTime);
  EXPECT_LT(message.size(), 1000U);
  if (file.message.empty()) {
    EXPECT_EQ(message, "");
  } else {
    EXPECT_THAT(message, HasSubstr(file.message));
  }
}

// A BVH header of the canonical humanoid with `channels` in each joint.
std::string Humanoid(const std::string& channels, const std::string& more = "") {
  const std::function<std::string(int)> joint = [&](int c) {
    const body::JointRow& row = body::kHumanoid[static_cast<std::size_t>(c)];
    const auto offset = body::Offset(c);
    std::string text = (c == 0 ? "ROOT " : "JOINT ") + std::string(row.name) + "\n{\nOFFSET " +
                       std::to_string(offset.x()) + " " + std::to_string(offset.y()) + " " +
                       std::to_string(offset.z()) + "\n" + (c == 0 ? more : channels) + "\n";
    for (int child = c + 1; child < body::kJointCount; ++child) {
      if (body::kHumanoid[static_cast<std::size_t>(child)].parent == c) text += joint(child);
    }
    return text + "}\n";
  };
  return "HIERARCHY\n" + joint(0);
}

// `header` with as many equal rows as a file of `size` bytes has, each 1 ms.
std::string WithRows(const std::string& header, const std::string& row, std::size_t size) {
  const std::size_t rows = (size - header.size() - 100) / row.size();
  return header + "MOTION\nFrames: " + std::to_string(rows) + "\nFrame Time: 0.001\n" +
         Times(rows, row);
}

const std::string kTurns = "CHANNELS 3 Zrotation Xrotation Yrotation";

std::vector<HostileFile> BvhFiles() {
  // So many joints, of which the first have these channels.
  const auto flat = [](int joints, const std::string& channels, int with_channels = 1) {
    std::string text = "HIERARCHY\nROOT a\n{\n" + channels + "\n";
    for (int i = 1; i < joints; ++i) {
      text += "JOINT b\n{\n" + (i < with_channels ? channels : "") + "\n}\n";
    }
    return text + "}\n";
  };
  const std::string one = "CHANNELS 1 Zrotation", few = "with hardly a channel",
                    none = "found no joint named like hips";
  std::string row = Times(3 * body::kJointCount, "0 ");
  row.back() = '\n';
  const std::string small = Humanoid(kTurns, kTurns);
  // The most that frames may take: rows that Frames: does not announce, of many joints.
  std::string most = WithRows(flat(200, one, 60), Times(59, "0 ") + "0\n", kFile);
  const std::size_t frames = most.find("Frames: ");
  most.replace(frames, most.find('\n', frames) - frames, "Frames: 1");
  std::string returns = most + std::string(1, '\0'), wide = "\xFF\xFE";
  std::replace(returns.begin(), returns.end(), '\n', '\r');
  for (const char c : most) wide += {c, '\0'};
  return {
      {"rows that are not announced", most, few},
      {"the same in lines of Mac OS, with a NUL at the end", returns, few},
      {"the same in UTF-16", wide, few},
      {"one joint too many", WithRows(flat(1024, one, 130), Times(129, "0 ") + "0\n", kFile),
       "one more joint, expected at most 256"},
      // Of these only a minute of frames of 1 ms is read.
      {"joints without channels", WithRows(flat(8, one), "0\n", kFile), none},
      {"hardly a byte per frame", WithRows(flat(1, one), "0\n", kFile), none},
      {"a humanoid of one channel", WithRows(Humanoid("", one), "0\n", kFile), ""},
      {"more than a minute", WithRows(small, row, kFile), ""},
      {"a minute of the densest text", WithRows(small, row, 60'000 * row.size()), ""},
      {"a name that is the file", "HIERARCHY\nROOT " + std::string(kFile, 'a') + "\n{\n}\n",
       "a joint name of 8388608 bytes"},
      {"end sites",
       "HIERARCHY\nROOT a\n{\n" + Times(kFile / 26, "End Site{OFFSET 0 0 0}\n") + "}\n", "MOTION"},
      {"numbers of many digits",
       WithRows(small, Times(3 * body::kJointCount - 1, "0." + std::string(700, '7') + " ") + "0\n",
                kFile),
       ""},
      {"frames that are not there", small + "MOTION\nFrames: 99999999\nFrame Time: 0.001\n0 0 0\n",
       "found 3 values in row 1, expected 63"},
  };
}

TEST(HostileClips, ABvhTakesMemoryAndTimeInProportionToItsSize) {
  for (const HostileFile& file : BvhFiles()) ExpectInProportion(file);
}

std::string Word(std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  return std::string(reinterpret_cast<const char*>(&word), 4);
}
std::string Glb(std::string text, std::string data) {
  text = R"({"asset":{"version":"2.0"},)" + text + "}";
  text.resize((text.size() + 3) / 4 * 4, ' ');
  data.resize((data.size() + 3) / 4 * 4);
  return "glTF" + Word(2) + Word(28 + text.size() + data.size()) + Word(text.size()) + "JSON" +
         text + Word(data.size()) + std::string("BIN\0", 4) + data;
}
std::string List(const std::string& key, const std::vector<std::string>& entries) {
  std::string text = "\"" + key + "\":[";
  for (std::size_t i = 0; i < entries.size(); ++i) text += (i == 0 ? "" : ",") + entries[i];
  return text + "]";
}
std::vector<std::string> Copies(std::size_t count, const std::string& entry) {
  return std::vector<std::string>(count, entry);
}
std::string Bytes(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), 4 * values.size()};
}

// The canonical humanoid's nodes, and `more` below the first.
std::vector<std::string> Nodes(const std::vector<std::string>& more = {}) {
  std::vector<std::string> nodes;
  for (int c = 0; c < body::kJointCount; ++c) {
    const auto offset = body::Offset(c);
    std::string children;
    const auto add = [&children](std::size_t child) {
      children += (children.empty() ? "" : ",") + std::to_string(child);
    };
    for (int child = c + 1; child < body::kJointCount; ++child) {
      if (body::kHumanoid[static_cast<std::size_t>(child)].parent == c) {
        add(static_cast<std::size_t>(child));
      }
    }
    for (std::size_t i = 0; c == 0 && i < more.size(); ++i) add(body::kJointCount + i);
    nodes.push_back(
        R"({"name":")" + std::string(body::kHumanoid[static_cast<std::size_t>(c)].name) +
        R"(","translation":[)" + std::to_string(offset.x()) + "," + std::to_string(offset.y()) +
        "," + std::to_string(offset.z()) + R"(],"children":[)" + children + "]}");
  }
  nodes.insert(nodes.end(), more.begin(), more.end());
  return nodes;
}
std::vector<std::string> Beside(std::vector<std::string> nodes, const std::string& other) {
  nodes.push_back(other);
  return nodes;
}
std::string View(std::size_t offset, std::size_t bytes) {
  return R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" +
         std::to_string(bytes) + "}";
}
std::string Accessor(int view, std::size_t count, const std::string& type) {
  return R"({"bufferView":)" + std::to_string(view) + R"(,"componentType":5126,"count":)" +
         std::to_string(count) + R"(,"type":")" + type + R"("})";
}
std::string Channel(std::size_t sampler, std::size_t node, const std::string& path = "rotation") {
  return R"({"sampler":)" + std::to_string(sampler) + R"(,"target":{"node":)" +
         std::to_string(node) + R"(,"path":")" + path + R"("}})";
}
std::string Animation(const std::vector<std::string>& channels,
                      const std::vector<std::string>& samplers) {
  return "{" + List("channels", channels) + "," + List("samplers", samplers) + "}";
}
const std::string kSampler = R"({"input":0,"output":1})";

std::vector<HostileFile> GltfFiles() {
  const std::string buffers = List("buffers", {R"({"byteLength":1})"});
  const std::string data = Bytes({0, 60, 0, 0, 0, 1, 0, 0, 0, 1});
  const auto file = [&](const std::vector<std::string>& nodes,
                        const std::vector<std::string>& accessors,
                        const std::vector<std::string>& views, const std::string& animations,
                        const std::string& bytes) {
    return Glb(buffers + "," + List("nodes", nodes) + "," + List("accessors", accessors) + "," +
                   List("bufferViews", views) + "," + animations,
               bytes);
  };
  const std::vector<std::string> two{Accessor(0, 2, "SCALAR"), Accessor(1, 2, "VEC4")};
  const std::vector<std::string> views{View(0, 8), View(8, 32)};
  const std::string turn = List("animations", {Animation({Channel(0, 1)}, {kSampler})});
  std::vector<HostileFile> files{
      {"a minute of two keys", file(Nodes(), two, views, turn, data), ""},
      {"nodes and animations without content",
       file(Nodes(Copies(60'000, "{}")), two, views,
            List("animations", Copies(4000, Animation({}, {}))), data),
       "nodes and channels than a file of"},
      {"animations that move others",
       file(
           Beside(Nodes(), "{}"), two, views,
           List("animations", Copies(4000, Animation({Channel(0, body::kJointCount)}, {kSampler}))),
           data),
       "no animation that turns the humanoid's bones"},
      {"a channel over and over",
       file(Nodes(), two, views,
            List("animations", {Animation(Copies(5'000, Channel(0, 1)), {kSampler})}), data),
       ""},
      {"more channels than any motion",
       file(Nodes(), two, views,
            List("animations", {Animation(Copies(100'000, Channel(0, 1)), {kSampler})}), data),
       "nodes and channels than a file of"},
      {"entries without content",
       Glb(List("nodes", Nodes()) + "," + List("accessors", Copies(kFile / 3, "{}")), ""),
       "nodes and channels than a file of"},
      {"lists without content",
       Glb(List("nodes", Nodes()) + "," + List("animations", Copies(kFile / 3, "[]")), ""),
       "nodes and channels than a file of"},
      {"children that are digits",
       Glb(R"("nodes":[{"children":[)" + Times(kFile / 2, "0,") + "0]}]", ""),
       "nodes and channels than a file of"},
      {"a name that is the file",
       Glb(R"("nodes":[{"name":")" + std::string(kFile, 'x') + R"("}])", ""), "no bone named"},
      {"names of many nodes",
       Glb(List("nodes", Copies(30'000, R"({"name":")" + std::string(200, 'x') + R"("})")), ""),
       "no bone named"},
      {"brackets",
       Glb("\"nodes\":" + std::string(kFile / 2, '[') + std::string(kFile / 2, ']'), ""),
       "JSON that cannot be read"},
  };
  // 256 joints, sampled at 240 Hz for a minute because two keys are so near to each other.
  std::vector<std::string> channels{Channel(0, 1), Channel(1, 2)};
  files.push_back(
      {"a fast and a slow channel of many joints",
       file(Nodes(Copies(230, "{}")), {two[0], two[1], Accessor(2, 2, "SCALAR")},
            {views[0], views[1], View(40, 8)},
            List("animations", {Animation(channels, {kSampler, R"({"input":2,"output":1})"})}),
            data + Bytes({0, 1.0F / 240})),
       ""});
  // Every channel with an accessor of its own, all over the same data.
  constexpr std::size_t kKeys = 200'000;
  std::vector<float> keys, turns;
  for (std::size_t i = 0; i < kKeys; ++i) {
    keys.push_back(static_cast<float>(i) / 4000);
    turns.insert(turns.end(), {0, 0, 0, 1});
  }
  std::vector<std::string> accessors, samplers, all;
  for (std::size_t i = 0; i < body::kJointCount; ++i) {
    accessors.push_back(Accessor(0, kKeys, "SCALAR"));
    accessors.push_back(Accessor(1, kKeys, "VEC4"));
    samplers.push_back(R"({"input":)" + std::to_string(2 * i) + R"(,"output":)" +
                       std::to_string(2 * i + 1) + "}");
    all.push_back(Channel(i, i));
  }
  const std::vector<std::string> large{View(0, 4 * kKeys), View(4 * kKeys, 16 * kKeys)};
  files.push_back({"accessors over the same data",
                   file(Nodes(), accessors, large, List("animations", {Animation(all, samplers)}),
                        Bytes(keys) + Bytes(turns)),
                   "found more values in its channels than the file can hold"});
  // Zeros of which hardly a byte is in the file: a minute of four small numbers, and far more.
  constexpr std::size_t kRows = 100'000;
  const auto zeros = [](std::size_t rows) {
    const std::string unpacked(4 * rows, '\0');
    std::string packed(meshopt_encodeVertexBufferBound(rows, 4), '\0');
    packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
                                             packed.size(), unpacked.data(), rows, 4));
    return packed;
  };
  const auto packed_view = [](std::size_t offset, std::size_t bytes, std::size_t rows) {
    return R"({"buffer":1,"byteLength":)" + std::to_string(4 * rows) +
           R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" +
           std::to_string(offset) + R"(,"byteLength":)" + std::to_string(bytes) +
           R"(,"byteStride":4,"count":)" + std::to_string(rows) + R"(,"mode":"ATTRIBUTES"}}})";
  };
  const auto small_numbers = [](int view, std::size_t rows) {
    return R"({"bufferView":)" + std::to_string(view) +
           R"(,"componentType":5120,"normalized":true,"type":"VEC4","count":)" +
           std::to_string(rows) + "}";
  };
  std::vector<float> rising(kRows);
  for (std::size_t i = 0; i < kRows; ++i) rising[i] = static_cast<float>(i) / 2000;
  for (const auto& [rows, message] :
       {std::pair{kRows, ""}, std::pair{std::size_t{1} << 20, "more values in its channels than"},
        std::pair{std::size_t{1} << 24, "bytes packed into"}}) {
    const std::string packed = zeros(rows), times = Bytes(rising);
    files.push_back({"packed zeros, " + std::to_string(rows),
                     file(Nodes(), {Accessor(0, kRows, "SCALAR"), small_numbers(1, rows)},
                          {View(0, times.size()), packed_view(times.size(), packed.size(), rows)},
                          turn, times + packed),
                     message});
  }
  // Many views over the same packed bytes.
  const std::string packed = zeros(kRows), times = Bytes(rising);
  std::vector<std::string> same{View(0, times.size())}, of_them{Accessor(0, kRows, "SCALAR")};
  samplers.clear();
  for (std::size_t i = 0; i < body::kJointCount; ++i) {
    same.push_back(packed_view(times.size(), packed.size(), kRows));
    of_them.push_back(small_numbers(static_cast<int>(1 + i), kRows));
    samplers.push_back(R"({"input":0,"output":)" + std::to_string(1 + i) + "}");
  }
  files.push_back(
      {"packed bytes over and over",
       file(Nodes(), of_them, same, List("animations", {Animation(all, samplers)}), times + packed),
       "bytes packed into"});
  return files;
}

TEST(HostileClips, AGltfTakesMemoryAndTimeInProportionToItsSize) {
  for (const HostileFile& file : GltfFiles()) ExpectInProportion(file);
}

// The humanoid's nodes with its hips at the end of a chain and a chain below them, all of them
// joints of a skin; `data` bytes of meshes.
std::string Chains(std::size_t length, std::size_t data) {
  std::vector<std::string> nodes = Nodes({"{}"});
  const auto chain = [&](std::size_t last) {
    for (std::size_t i = 1; i < length; ++i) {
      nodes.push_back(R"({"children":[)" + std::to_string(nodes.size() + 1) + "]}");
    }
    nodes.push_back(R"({"children":[)" + std::to_string(last) + "]}");
  };
  nodes[body::kJointCount] = R"({"children":[)" + std::to_string(nodes.size()) + "]}";
  chain(nodes.size() + 2 * length);
  chain(0);
  nodes.emplace_back("{}");
  std::string joints = "0";
  for (std::size_t node = 1; node < nodes.size(); ++node) joints += "," + std::to_string(node);
  return Glb(List("nodes", nodes) + R"(,"skins":[{"joints":[)" + joints + "]}]",
             std::string(data, 'x'));
}

std::vector<HostileFile> AvatarFiles() {
  constexpr const char* kMany = "found more nodes, skins, buffers and images than a file of ";
  const auto listed = [](const std::string& key, std::size_t count, const std::string& entry) {
    return Glb("\"" + key + "\":[" + Times(count - 1, entry + ",") + entry + "]", "");
  };
  const auto humanoid = [](const std::string& extension, const std::string& bones) {
    return Glb(List("nodes", Nodes()) + R"(,"extensions":{")" + extension +
                   R"(":{"humanoid":{"humanBones":)" + bones + "}}}",
               "");
  };
  std::string bones = R"({"hips":{"node":0})", keys = bones;
  for (int i = 0; i < 60'000; ++i) bones += ",\"b" + std::to_string(i) + R"(":{"node":1})";
  for (int i = 0; i < 350'000; ++i) keys += ",\"" + std::to_string(i) + "\":0";
  return {
      {"a chain above the hips, and one below", Chains(30'000, 16 << 20), ""},
      {"chains without meshes", Chains(30'000, 0), kMany},
      {"nodes", listed("nodes", 1'000'000, "{}"), kMany},
      {"skins", listed("skins", 1'000'000, "{}"), kMany},
      {"skins of one joint", listed("skins", 200'000, R"({"joints":[0]})"), kMany},
      {"text in place of skins", listed("skins", 1'000'000, R"("")"), kMany},
      {"images", listed("images", 1'000'000, "{}"), kMany},
      {"meshes", listed("meshes", 1'000'000, "{}"), "no bone named like hips"},
      {"names", listed("nodes", 60'000, R"({"name":"Bip01 L UpperArm Twist"})"), kMany},
      {"children", Glb(R"("nodes":[{"children":[)" + Times(1'000'000, "0,") + "0]}]", ""), kMany},
      {"a table of bones", humanoid("VRMC_vrm", bones + "}"), kMany},
      {"a table of numbers", humanoid("VRMC_vrm", keys + "}"), kMany},
      {"a list of bones",
       humanoid("VRM", "[" + Times(60'000, R"({"bone":"jaw","node":0},)") + "{}]"), kMany},
      {"a list in a bone",
       humanoid("VRMC_vrm", R"({"hips":{"node":0,"x":[)" + Times(900'000, "0,") + "0]}}"), kMany},
      {"a number of many digits",
       Glb(R"("nodes":[{"scale":[)" + std::string(3'000'000, '1') + "]}]", ""),
       "a number of more than 4096 digits"},
      {"a fraction of many digits",
       Glb(R"("nodes":[{"scale":[0.)" + std::string(3'000'000, '3') + "]}]", ""),
       "a number of more than 4096 digits"},
  };
}

TEST(HostileClips, AnAvatarTakesMemoryAndTimeInProportionToItsSize) {
  constexpr std::size_t kFixedOfAvatar = std::size_t{2} << 20;
  const support::TemporaryFolder folder;
  const std::string path = folder / "avatar.glb";
  for (const HostileFile& file : AvatarFiles()) {
    SCOPED_TRACE(file.name + ", " + std::to_string(file.bytes.size()) + " bytes");
    std::ofstream(path, std::ios::binary) << file.bytes;
    const auto begin = std::chrono::steady_clock::now();
    std::string message;
    std::size_t peak_bytes = 0;
    {
      const support::CountNew count;
      message = ReadAvatar(path, "auto", {}).status().message();
      peak_bytes = count.peak_bytes();
    }
    const auto took = std::chrono::steady_clock::now() - begin;
    EXPECT_LE(peak_bytes, kMemoryPerByte * file.bytes.size() + kFixedOfAvatar);
    EXPECT_LT(took, kMostTime);
    EXPECT_THAT(message, HasSubstr(file.message));
    EXPECT_EQ(message.empty(), file.message.empty()) << message;
  }
}

TEST(HostileClips, WorkBeyondItsTimeIsRefusedByFileAndLimit) {
  const auto none = WorkLimit::Within(std::chrono::milliseconds(0), "a clip of 60 s");
  const std::string why = "x.bvh: took longer than 0 s, expected a clip of 60 s";
  const std::string text = Humanoid(kTurns, kTurns) + "MOTION\nFrames: 2\nFrame Time: 0.1\n" +
                           Times(2, Times(3 * body::kJointCount, "0 ") + "\n");
  EXPECT_EQ(ParseBvh(text, "x.bvh", {.longest_s = 60, .work = none}).status().message(), why);
  auto clip = ParseBvh(text, "x.bvh");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  const auto bound = rig::BindDialect(clip.value().skeleton);
  ASSERT_TRUE(bound.ok()) << bound.status().message();
  Clip copy = clip.value();
  EXPECT_EQ(ToCanonical(std::move(copy), bound.value(), none, "x.bvh").status().message(), why);
  const auto poses = ToCanonical(std::move(clip.value()), bound.value(), {}, "x.bvh");
  EXPECT_EQ(ResamplePoses(poses.value(), 10, 30, none, "x.bvh").status().message(), why);
  const HostileFile glb = GltfFiles().front();
  EXPECT_EQ(ParseGltfClip(glb.bytes, "x.glb", {.longest_s = 60, .work = none}).status().message(),
            "x.glb: took longer than 0 s, expected a clip of 60 s");
}

}  // namespace
}  // namespace styled::clip
