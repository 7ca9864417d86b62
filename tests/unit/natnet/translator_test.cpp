#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <deque>

#include "daemon/source/rigs/natnet.h"
#include "model/base/descriptor.h"
#include "model/rig/dialects.h"
#include "tests/support/count_new.h"
#include "tests/support/translated.h"
#include "tests/unit/natnet/bytes.h"
#include "tests/unit/natnet/performer.h"

namespace styled::source {
namespace {

using namespace natnet::testing;
using natnet::MessageId;
using runtime::Counter;
using support::Translated;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// The frame on the canonical humanoid, against the pose that it was made of: the joint that is
// turned most, in radians, and the hips, in metres.
void ExpectPose(const v1::Body& body, const v1::SourceFrame& frame, const body::Pose& expected) {
  rig::Skeleton skeleton;
  for (int j = 0; j < body.names_size(); ++j) {
    skeleton.names.push_back(body.names(j));
    skeleton.parents.push_back(body.parents(j));
    skeleton.offsets.emplace_back(body.offsets(3 * j), body.offsets(3 * j + 1),
                                  body.offsets(3 * j + 2));
  }
  const auto binding = rig::BindDialect(skeleton, body.dialect());
  ASSERT_TRUE(binding.ok()) << binding.status().message();
  ASSERT_EQ(frame.rotations_size(), 4 * body.names_size());
  rig::RigPose source(skeleton);
  source.translations[0] = {frame.root_position(0), frame.root_position(1), frame.root_position(2)};
  for (int j = 0; j < body.names_size(); ++j) {
    source.rotations[static_cast<std::size_t>(j)] = {
        frame.rotations(4 * j + 3), frame.rotations(4 * j), frame.rotations(4 * j + 1),
        frame.rotations(4 * j + 2)};
  }
  body::Pose pose;
  binding.value().Bind(source, pose);
  EXPECT_LT((pose.hips_position_m - expected.hips_position_m).norm(), 1e-4F);
  for (std::size_t j = 0; j < expected.rotations.size(); ++j) {
    EXPECT_LT(pose.rotations[j].angularDistance(expected.rotations[j]), 2e-3F) << j;
  }
}

sockaddr_in Loopback(std::uint16_t port = 0) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

// The translator between a pipeline that remembers and a server that is only a socket: what is
// sent to it lies there at once.
class Fixture : public ::testing::Test, public Translated {
 protected:
  Fixture()
      : Translated(nullptr),
        server_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)),
        command_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address = Loopback();
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(server_.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    getsockname(server_.get(), reinterpret_cast<sockaddr*>(&address), &size);
    std::memcpy(&peer_.address, &address, sizeof address);
    peer_.address_size = size;
    Make({});
  }

  void Make(const std::function<void(config::Source&)>& change) {
    config::Source config;
    config.server = "127.0.0.1";
    if (change) change(config);
    in_addr group{};
    inet_pton(AF_INET, config.group.c_str(), &group);
    translator_.emplace(config, reinterpret_cast<const sockaddr_in&>(peer_.address), group);
  }

  void Tick() {
    outbox_.Open(*this, command_.get());
    translator_->Tick(now_ns, outbox_);
    outbox_.Close();
  }
  void Handle(const Bytes& packet) { Handle(packet, peer_); }
  void Handle(const Bytes& packet, const Peer& from) {
    outbox_.Open(*this, command_.get());
    {
      const support::CountNew count;
      translator_->Handle(packet, from, now_ns, outbox_);
      allocations_ = count.calls();
    }
    outbox_.Close();
  }
  void Pass(double seconds) {
    now_ns += static_cast<std::int64_t>(seconds * 1e9);
    Tick();
  }

  // Ids of what the server got since it was last looked at.
  std::vector<MessageId> Asked() {
    std::vector<MessageId> ids;
    Bytes buffer(1000);
    for (ssize_t size = 0; (size = recv(server_.get(), buffer.data(), buffer.size(), 0)) >= 0;) {
      natnet::Packet packet;
      EXPECT_EQ(
          natnet::DecodePacket(std::span(buffer).first(static_cast<std::size_t>(size)), packet),
          natnet::DecodeResult::kOk);
      if (packet.id == MessageId::kConnect) {
        natnet::Connect connect;
        natnet::DecodeConnect(packet.payload, connect);
        shapes_.push_back(connect.shape);
      }
      ids.push_back(packet.id);
    }
    return ids;
  }

