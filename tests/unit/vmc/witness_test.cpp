// Others' OSC against ours, both ways: liblo 0.31 or 0.32, and oscpack 1.1.
#include "tests/unit/vmc/witness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lo/lo.h>
#include <oscpack/osc/OscOutboundPacketStream.h>

#include <bit>
#include <cstdlib>
#include <memory>

#include "proto/rigs/vmc/bones.h"
#include "proto/rigs/vmc/packer.h"
#include "tests/unit/vmc/osc_cases.h"

namespace styled::vmc {
namespace {

using testing::Bytes;
using testing::Verdict;
using testing::Witness;

bool Agrees(const testing::OscCase& c, const Witness& witness) {
  return witness.taken == (c.expected == osc::Result::kOk);
}

bool LibloAgrees(Verdict marked) {
  int major = 0, minor = 0;
  lo_version(nullptr, 0, &major, &minor, nullptr, 0, nullptr, nullptr, nullptr);
  const bool new_one = major > 0 || minor >= 32;
  return marked == Verdict::kAgrees || (marked == Verdict::kDiffersBefore032 && new_one);
}

TEST(Witnesses, JudgeEveryCaseAsWeDoButForThoseMarked) {
  for (const auto& c : testing::OscCases()) {
    if (c.liblo != Verdict::kNotAsked) {
      EXPECT_EQ(Agrees(c, testing::ReadLiblo(c.bytes)), LibloAgrees(c.liblo)) << c.name;
    }
    if (c.oscpack != Verdict::kNotAsked) {
      EXPECT_EQ(Agrees(c, testing::ReadOscpack(c.bytes)), c.oscpack == Verdict::kAgrees) << c.name;
    }
  }
}

TEST(Witnesses, ReadTheSameMessagesInWhatAllTake) {
  for (const auto& c : testing::OscCases()) {
    if (c.expected != osc::Result::kOk) continue;
    const auto ours = testing::ReadOurs(c.bytes).messages;
    if (c.liblo == Verdict::kAgrees) {
      EXPECT_EQ(testing::ReadLiblo(c.bytes).messages, ours) << c.name;
    }
    if (c.oscpack == Verdict::kAgrees) {
      EXPECT_EQ(testing::ReadOscpack(c.bytes).messages, ours) << c.name;
    }
  }
}

std::string Hex(float value) {
  char text[16];
  std::snprintf(text, sizeof text, " %08x", std::bit_cast<unsigned>(value));
  return text;
}

TEST(Witnesses, ReadEveryValueOfAFrameThatWePacked) {
  std::vector<Bone> bones;
  std::vector<std::string> expected{"/VMC/Ext/Root/Pos ,sfffffff root"};
  const auto place = [&expected](const Transform& transform) {
    for (const float value : transform.position) expected.back() += Hex(value);
    for (const float value : transform.rotation) expected.back() += Hex(value);
  };
  Packed frame;
  frame.root.transform = {{1, 2, 3}, {0.5F, -0.5F, 0.5F, -0.5F}};
  place(frame.root.transform);
  for (int bone = 0; bone < kBoneCount; ++bone) {
    const auto value = static_cast<float>(bone);
    bones.push_back({kBones[bone].name, {{value, -value, 0.1F}, {0.6F, 0, value, 0.8F}}});
    expected.push_back("/VMC/Ext/Bone/Pos ,sfffffff " + std::string(kBones[bone].name));
    place(bones.back().transform);
  }
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) names.push_back("mouthShrugUpper" + std::to_string(i));
  std::vector<Blend> blends;
  for (const std::string& name : names) {
    blends.push_back({name, 1.0F / static_cast<float>(1 + blends.size())});
    expected.push_back("/VMC/Ext/Blend/Val ,sf " + name + Hex(blends.back().value));
  }
  expected.insert(expected.end(), {"/VMC/Ext/Blend/Apply ,", "/VMC/Ext/OK ,iiii 1 3 0 1",
                                   "/VMC/Ext/T ,f" + Hex(12.345F)});
  frame.bones = bones;
  frame.blends = blends;
  frame.time_s = 12.345F;

