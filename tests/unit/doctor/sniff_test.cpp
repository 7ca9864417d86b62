// Names of datagrams. Bytes are those that the codecs' own tests were written with by hand, and
// real ones of mocopi and NatNet where they are at hand.
#include "clients/doctor/sniff.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "proto/rigs/native/datagram.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"
#include "tests/unit/ifacialmocap/texts.h"
#include "tests/unit/livelinkface/decode_cases.h"
#include "tests/unit/mocopi/decode_cases.h"
#include "tests/unit/mvn/packets.h"
#include "tests/unit/natnet/decode_cases.h"
#include "tests/unit/qtm/decode_cases.h"
#include "tests/unit/rokoko/lz4_frames.h"
#include "tests/unit/rokoko/texts.h"
#include "tests/unit/slimevr/decode_cases.h"
#include "tests/unit/vmc/bytes.h"

namespace styled::doctor {
namespace {

using Bytes = std::vector<std::byte>;

Bytes ToBytes(std::string_view text) {
  Bytes out;
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
  return out;
}

Bytes Native(native::Kind kind, const std::string& payload) {
  Bytes out(native::kHeaderSize + payload.size());
  out.resize(native::Encode({kind, 7, 1, ToBytes(payload)}, out));
  return out;
}

Bytes NativeFrame() {
  v1::SourceFrame frame;
  frame.set_performer("anna");
  return Native(native::Kind::kSourceFrame, frame.SerializeAsString());
}

// id, size, payload: little-endian.
Bytes NatNet(natnet::MessageId id, const Bytes& payload) {
  using natnet::testing::I16;
  return natnet::testing::Join(I16{static_cast<int>(id)}, I16{static_cast<int>(payload.size())},
                               natnet::testing::Part{payload});
}

Bytes ServerInfo(int major, int minor) {
  using namespace natnet::testing;
  return NatNet(natnet::MessageId::kServerInfo,
                Join(Text{"Motive"}, Any{249}, Part{Bytes(4)},
                     Part{{std::byte(major), std::byte(minor), {}, {}}}));
}

Bytes Cut(Bytes bytes, std::size_t by = 1) {
  bytes.resize(bytes.size() - by);
  return bytes;
}

struct Case {
  std::string name;
  Bytes bytes;
  Format format;
  Verdict verdict;
  std::string kind;
};

class SniffTest : public testing::Test {
 protected:
  void Expect(const std::vector<Case>& cases) {
    for (const Case& c : cases) {
      const Sniffed found = Sniffer().Sniff(c.bytes);
      EXPECT_EQ(Row(found.format).word, Row(c.format).word) << c.name;
      EXPECT_STREQ(Name(found.verdict), Name(c.verdict)) << c.name;
      EXPECT_EQ(found.kind, c.kind) << c.name;
    }
  }
};

TEST_F(SniffTest, WhatNobodyTakesIsForeignAndDescribed) {
  const auto foreign = [](std::string name, Bytes bytes, std::string kind) {
    return Case{std::move(name), std::move(bytes), Format::kUnknown, Verdict::kForeign,
                std::move(kind)};
  };
  Bytes noitom(64);
  noitom[0] = noitom[63] = std::byte{0xFF};
  noitom[62] = noitom[63] = std::byte{0xFF};
  noitom[1] = std::byte{0xDD};
  noitom[63] = std::byte{0xEE};
  const Bytes dns = slimevr::testing::Hex("1A 2B 01 00 00 01 00 00 00 00 00 00");
  Expect({foreign("nothing", {}, "empty datagrams"),
          foreign("text", ToBytes("hello world, it is me"), "text: hello world, it "),
          foreign("JSON", ToBytes(R"({"a":1})"), "JSON, but not Rokoko's"),
          foreign("half of JSON", ToBytes(R"({"a")"), "JSON, but not Rokoko's"),
          foreign("a mixer's OSC",
                  vmc::testing::S("/ch/01/mix/fader") + vmc::testing::S(",fff") +
                      vmc::testing::Floats({1, 2, 3}),
                  "OSC, but not VMC: /ch/01/mix/fader"),
          foreign("half of OSC", ToBytes("/foo"), "damaged OSC"),
          foreign("Axis Studio", noitom, "Noitom Axis Studio (binary BVH), which is not supported"),
          foreign("a name server's question", dns, "bytes 1A 2B 01 00"),
          foreign("zeros", Bytes(8), "bytes 00 00 00 00")});
}

TEST_F(SniffTest, OurOwn) {
  v1::Body body;
  body.set_performer("anna");
  Bytes other_version = NativeFrame();
  other_version[4] = std::byte{9};
  Bytes changed = NativeFrame();
  changed.back() ^= std::byte{1};
  Expect({{"frame", NativeFrame(), Format::kNative, Verdict::kPose, "frames"},
          {"body", Native(native::Kind::kBody, body.SerializeAsString()), Format::kNative,
           Verdict::kSkeleton, "skeletons"},
          {"version 9", other_version, Format::kNative, Verdict::kUseless, "version 9"},
          {"a bit turned", changed, Format::kNative, Verdict::kDamaged, "bad checksum"},
          {"cut", Cut(NativeFrame()), Format::kNative, Verdict::kDamaged, "length mismatch"},
          {"the mark alone", ToBytes("STYD"), Format::kNative, Verdict::kDamaged, "too short"},
          {"no message", Native(native::Kind::kBody, "\xFF\xFF"), Format::kNative,
           Verdict::kDamaged, "unreadable skeletons"}});
}

TEST_F(SniffTest, Mvn) {
  using namespace mvn::testing;
  Expect(
      {{"quaternions", Quaternions(), Format::kMvn, Verdict::kPose, "quaternions (02)"},
       {"angles", Eulers(), Format::kMvn, Verdict::kPose, "Euler angles (01)"},
       {"name", Meta("name:Anna\n"), Format::kMvn, Verdict::kTalk, "names (12)"},
       {"T-pose", ScaleOf({"Pelvis"}), Format::kMvn, Verdict::kSkeleton, "T-pose (13)"},
       {"timecode", TimecodeOf("10:20:30.456", false), Format::kMvn, Verdict::kTalk,
        "timecode (25)"},
       {"for Unity", Sized(Head("05", 0)), Format::kMvn, Verdict::kUseless, "Unity3D poses (05)"},
       {"markers", Sized(Head("03", 0)), Format::kMvn, Verdict::kUseless, "marker positions (03)"},
       {"cut", Cut(Quaternions(), 40), Format::kMvn, Verdict::kDamaged, "quaternions (02)"},
       {"a head cut", Cut(Head("02", 0)), Format::kMvn, Verdict::kDamaged, "too short"}});
}

TEST_F(SniffTest, Mocopi) {
  using namespace mocopi::testing;
  Bytes other = GoodFrame();
  // The version's byte: behind head (8), ftyp (8 + 18) and vrsn (8).
  other[8 + 26 + 8] = std::byte{2};
  Expect({{"frame", GoodFrame(), Format::kMocopi, Verdict::kPose, "poses (fram)"},
          {"skeleton", GoodSkeleton(), Format::kMocopi, Verdict::kSkeleton, "skeleton (skdf)"},
          {"version 2", other, Format::kMocopi, Verdict::kUseless, "a version that is not 1"},
          {"cut", Cut(GoodFrame()), Format::kMocopi, Verdict::kDamaged, "cut chunk"}});
}

TEST_F(SniffTest, Vmc) {
  using namespace vmc::testing;
  const auto unloaded = S("/VMC/Ext/OK") + S(",i") + I(0);
  const auto device =
      S("/VMC/Ext/Hmd/Pos") + S(",sfffffff") + S("hmd") + Floats({0, 0, 0, 0, 0, 0, 1});
  Expect({{"bones in a bundle", Bundle({TimeMessage(1), BoneMessage("Hips")}), Format::kVmc,
           Verdict::kPose, "bones"},
          {"a bone by itself", BoneMessage("Head"), Format::kVmc, Verdict::kPose, "bones"},
          {"time", TimeMessage(1), Format::kVmc, Verdict::kTalk, "time and state"},
          {"a face", Bundle({BlendMessage("Joy", 1), ApplyMessage()}), Format::kVmc, Verdict::kTalk,
           "facial expressions"},
          {"devices", device, Format::kVmc, Verdict::kPose, "devices"},
          {"no avatar", Bundle({unloaded, TimeMessage(1)}), Format::kVmc, Verdict::kUseless,
           "\"no avatar is loaded\""},
          {"cut", Cut(Bundle({BoneMessage("Hips")}), 4), Format::kVmc, Verdict::kDamaged,
           "bad element"}});
}

TEST_F(SniffTest, VrChat) {
  using namespace vmc::testing;
  const auto tracker = S("/tracking/trackers/1/position") + S(",fff") + Floats({0, 1, 0});
  const auto eyes = S("/tracking/eye/EyesClosedAmount") + S(",f") + F(1);
  Expect({{"trackers", Bundle({tracker, tracker}), Format::kVrChat, Verdict::kPose, "trackers"},
          {"eyes", eyes, Format::kVrChat, Verdict::kTalk, "tracking without trackers"},
          {"cut", Cut(Bundle({tracker}), 4), Format::kVrChat, Verdict::kDamaged, "bad element"}});
}

TEST_F(SniffTest, NatNet) {
  using namespace natnet::testing;
  const auto id = natnet::MessageId::kFrameOfData;
  const auto bare = [](natnet::Version v) {
    return Join(Part{natnet::testing::Head(v, false)}, I32{0}, natnet::testing::Sized(v, {}),
                Part{Tail(v, false)});
  };
  for (const natnet::Version v : {k27, k30, k41}) {
    Expect({{"skeletons of " + ToString(v), NatNet(id, FullFrame(v)), Format::kNatNet,
             Verdict::kPose, "frames with skeletons"},
            {"none of " + ToString(v), NatNet(id, bare(v)), Format::kNatNet, Verdict::kUseless,
             "frames without a skeleton"}});
  }
  Expect(
      {{"server", ServerInfo(3, 0), Format::kNatNet, Verdict::kTalk, "server of NatNet 3.0"},
       {"old server", ServerInfo(2, 5), Format::kNatNet, Verdict::kUseless, "server of NatNet 2.5"},
       {"a frame's id alone", NatNet(id, Bytes(3)), Format::kUnknown, Verdict::kForeign,
        "bytes 07 00 03 00"}});
}

// With the server's word every frame that cannot be read is one that was damaged.
TEST_F(SniffTest, QtmTalksFirst) {
  using namespace qtm::testing;
  const Bytes greeting = Command("QTM RT Interface connected");
  Expect({{"greeting", greeting, Format::kQtm, Verdict::kTalk, "server's greeting"},
          {"greeting in other letters", Command("qtm rt interface CONNECTED."), Format::kQtm,
           Verdict::kTalk, "server's greeting"},
          {"skeletons", Data(1, 1, TwoSkeletons()), Format::kQtm, Verdict::kPose, "skeletons"},
          {"markers", Data(1, 1, OtherComponent()), Format::kQtm, Verdict::kUseless,
           "frames without a skeleton"},
          {"parameters", Xml(kFlatXml), Format::kQtm, Verdict::kSkeleton, "parameters"},
          {"another text", Command("220 ftp"), Format::kUnknown, Verdict::kForeign,
           "bytes 10 00 00 00"}});
  EXPECT_EQ(RecordSize(greeting), greeting.size());
  Bytes two = greeting;
  two.insert(two.end(), 5, std::byte{1});
  EXPECT_EQ(RecordSize(two), greeting.size());
  EXPECT_EQ(RecordSize(std::span(greeting).first(30)), 0U);
}

TEST_F(SniffTest, NatNetOfAKnownVersionCanBeDamaged) {
  Sniffer sniffer;
  ASSERT_EQ(sniffer.Sniff(ServerInfo(3, 0)).format, Format::kNatNet);
  const auto found = sniffer.Sniff(NatNet(natnet::MessageId::kFrameOfData, Bytes(3)));
  EXPECT_STREQ(Name(found.verdict), "damaged");
  EXPECT_EQ(found.kind, "unreadable frames");
}

TEST_F(SniffTest, Rokoko) {
  using namespace rokoko::testing;
  Bytes packed;
  for (const unsigned char c : kLz4Default) packed.push_back(std::byte{c});
  Bytes broken = packed;
  broken[20] ^= std::byte{0x40};
  Expect({{"layout 3", ToBytes(kLayout3), Format::kRokoko, Verdict::kPose, "actors (JSON)"},
          {"layout 2", ToBytes(kLayout2), Format::kRokoko, Verdict::kPose, "actors (JSON)"},
          {"actors without a body, packed", packed, Format::kRokoko, Verdict::kUseless,
           "frames without an actor's body"},
          {"version 4", ToBytes(R"({"version":4,"scene":{"timestamp":1,"actors":[]}})"),
           Format::kRokoko, Verdict::kUseless, "a JSON version that is not 2 to 3"},
          {"cut", Cut(ToBytes(kLayout3), 9), Format::kRokoko, Verdict::kDamaged, "bad json"},
          {"packed and changed", broken, Format::kRokoko, Verdict::kDamaged, "bad lz4"}});
}

TEST_F(SniffTest, FacesOfPhones) {
  using live_link_face::testing::ByHand;
  const Bytes smile = live_link_face::testing::Written(live_link_face::testing::Smile());
  const Bytes text = ToBytes(ifacialmocap::testing::kVersion1);
  Expect(
      {{"Live Link Face", smile, Format::kLiveLinkFace, Verdict::kPose, "facial expressions"},
       {"without a face", ByHand(), Format::kLiveLinkFace, Verdict::kTalk, "\"no face is seen\""},
       {"iFacialMocap", text, Format::kIFacialMocap, Verdict::kPose, "facial expressions"}});
}

TEST_F(SniffTest, SlimeVr) {
  using namespace slimevr::testing;
  Expect({{"handshake", kHandshake, Format::kSlimeVr, Verdict::kTalk, "trackers seeking a server"},
          {"rotation", kRotation, Format::kSlimeVr, Verdict::kPose, "rotations"},
          {"bundle", kBundle, Format::kSlimeVr, Verdict::kPose, "rotations"},
          {"compact bundle", kCompactBundle, Format::kSlimeVr, Verdict::kPose, "rotations"},
          {"sensor info", kSensorInfo, Format::kSlimeVr, Verdict::kTalk, "state of trackers"}});
}

TEST_F(SniffTest, OfALargeDatagramTheBeginningIsEnough) {
  const auto format = [](const Bytes& bytes, std::size_t size) {
    const Sniffed found = Sniffer().SniffStart(std::span(bytes).first(size));
    EXPECT_STREQ(Name(found.verdict), found.format == Format::kUnknown ? "foreign" : "cut");
    return Row(found.format).word;
  };
  using namespace vmc::testing;
  EXPECT_EQ(format(NativeFrame(), 30), "native");
  EXPECT_EQ(format(mvn::testing::Quaternions(), 100), "mvn");
  EXPECT_EQ(format(mocopi::testing::GoodFrame(), 100), "mocopi");
  EXPECT_EQ(format(Bundle({BoneMessage("Hips"), BoneMessage("Head")}), 60), "vmc");
  EXPECT_EQ(format(ToBytes(rokoko::testing::kLayout3), 200), "rokoko");
  EXPECT_EQ(format(ToBytes("something else altogether"), 20), "unknown");
}

TEST_F(SniffTest, RecordsOfAStreamAreCutByTheirHeaders) {
  const Bytes mvn = mvn::testing::Quaternions(), own = NativeFrame();
  for (const Bytes& record : {mvn, own}) {
    Bytes stream = record;
    stream.insert(stream.end(), record.begin(), record.begin() + 10);
    EXPECT_EQ(RecordSize(stream), record.size());
    EXPECT_EQ(RecordSize(std::span(record).first(record.size() - 1)), 0U);
    EXPECT_EQ(RecordSize(std::span(record).first(8)), 0U);
  }
  Bytes endless = own;
  endless[10] = std::byte{0xFF};
  EXPECT_EQ(RecordSize(endless), endless.size()) << "a length that cannot be: not waited for";
  EXPECT_EQ(RecordSize(ToBytes("GET / HTTP/1.1")), 14U);
}

// Whatever a datagram begins with, its end may be missing.
TEST_F(SniffTest, EveryBeginningOfEveryFormatIsLookedAtInVain) {
  const std::vector<Bytes> wholes{
      NativeFrame(),
      mvn::testing::Quaternions(),
      mocopi::testing::GoodFrame(),
      vmc::testing::Bundle({vmc::testing::BoneMessage("Hips")}),
      NatNet(natnet::MessageId::kFrameOfData, natnet::testing::FullFrame({3, 0})),
      ServerInfo(3, 0),
      ToBytes(rokoko::testing::kLayout3),
      slimevr::testing::kBundle,
      live_link_face::testing::Written(live_link_face::testing::Smile()),
      ToBytes(ifacialmocap::testing::kVersion2)};
  Sniffer sniffer;
  for (const Bytes& whole : wholes) {
    const Format format = Sniffer().Sniff(whole).format;
    for (std::size_t size = 0; size < whole.size(); ++size) {
      // A copy of that very size, so that a sanitizer sees a byte read too far.
      const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const Sniffed found = sniffer.Sniff(part);
      EXPECT_TRUE(found.format == format || found.format == Format::kUnknown) << size;
      (void)sniffer.SniffStart(part);
    }
  }
}

// Packets that others made.
class RealPackets : public testing::Test {
 protected:
  static Bytes Read(const std::string& name) {
    const char* set = std::getenv("STYLED_DATA");
    const std::filesystem::path folder = set != nullptr ? set : STYLED_DATA_DEFAULT;
    std::ifstream file(folder / "packets" / name, std::ios::binary);
    return ToBytes(std::string(std::istreambuf_iterator<char>(file), {}));
  }
  void SetUp() override {
    if (Read("mocopi_sample_fram.bin").empty()) GTEST_SKIP() << "skipped, no data";
  }
};

TEST_F(RealPackets, AreNamedAsWhatTheyAre) {
  Sniffer sniffer;
  const auto say = [&](const std::string& name) {
    const Sniffed found = sniffer.Sniff(Read(name));
    return std::string(Row(found.format).word) + " " + Name(found.verdict) + ": " + found.kind;
  };
  EXPECT_EQ(say("mocopi_sample_fram.bin"), "mocopi pose: poses (fram)");
  EXPECT_EQ(say("mocopi_sample_skdf.bin"), "mocopi skeleton: skeleton (skdf)");
  EXPECT_EQ(say("mocapframe_packet_v3.bin"), "natnet useless: frames without a skeleton");
  EXPECT_EQ(say("serverinfo_packet_v3.bin"), "natnet talk: server of NatNet 3.0");
  EXPECT_EQ(say("modeldef_packet_v3.bin"), "natnet useless: model without a skeleton");
  EXPECT_EQ(say("mocapframe_packet_occluded_v3.bin"), "natnet useless: frames without a skeleton");
}

}  // namespace
}  // namespace styled::doctor