  Bytes Info(bool multicast) const {
    natnet::ServerInfo info;
    info.name = "Motive";
    info.natnet = version_;
    info.connection = {1000, 1511, multicast, {239, 255, 42, 98}};
    Bytes out(400);
    out.resize(natnet::EncodeServerInfo(info, out));
    return out;
  }
  Bytes Model(const std::vector<std::string>& names) const {
    static natnet::Model model;
    model.skeleton_count = names.size();
    model.rigid_bodies_read = rigid_names_.size();
    std::copy(rigid_names_.begin(), rigid_names_.end(), model.rigid_bodies.begin());
    for (std::size_t k = 0; k < names.size(); ++k) {
      Describe(names[k], static_cast<std::int32_t>(k + 1), streaming_, model.skeletons[k]);
    }
    Bytes out(20000);
    out.resize(natnet::EncodeModel(model, version_, out));
    return out;
  }
  Bytes Frame(int skeletons = 1) {
    static natnet::Frame frame;
    frame.number = number_++;
    frame.timestamp_s = time_s_;
    time_s_ += 0.01;
    frame.params = params_;
    frame.timecode = timecode_;
    frame.skeleton_count = static_cast<std::size_t>(skeletons);
    frame.rigid_bodies_read = rigid_bodies_.size();
    std::copy(rigid_bodies_.begin(), rigid_bodies_.end(), frame.rigid_bodies.begin());
    for (int k = 0; k < skeletons; ++k) {
      Place(BentPose(0.1F * static_cast<float>(k)), k + 1, streaming_,
            frame.skeletons[static_cast<std::size_t>(k)]);
    }
    Bytes out(20000);
    out.resize(natnet::EncodeFrame(frame, version_, out));
    return out;
  }
  // Everything that leads to poses; nothing of it is kept.
  void Begin(const std::vector<std::string>& names = {"Anna"}) {
    Tick();
    Handle(Info(false));
    Handle(Model(names));
    Asked();
    items.clear();
  }

  Descriptor server_, command_;
  Peer peer_;
  runtime::Counters counters_;
  Outbox outbox_{0, counters_};
  std::optional<NatNet> translator_;
  natnet::Version version_{3, 0};
  Streaming streaming_;
  std::vector<natnet::RigidBodyDescription> rigid_names_;
  std::vector<natnet::Bone> rigid_bodies_;
  int number_ = 1000;
  double time_s_ = 50;
  std::uint16_t params_ = 0;
  std::uint32_t timecode_ = 0;
  int allocations_ = 0;
  std::vector<natnet::Connect::Shape> shapes_;
};
using NatNetDialogue = Fixture;
using NatNetFrames = Fixture;
using Ids = std::vector<MessageId>;

// In a volume that is +Z up, too.
TEST_F(NatNetFrames, HaveTheRigidBodiesThatAreTrackedAndBelongToNoSkeleton) {
  rigid_names_ = {{"sword", 101, -1}, {"chair", 102, 0}, {"bone", 103, 2}, {"lost", 104, -1}};
  const auto body = [](std::int32_t id, bool tracked = true) {
    return natnet::Bone{id, {1, 2, 3}, {0.5F, 0.1F, -0.7F, 0.5F}, tracked};
  };
  rigid_bodies_ = {body(101), body(102), body(103), body(104, false), body(1 << 16 | 3), body(999)};
  for (const bool z_up : {false, true}) {
    Make([z_up](config::Source& config) { config.up = z_up ? "z" : "y"; });
    streaming_ = {false, z_up, z_up};
    Begin({"Anna", "Bert"});
    Handle(Frame(2));
    Handle(Frame(2));
    EXPECT_EQ(allocations_, 0);
    const auto frames = Frames();
    ASSERT_EQ(frames.size(), 4U);
    for (const v1::SourceFrame& frame : frames) {
      ASSERT_EQ(frame.props_size(), 2);
      EXPECT_EQ(frame.props(0).name(), "sword");
      EXPECT_EQ(frame.props(1).name(), "chair");
      const std::vector<float> p(frame.props(0).position().begin(),
                                 frame.props(0).position().end());
      const std::vector<float> q(frame.props(0).rotation().begin(),
                                 frame.props(0).rotation().end());
      EXPECT_EQ(p, (z_up ? std::vector<float>{1, 3, -2} : std::vector<float>{1, 2, 3}));
      EXPECT_EQ(q, (z_up ? std::vector<float>{0.5F, -0.7F, -0.1F, 0.5F}
                         : std::vector<float>{0.5F, 0.1F, -0.7F, 0.5F}));
    }
  }
  rigid_bodies_.clear();
  Handle(Frame(1));
  EXPECT_EQ(Frames().back().props_size(), 0) << "gone";
}