  std::vector<std::string> liblo, oscpack;
  Bytes buffer(Packer::kMaxPacketSize);
  Packer packer(frame);
  while (const std::size_t size = packer.Next(buffer)) {
    const auto datagram = std::span(buffer).first(size);
    const Witness first = testing::ReadLiblo(datagram), second = testing::ReadOscpack(datagram);
    EXPECT_TRUE(first.taken && second.taken);
    liblo.insert(liblo.end(), first.messages.begin(), first.messages.end());
    oscpack.insert(oscpack.end(), second.messages.begin(), second.messages.end());
  }
  EXPECT_EQ(liblo, expected);
  EXPECT_EQ(oscpack, expected);
}

const std::vector<std::string> kSample{"/VMC/Ext/OK ,iii 1 3 0",
                                       "/VMC/Ext/Root/Pos ,sfffffff root" + Hex(1) + Hex(2) +
                                           Hex(3) + Hex(0) + Hex(0) + Hex(0) + Hex(1),
                                       "/VMC/Ext/Blend/Val ,sf Joy" + Hex(0.25F),
                                       "/VMC/Ext/Blend/Apply ,", "/VMC/Ext/T ,f" + Hex(9)};

// A bundle within a bundle.
TEST(Witnesses, OscpacksBytesAreReadByUs) {
  std::array<char, 1024> buffer;
  ::osc::OutboundPacketStream stream(buffer.data(), buffer.size());
  stream << ::osc::BeginBundleImmediate << ::osc::BeginMessage("/VMC/Ext/OK") << 1 << 3 << 0
         << ::osc::EndMessage << ::osc::BeginBundle(77) << ::osc::BeginMessage("/VMC/Ext/Root/Pos")
         << "root" << 1.0F << 2.0F << 3.0F << 0.0F << 0.0F << 0.0F << 1.0F << ::osc::EndMessage
         << ::osc::BeginMessage("/VMC/Ext/Blend/Val") << "Joy" << 0.25F << ::osc::EndMessage
         << ::osc::BeginMessage("/VMC/Ext/Blend/Apply") << ::osc::EndMessage << ::osc::EndBundle
         << ::osc::BeginMessage("/VMC/Ext/T") << 9.0F << ::osc::EndMessage << ::osc::EndBundle;
  const Witness ours = testing::ReadOurs(std::as_bytes(std::span(stream.Data(), stream.Size())));
  EXPECT_TRUE(ours.taken);
  EXPECT_EQ(ours.messages, kSample);
}

TEST(Witnesses, LiblosBytesAreReadByUs) {
  const auto message = [](auto fill) {
    lo_message made = lo_message_new();
    fill(made);
    return made;
  };
  lo_bundle inner = lo_bundle_new({77, 0});
  lo_bundle_add_message(inner, "/VMC/Ext/Root/Pos", message([](lo_message m) {
                          lo_message_add(m, "sfffffff", "root", 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0);
                        }));
  lo_bundle_add_message(inner, "/VMC/Ext/Blend/Val",
                        message([](lo_message m) { lo_message_add(m, "sf", "Joy", 0.25); }));
  lo_bundle_add_message(inner, "/VMC/Ext/Blend/Apply", message([](lo_message) {}));
  lo_bundle outer = lo_bundle_new(LO_TT_IMMEDIATE);
  lo_bundle_add_message(outer, "/VMC/Ext/OK",
                        message([](lo_message m) { lo_message_add(m, "iii", 1, 3, 0); }));
  lo_bundle_add_bundle(outer, inner);
  lo_bundle_add_message(outer, "/VMC/Ext/T",
                        message([](lo_message m) { lo_message_add(m, "f", 9.0); }));
  std::size_t size = 0;
  const std::unique_ptr<void, void (*)(void*)> bytes(lo_bundle_serialise(outer, nullptr, &size),
                                                     std::free);
  lo_bundle_free_recursive(outer);
  const Witness ours = testing::ReadOurs({static_cast<const std::byte*>(bytes.get()), size});
  EXPECT_TRUE(ours.taken);
  EXPECT_EQ(ours.messages, kSample);
}

// Every type, byte for byte: liblo turns what it reads into a message of its own.
TEST(Witnesses, LibloReadsOurMessageOfEveryType) {
  Bytes bytes;
  for (const auto& c : testing::OscCases()) {
    if (c.name == "all types") bytes = c.bytes;
  }
  int result = -1;
  Bytes copy = bytes;
  lo_message message = lo_message_deserialise(copy.data(), copy.size(), &result);
  ASSERT_NE(message, nullptr) << result;
  EXPECT_STREQ(lo_message_get_types(message), "ifsbTFNIhtdcmS");
  Bytes again(lo_message_length(message, "/a"));
  lo_message_serialise(message, "/a", again.data(), nullptr);
  lo_message_free(message);
  EXPECT_EQ(again, bytes);
}

}  // namespace
}  // namespace styled::vmc