TEST_F(NatNetFrames, HaveSixteenPropsAtMost) {
  std::vector<std::string> names;
  for (int i = 0; i < 20; ++i) names.push_back("p" + std::to_string(i));
  for (int i = 0; i < 20; ++i) {
    rigid_names_.push_back({names[static_cast<std::size_t>(i)], 101 + i, -1});
    rigid_bodies_.push_back({101 + i, {0, 0, 0}, {0, 0, 0, 1}, true});
  }
  Begin();
  Handle(Frame());
  ASSERT_EQ(Frames().size(), 1U);
  EXPECT_EQ(Frames()[0].props_size(), 16);
  EXPECT_EQ(counters_.Get(Counter::kPipelinePropsLeftOut), 4U);
}

TEST_F(NatNetDialogue, AsksWhoIsThereOnceASecondInBothShapesWhileNobodyAnswers) {
  Tick();
  EXPECT_EQ(Asked(), Ids{MessageId::kConnect});
  EXPECT_EQ(translator_->NextDeadline_ns(), now_ns + kSecond_ns);
  Pass(0.9);
  EXPECT_EQ(Asked(), Ids{});
  Pass(0.1);
  Pass(1);
  EXPECT_EQ(Asked(), (Ids{MessageId::kConnect, MessageId::kConnect}));
  using Shape = natnet::Connect::Shape;
  EXPECT_EQ(shapes_, (std::vector{Shape::kRecord, Shape::kBitstream, Shape::kRecord}));
}

TEST_F(NatNetDialogue, AsksForTheModelWhenTheServerAnsweredAndAgainUntilItComes) {
  Tick();
  Asked();
  Handle(Info(true));
  EXPECT_EQ(Asked(), Ids{MessageId::kRequestModelDef});
  Pass(1);
  EXPECT_EQ(Asked(), Ids{MessageId::kRequestModelDef});
  Handle(Model({"Anna"}));
  Pass(0.5);
  Pass(1);
  EXPECT_EQ(Asked(), Ids{});
}

TEST_F(NatNetDialogue, KeepsAServerSendingThatStreamsToEachClient) {
  Begin();
  EXPECT_FALSE(translator_->stream());
  for (int i = 0; i < 3; ++i) {
    Handle(Frame());
    Pass(1);
  }
  EXPECT_EQ(Asked(), (Ids{3, MessageId::kKeepAlive}));
}

TEST_F(NatNetDialogue, GoesWhereTheServerStreamsTo) {
  Tick();
  EXPECT_FALSE(translator_->stream());
  Handle(Info(true));
  ASSERT_TRUE(translator_->stream());
  in_addr group{};
  inet_pton(AF_INET, "239.255.42.98", &group);
  EXPECT_EQ(*translator_->stream(), (NatNet::Stream{group, 1511}));
  Handle(Info(false));
  EXPECT_FALSE(translator_->stream());
}

TEST_F(NatNetDialogue, GoesWhereTheConfigSaysOfAServerThatDoesNotSay) {
  version_ = {2, 9};
  Make([](auto& config) { config.group = "239.255.42.97"; });
  Tick();
  Handle(Info(false));
  ASSERT_TRUE(translator_->stream());
  in_addr group{};
  inet_pton(AF_INET, "239.255.42.97", &group);
  EXPECT_EQ(*translator_->stream(), (NatNet::Stream{group, 1511}));
  Make([](auto& config) { config.multicast = false; });
  Tick();
  Handle(Info(false));
  EXPECT_FALSE(translator_->stream());
}

TEST_F(NatNetDialogue, AsksAgainWhoIsThereAfterTwoSecondsOfSilence) {
  Begin();
  Handle(Frame());
  Pass(1);
  EXPECT_EQ(Asked(), Ids{MessageId::kKeepAlive});
  Pass(1);
  EXPECT_EQ(Asked(), (Ids{MessageId::kConnect, MessageId::kKeepAlive}));
  Handle(Info(false));
  EXPECT_EQ(Asked(), Ids{MessageId::kRequestModelDef});
}

TEST_F(NatNetDialogue, AsksForTheModelAgainWhenItChangedOrLacksASkeletonButOnceASecondOnly) {
  Begin();
  Pass(1);
  Asked();
  Handle(Frame());
  EXPECT_EQ(Asked(), Ids{});
  params_ = natnet::kModelsChanged;
  Handle(Frame());
  Handle(Frame());
  params_ = 0;
  EXPECT_EQ(Asked(), Ids{MessageId::kRequestModelDef});
  Handle(Model({"Anna"}));
  Pass(1);
  Asked();
  Handle(Frame(2));
  Handle(Frame(2));
  EXPECT_EQ(Asked(), Ids{MessageId::kRequestModelDef});
  EXPECT_EQ(counters_.Get(Counter::kPipelineBeforeBody), 2U);
  Handle(Model({"Anna", "Bert"}));
  Pass(1);
  Asked();
  Handle(Frame(2));
  EXPECT_EQ(Asked(), Ids{});
}

TEST_F(NatNetDialogue, DoesNotAskForeverForASkeletonThatItCannotUse) {
  Begin();
  natnet::Model model;
  model.skeleton_count = 2;
  Describe("Anna", 1, {}, model.skeletons[0]);
  Describe("Bert", 2, {}, model.skeletons[1]);
  model.skeletons[1].bones[5].parent = 77;
  Bytes packet(20000);
  packet.resize(natnet::EncodeModel(model, version_, packet));
  Handle(packet);
  EXPECT_EQ(counters_.Get(Counter::kPipelineBodiesRefused), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0], "skeleton Bert: 4 of 21 bones are not below one root bone");
  Handle(packet);
  EXPECT_EQ(notes.size(), 1U) << "said once";
  Pass(1);
  Asked();
  Handle(Frame(2));
  EXPECT_EQ(Asked(), Ids{});
  EXPECT_EQ(Frames().size(), 1U);
}

TEST_F(NatNetDialogue, AsksWhoIsThereWhenTheBitstreamChangedOrIsNotWhatItWas) {
  Begin();
  params_ = natnet::kBitstreamChanged;
  Handle(Frame());
  EXPECT_EQ(Asked(), Ids{MessageId::kConnect});
  params_ = 0;
  version_ = {4, 1};
  for (int i = 0; i < 10; ++i) Handle(Frame());
  EXPECT_EQ(Asked(), Ids{MessageId::kConnect});
  EXPECT_EQ(counters_.Get(Counter::kSourceMalformed), 10U);
  Handle(Info(false));
  items.clear();
  Handle(Frame());
  EXPECT_EQ(Frames().size(), 1U);
}

TEST_F(NatNetDialogue, RefusesAServerThatIsTooOldAndSaysSo) {
  version_ = {2, 6};
  Tick();
  Handle(Info(false));
  EXPECT_EQ(counters_.Get(Counter::kSourceBadVersion), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0], "server 127.0.0.1 speaks NatNet 2.6, expected 2.7 or later");
  Asked();
  Pass(1);
  EXPECT_EQ(Asked(), Ids{MessageId::kConnect});
}

TEST_F(NatNetDialogue, TellsOfAServerWithoutSkeletons) {
  Begin({});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0],
            "server 127.0.0.1 streams no skeleton: enable them in its streaming settings");
  Pass(3);
  Begin({});
  EXPECT_EQ(notes.size(), 2U) << "again, when it is back";
  Pass(3);
  Begin({});
  EXPECT_EQ(notes.size(), 2U) << "once a minute";
  Pass(60);
  Begin({});
  EXPECT_EQ(notes.size(), 3U);
}

TEST_F(NatNetDialogue, HearsNobodyButTheServer) {
  Tick();
  Peer stranger = peer_;
  reinterpret_cast<sockaddr_in&>(stranger.address).sin_addr.s_addr = htonl(0x7F000002);
  Handle(Info(true), stranger);
  EXPECT_FALSE(translator_->stream());
  EXPECT_EQ(counters_.Get(Counter::kSourceIgnored), 1U);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0], "ignoring packets that do not come from server 127.0.0.1");
  reinterpret_cast<sockaddr_in&>(stranger.address) = Loopback(1511);
  Handle(Info(true), stranger);
  EXPECT_TRUE(translator_->stream()) << "any port of the server's";
}

TEST_F(NatNetDialogue, CountsWhatItCannotReadAndWhatItHasNoUseFor) {
  Handle(Frame());
  Handle(Model({"Anna"}));
  EXPECT_EQ(counters_.Get(Counter::kSourceIgnored), 2U) << "before the version is known";
  Begin();
  Handle(Bytes(3));
  Handle(Join(I16{1}, I16{4}, Any{4}));
  Handle(Join(I16{5}, I16{4}, I32{-1}));
  Handle(Join(I16{7}, I16{4}, I32{1}));
  for (const double wrong : {-1.0, 1e300, std::nan("")}) {
    time_s_ = wrong;
    Handle(Frame());
  }
  EXPECT_EQ(counters_.Get(Counter::kSourceMalformed), 7U);
  Handle(Join(I16{100}, I16{4}, Any{4}));
  Handle(Join(I16{8}, I16{3}, Text{"hi"}));
  EXPECT_EQ(counters_.Get(Counter::kSourceIgnored), 4U);
  EXPECT_TRUE(items.empty());
}

TEST_F(NatNetFrames, BecomeTheCanonicalPoseInEveryBitstreamAndConvention) {
  for (const natnet::Version version :
       {natnet::Version{2, 7}, {2, 9}, {3, 0}, {3, 1}, {4, 0}, {4, 1}, {4, 2}}) {
    for (int way = 0; way < 8; ++way) {
      version_ = version;
      streaming_ = {(way & 1) != 0, (way & 2) != 0, (way & 4) != 0};
      Make({});
      Begin();
      Handle(Frame());
      SCOPED_TRACE(std::to_string(version.major) + "." + std::to_string(version.minor) + ", way " +
                   std::to_string(way));
      ASSERT_EQ(Frames().size(), 1U);
      ASSERT_EQ(Bodies().size(), 1U);
      EXPECT_EQ(Bodies()[0].performer(), "Anna");
      ExpectPose(Bodies()[0], Frames()[0], BentPose());
    }
  }
}

TEST_F(NatNetFrames, OfSeveralSkeletonsAreOfAsManyPerformersWhoseNamesDiffer) {
  Begin({"Anna B", "Anna_B", "Anna B"});
  Handle(Frame(3));
  const auto frames = Frames();
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].performer(), "Anna_B");
  EXPECT_EQ(frames[1].performer(), "Anna_B-2");
  EXPECT_EQ(frames[2].performer(), "Anna_B-3");
  EXPECT_NEAR(frames[2].root_position(0), BentPose(0.2F).hips_position_m.x(), 1e-6F);
}

TEST_F(NatNetFrames, CarryTheServersTimeAndTimecode) {
  Begin();
  timecode_ = 0x0A173B11;
  Handle(Frame());
  timecode_ = 0;
  Handle(Frame());
  const auto frames = Frames();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].source_time_ns(), 50'000'000'000U);
  EXPECT_EQ(frames[1].source_time_ns(), 50'010'000'000U);
  EXPECT_EQ(frames[0].timecode().hours(), 10U);
  EXPECT_EQ(frames[0].timecode().minutes(), 23U);
  EXPECT_EQ(frames[0].timecode().seconds(), 59U);
  EXPECT_EQ(frames[0].timecode().frames(), 17U);
}

TEST_F(NatNetFrames, ThatCameBeforeOrWereOvertakenAreLeftOut) {
  Begin();
  const Bytes first = Frame(), second = Frame();
  Handle(first);
  Handle(second);
  Handle(second);
  Handle(first);
  EXPECT_EQ(Frames().size(), 2U);
  EXPECT_EQ(counters_.Get(Counter::kPipelineDuplicate), 1U);
  EXPECT_EQ(counters_.Get(Counter::kPipelineReordered), 1U);
}

TEST_F(NatNetFrames, ThatBeginAgainAreAnotherSession) {
  Begin();
  Handle(Frame());
  number_ = 1;
  time_s_ = 0;
  Handle(Frame());
  ASSERT_EQ(Frames().size(), 2U);
  EXPECT_NE(items.front().session, items.back().session);
  EXPECT_EQ(Bodies().size(), 2U);
}

// Our sequence leaves room for the frames that were lost.
std::uint64_t LostBetween(const Translated::Item& a, const Translated::Item& b) {
  return b.sequence - a.sequence - 1;
}

TEST_F(NatNetFrames, ThatAreMissingAreTold) {
  Begin();
  Handle(Frame());
  Handle(Frame());
  number_ += 3;
  Handle(Frame());
  EXPECT_EQ(LostBetween(items[items.size() - 3], items[items.size() - 2]), 0U);
  EXPECT_EQ(LostBetween(items[items.size() - 2], items[items.size() - 1]), 3U);
}

TEST_F(NatNetFrames, OfWhichEverySecondOneIsSentAreNotMissed) {
  Begin();
  for (int i = 0; i < 5; ++i) {
    Handle(Frame());
    ++number_;
  }
  EXPECT_EQ(LostBetween(items[items.size() - 2], items.back()), 0U);
  number_ += 2;
  Handle(Frame());
  EXPECT_EQ(LostBetween(items[items.size() - 2], items.back()), 1U);
  // A server that sends every third one from now on.
  for (int i = 0; i < 40; ++i) {
    Handle(Frame());
    number_ += 2;
  }
  EXPECT_EQ(LostBetween(items[items.size() - 2], items.back()), 0U);
}

TEST_F(NatNetFrames, AreBoundToAnotherBodyWhenTheModelChangesAndToTheSameWhenNot) {
  Begin();
  Handle(Frame());
  Handle(Model({"Anna"}));
  Handle(Frame());
  EXPECT_EQ(Bodies().size(), 1U);
  EXPECT_EQ(items.front().session, items.back().session);
  natnet::Model model;
  model.skeleton_count = 1;
  Describe("Anna", 1, {}, model.skeletons[0]);
  model.skeletons[0].bones[4].offset_m = {0, 0.125F, 0};
  Bytes packet(20000);
  packet.resize(natnet::EncodeModel(model, version_, packet));
  Handle(packet);
  Handle(Frame());
  ASSERT_EQ(Bodies().size(), 2U);
  EXPECT_EQ(Bodies()[1].offsets(13), 0.125F);
  EXPECT_EQ(items.front().session, items.back().session) << "the same performer";
}

TEST_F(NatNetFrames, AreReadAnotherWayAfterSomebodyChangedTheServersCoordinates) {
  Begin();
  Handle(Frame());
  streaming_.local = true;
  for (int i = 0; i < 12; ++i) Handle(Frame());
  ExpectPose(Bodies().front(), Frames().back(), BentPose());
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(notes[0], "server 127.0.0.1 now streams local coordinates, +Y up");
  EXPECT_NE(items.front().session, items.back().session);
}

TEST_F(NatNetFrames, AreReadAsTheConfigSaysWhateverFits) {
  Make([](auto& config) {
    config.coordinates = "local";
    config.up = "y";
  });
  Begin();
  Handle(Frame());
  const auto frames = Frames();
  ASSERT_EQ(frames.size(), 1U);
  // Global rotations taken for local ones: the chest's is the product of three.
  const body::Pose bent = BentPose();
  const rig::Quat world = bent.rotations[0] * bent.rotations[1] * bent.rotations[2];
  const auto& rotations = frames[0].rotations();
  const rig::Quat chest(rotations[11], rotations[8], rotations[9], rotations[10]);
  EXPECT_LT(chest.angularDistance(world), 1e-3F);
}

TEST_F(NatNetFrames, DoNotAllocateFromThePerformersSecondOn) {
  Begin({"Anna", "Bert"});
  EXPECT_GT(allocations_, 0) << "a model does";
  Handle(Frame(2));
  for (int i = 0; i < 300; ++i) {
    now_ns += 10'000'000;
    const Bytes frame = Frame(2);
    Handle(frame);
    EXPECT_EQ(allocations_, 0) << i;
  }
}

}  // namespace
}  // namespace styled::source
