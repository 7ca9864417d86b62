// Props, from a sender's bytes to every topic: a sword stays in the hand, a chair in the room.
#include "daemon/source/props.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>

#include "daemon/replay/replay.h"
#include "daemon/source/rigs/mvn.h"
#include "daemon/source/rigs/natnet.h"
#include "daemon/source/rigs/rokoko.h"
#include "daemon/styles/make_config.h"
#include "model/clip/glb_write.h"
#include "proto/recording/writer.h"
#include "proto/rigs/natnet/packet.h"
#include "sim/player/clip_motion.h"
#include "sim/player/stream.h"
#include "sim/rigs/rig.h"
#include "tests/support/fake_pipeline.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::source {
namespace {

using rig::Quat;
using rig::Vec3;
using runtime::Counter;

const std::string kWeights = STYLED_SOURCE_DIR "/model/weights/v2.safetensors";
const std::string kClip = STYLED_SOURCE_DIR "/tests/parity/fixtures/synthetic.bvh";
constexpr float kDegrees = 57.29578F;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

v1::Prop Message(const std::string& name, const std::vector<float>& position,
                 const std::vector<float>& rotation) {
  v1::Prop prop;
  prop.set_name(name);
  for (const float value : position) prop.add_position(value);
  for (const float value : rotation) prop.add_rotation(value);
  return prop;
}
v1::Prop Sword(float x = 0.5F) { return Message("sword", {x, 1.5F, -0.25F}, {0, 0.6F, 0, 0.8F}); }

template <typename T>
std::string Bytes(const T& message) {
  return message.SerializeAsString();
}

// Reads the props of a message, which contains nothing else.
PropList Read(const std::string& bytes) {
  PropList list;
  ReadProps(std::as_bytes(std::span(bytes)), list);
  return list;
}

TEST(Props, AreWrittenAsProtobufDoes) {
  for (const std::string& name :
       {std::string("sword"), std::string(kMaxPropName, 'x'), std::string("あ"), std::string()}) {
    const Prop prop{name, Vec3(1, -0.0F, 1e-9F), Quat(0.5F, -0.5F, 0.5F, 0.5F)};
    v1::SourceFrame message;
    *message.add_props() = Message(name, {1, -0.0F, 1e-9F}, {-0.5F, 0.5F, 0.5F, 0.5F});
    std::vector<std::byte> bytes(kMaxPropBytes);
    bytes.resize(EncodeProps(std::span(&prop, 1), bytes));
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
              Bytes(message));
  }
  // As many whole ones as fit.
  const Prop two[] = {{"a", Vec3::Zero(), Quat::Identity()}, {"b", Vec3::Zero(), Quat::Identity()}};
  std::array<std::byte, 100> small;
  const std::size_t one = EncodeProps(std::span(two, 1), small);
  EXPECT_EQ(EncodeProps(std::span(two), std::span(small).first(2 * one - 1)), one);
  EXPECT_EQ(EncodeProps(std::span(two), std::span(small).first(2 * one)), 2 * one);
}

TEST(Props, InvalidPropsAreLeftOutAndCounted) {
  const std::vector<float> p{1, 2, 3}, q{0, 0, 0, 1};
  const std::vector<std::pair<std::string, v1::Prop>> wrong{
      {"no name", Message("", p, q)},
      {"a name of 65 bytes", Message(std::string(65, 'x'), p, q)},
      {"a number too few", Message("a", {1, 2}, q)},
      {"no position", Message("a", {}, q)},
      {"a rotation of three", Message("a", p, {0, 0, 1})},
      {"not a number", Message("a", {1, kNan, 3}, q)},
      {"infinite", Message("a", {1, 2, std::numeric_limits<float>::infinity()}, q)},
      {"beyond any stage", Message("a", {1e30F, 2, 3}, q)},
      {"a rotation of no length", Message("a", p, {0, 0, 0, 0})},
      {"a rotation that is not a number", Message("a", p, {0, 0, kNan, 1})},
      {"a rotation that overflows", Message("a", p, {0, 0, 1e30F, 1})},
  };
  for (const auto& [why, prop] : wrong) {
    v1::SourceFrame frame;
    *frame.add_props() = Sword();
    *frame.add_props() = prop;
    *frame.add_props() = Message("chair", p, q);
    const std::string bytes = Bytes(frame);
    const PropList list = Read(bytes);
    ASSERT_EQ(list.count, 2U) << why;
    EXPECT_EQ(list.left_out, 1U) << why;
    EXPECT_EQ(list.props[1].name, "chair") << why;
  }
  v1::SourceFrame frame;
  for (int i = 0; i < 17; ++i) *frame.add_props() = Message("p" + std::to_string(i), p, q);
  std::string bytes = Bytes(frame);
  EXPECT_EQ(Read(bytes).count, 16U);
  EXPECT_EQ(Read(bytes).left_out, 1U) << "a seventeenth";
  frame.clear_props();
  *frame.add_props() = Sword(1);
  *frame.add_props() = Sword(2);
  bytes = Bytes(frame);
  ASSERT_EQ(Read(bytes).count, 1U) << "one name, one prop";
  EXPECT_EQ(Read(bytes).props[0].position.x(), 1) << "the first";
  // Names that are no text, and bytes that are no props; protobuf would refuse the whole frame.
  bytes[bytes.find("sword")] = '\xFF';
  EXPECT_EQ(Read(bytes).count, 1U);
  EXPECT_EQ(Read(bytes).left_out, 1U);
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);
    EXPECT_LE(Read(cut).count, 1U) << size;
  }
  // A length that is not 1 is made 1, as that of a joint; rounding is left as it is.
  frame.clear_props();
  *frame.add_props() = Message("a", p, {0, 0, 0, 2});
  *frame.add_props() = Message("b", p, {0, 0, 0, 1.0001F});
  bytes = Bytes(frame);
  EXPECT_EQ(Read(bytes).props[0].rotation.w(), 1);
  EXPECT_EQ(Read(bytes).props[1].rotation.w(), 1.0001F);
}

TEST(Props, TheirHandsAreReadFromTheConfiguration) {
  const auto parse = [](const std::string& props) {
    return config::Parse("[[source]]\nlisten = '127.0.0.1:0'\nprops = " + props + "\n", "x", {});
  };
  const auto config =
      parse("{ sword = 'right_hand', 'the torch' = 'left_hand', chair = 'none', bag = 'auto' }");
  ASSERT_TRUE(config.ok()) << config.status().message();
  EXPECT_EQ(config.value().sources[0].props, (config::PropHands{{"sword", rig::Hand::kRight},
                                                                {"the torch", rig::Hand::kLeft},
                                                                {"chair", rig::Hand::kNone},
                                                                {"bag", rig::Hand::kAuto}}));
  const auto complaint = [&](const std::string& props) { return parse(props).status().message(); };
  const std::string wrong = complaint("{ sword = 'righthand' }");
  for (const char* const part :
       {"x:3: source.props: \"sword\": expected one of \"right_hand\", \"left_hand\", \"none\", "
        "\"auto\", found ",
        "righthand"}) {
    EXPECT_NE(wrong.find(part), std::string::npos) << wrong;
  }
  EXPECT_NE(complaint("{ sword = 7 }").find("\"sword\": expected one of"), std::string::npos);
  EXPECT_NE(complaint("'sword'").find("expected a table of props and hands"), std::string::npos);
  EXPECT_NE(complaint("{ '' = 'none' }").find("1 to 64 bytes"), std::string::npos);
}

std::shared_ptr<pipeline::RuntimeConfig> RandomConfig() {
  auto config = std::make_shared<pipeline::RuntimeConfig>();
  config->network = erd::RandomStylizer(5, 1);
  return config;
}

// The frames of one topic; its place among those of a pose, in the order of publishing.
std::vector<v1::Frame> Every(const std::vector<v1::Frame>& all, std::size_t place,
                             std::size_t topics) {
  std::vector<v1::Frame> frames;
  for (std::size_t i = place; i < all.size(); i += topics) frames.push_back(all[i]);
  return frames;
}
constexpr std::size_t kRigTopic = 0, kCanonicalTopic = 1, kSourceTopic = 2, kAvatarTopic = 3;

TEST(Props, WithoutAStyleTheyLeaveBitForBit) {
  support::FakePipeline fake(RandomConfig(), "");
  support::Rig rig("a");
  const v1::Prop odd = Message("odd", {0.1F, 1.1F, -0.0F}, {0.1F, -0.7F, 0.7F, -0.1F});
  fake.Deliver({rig.Body()});
  for (int i = 0; i < 5; ++i) {
    fake.Deliver({rig.Frame([&](v1::SourceFrame& frame) {
      *frame.add_props() = Sword();
      *frame.add_props() = odd;
    })});
  }
  ASSERT_EQ(fake.publisher.frames.size(), 15U);
  for (const std::size_t topic : {kRigTopic, kSourceTopic}) {
    for (const v1::Frame& frame : Every(fake.publisher.frames, topic, 3)) {
      ASSERT_EQ(frame.props_size(), 2);
      EXPECT_EQ(Bytes(frame.props(0)), Bytes(Sword()));
      EXPECT_EQ(Bytes(frame.props(1)), Bytes(odd));
    }
  }
  EXPECT_EQ(fake.Count(Counter::kPipelinePropsLeftOut), 0U);
}

TEST(Props, PropsMayAppearAndVanishAndInvalidOnesHaveNoEffect) {
  support::FakePipeline fake(RandomConfig(), "source/");
  support::Rig rig("a");
  fake.Deliver({rig.Body()});
  const auto send = [&](const std::vector<v1::Prop>& props) {
    fake.publisher.frames.clear();
    fake.Deliver({rig.Frame([&](v1::SourceFrame& frame) {
      for (const v1::Prop& prop : props) *frame.add_props() = prop;
    })});
    EXPECT_EQ(fake.publisher.frames.size(), 1U);
    return fake.publisher.frames.empty() ? -1 : fake.publisher.frames[0].props_size();
  };
  EXPECT_EQ(send({Sword()}), 1);
  EXPECT_EQ(send({}), 0) << "not tracked";
  EXPECT_EQ(send({Sword(), Sword()}), 1);
  EXPECT_EQ(send({Message("x", {kNan, 0, 0}, {0, 0, 0, 1}), Sword()}), 1);
  EXPECT_EQ(send({Message("x", {0, 1e30F, 0}, {0, 0, 0, 1})}), 0);
  EXPECT_EQ(send({Message("x", {0, 0, 0}, {0, 0, 0, 0})}), 0);
  std::vector<v1::Prop> many;
  for (int i = 0; i < 17; ++i) {
    many.push_back(Message("p" + std::to_string(i), {0, 0, 0}, {0, 0, 0, 1}));
  }
  EXPECT_EQ(send(many), 16);
  EXPECT_EQ(fake.Count(Counter::kPipelinePropsLeftOut), 5U);
  EXPECT_EQ(fake.Count(Counter::kPipelineFrames), 7U) << "no frame was refused";
  // More than fits: what fits is passed on.
  many.assign(400, Sword());
  EXPECT_EQ(send(many), 1);
  EXPECT_EQ(fake.Count(Counter::kPipelineFrames), 8U);
  // The last pose again is sent with its props.
  fake.publisher.frames.clear();
  fake.Pass(400);
  ASSERT_EQ(fake.publisher.frames.size(), 1U);
  EXPECT_EQ(fake.publisher.frames[0].flags() & v1::FLAG_STALE, v1::FLAG_STALE);
  EXPECT_EQ(fake.publisher.frames[0].props_size(), 1);
}

// A sword beside Anna's right hand, on the rig of tests/support/rig.h.
TEST(Props, APropOfTheSceneBelongsToItsHolder) {
  struct Scene final : Receiver {
    explicit Scene(Receiver& receiver) : to(receiver) {}
    void OnFrames(int source, std::span<const SourceFrame> frames, bool more) override {
      std::vector<SourceFrame> shared(frames.begin(), frames.end());
      for (SourceFrame& frame : shared) frame.scene_props = true;
      to.OnFrames(source, shared, more);
    }
    void OnNote(int, const std::string&) override {}
    Receiver& to;
  };
  support::FakePipeline fake(RandomConfig(), "styled/");
  Scene scene(fake.pipeline());
  const auto deliver = [&](const std::vector<support::Bytes>& datagrams) {
    const std::vector<std::span<const std::byte>> spans(datagrams.begin(), datagrams.end());
    support::HandOn(spans, {}, fake.counters, scene);
    fake.Work();
  };
  support::Rig anna("anna"), bert("bert");
  const auto frame = [](support::Rig& rig, float apart_m, const Vec3& sword) {
    return rig.Frame([&](v1::SourceFrame& out) {
      out.set_root_position(0, out.root_position(0) + apart_m);
      *out.add_props() = Message("sword", {sword.x(), sword.y(), sword.z()}, {0, 0, 0, 1});
      *out.add_props() = Message("chair", {20, 0, 20}, {0, 0, 0, 1});
    });
  };
  deliver({anna.Body(), bert.Body()});
  // Their right hands hang near the thighs.
  const Vec3 at_hand(-0.3F, 0.75F, 0);
  for (const bool held : {true, false}) {
    fake.publisher.frames.clear();
    const Vec3 sword = held ? at_hand : Vec3(-0.3F, 3, 0);
    deliver({frame(anna, 0, sword), frame(bert, 3, sword)});
    ASSERT_EQ(fake.publisher.frames.size(), 4U);  // of each: rig, canonical
    for (const v1::Frame& out : fake.publisher.frames) {
      const bool has_sword = out.performer() == "rig.anna" || !held;
      EXPECT_EQ(out.props_size(), has_sword ? 2 : 1) << out.performer();
    }
  }
}

// A stand-in, its translator and the pipeline, without sockets.
class Staged final : Receiver {
 public:
  Staged(const std::string& type, const std::vector<std::string>& quirks,
         std::vector<player::PropSpec> props)
      : specs_(props), fake_(RandomConfig(), "styled/suit/") {
    config::Source config;
    config.name = "rig";
    config.type = type;
    config.server = "127.0.0.1";
    translator_ = type == "natnet" ? MakeNatNet(config)
                  : type == "mvn"  ? MakeMvn(config)
                                   : MakeRokoko(config);
    auto made = rigs::Make(type, {{"anna"}, 60, 1, quirks, std::move(props)});
    EXPECT_TRUE(made.ok()) << made.status().message();
    rig_ = std::move(made.value());
    auto& server = reinterpret_cast<sockaddr_in&>(peer_.address);
    server.sin_family = AF_INET;
    server.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    peer_.address_size = sizeof server;
    fake_.publisher.events.push_back({true, "styled/rig.anna/canonical/"});
    fake_.Work();
    // A client of NatNet asks who is there, and for the model.
    if (type != "natnet") return;
    for (const auto id : {natnet::MessageId::kConnect, natnet::MessageId::kRequestModelDef}) {
      std::array<std::byte, natnet::kHeaderSize> bytes;
      EXPECT_EQ(natnet::EncodePacket({id, {}}, bytes), bytes.size());
      rig_->Receive(bytes, [this](std::span<const std::byte> reply) { Accept(reply); });
    }
  }

  // Sends a pose; returns the canonical frame that leaves, if one does.
  std::optional<v1::Frame> Send(const body::Pose& pose) {
    fake_.publisher.frames.clear();
    std::vector<std::optional<rig::Placed>> props;
    for (const auto& spec : specs_) props.push_back(player::PlaceOf(spec, rig::WristsOf(pose)));
    rig_->Encode({index_, static_cast<double>(index_) / 60, {&pose, 1}, {&pose, 1}, props},
                 [this](std::span<const std::byte> datagram) { Accept(datagram); });
    ++index_;
    fake_.Work();
    fake_.clock.now_ns += 16'666'667;
    if (fake_.publisher.frames.empty()) return {};
    return fake_.publisher.frames.back();
  }

 private:
  void Accept(std::span<const std::byte> datagram) {
    outbox_.Open(*this, -1);
    translator_->Handle(datagram, peer_, fake_.clock.now_ns, outbox_);
    outbox_.Close();
  }
  void OnFrames(int source, std::span<const SourceFrame> frames, bool more) override {
    fake_.pipeline().OnFrames(source, frames, more);
  }
  void OnNote(int, const std::string&) override {}

  std::vector<player::PropSpec> specs_;
  support::FakePipeline fake_;
  Outbox outbox_{0, fake_.counters};
  Peer peer_;
  std::unique_ptr<Translator> translator_;
  std::unique_ptr<rigs::Rig> rig_;
  std::uint64_t index_ = 0;
};

// Through each rig's own bytes, units and axes, to metres and +Y up.
TEST(Props, PropsOfEveryRigArriveAtTheirPlaces) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> rigs{
      {"mvn", {}},         {"mvn", {"euler"}}, {"mvn", {"split"}},   {"rokoko", {}},
      {"rokoko", {"lz4"}}, {"natnet", {}},     {"natnet", {"z-up"}}, {"natnet", {"local"}},
      {"natnet", {"2.9"}}, {"natnet", {"4.2"}}};
  for (const auto& [type, quirks] : rigs) {
    SCOPED_TRACE(type + (quirks.empty() ? "" : " " + quirks[0]));
    const std::vector<player::PropSpec> specs{player::ParseProp("sword=right_hand").value(),
                                              player::ParseProp("chair=1,0,2").value()};
    Staged staged(type, quirks, specs);
    int frames = 0;
    for (int i = 0; i < 60; ++i) {
      body::Pose pose;
      const float angle = 1.2F - 0.03F * static_cast<float>(i);
      pose.hips_position_m += Vec3(0.1F, 0, 0.01F * static_cast<float>(i));
      pose.rotations[body::kRightUpperArm] = Quat(Eigen::AngleAxisf(angle, Vec3::UnitZ()));
      pose.rotations[body::kRightLowerArm] = Quat(Eigen::AngleAxisf(0.4F, Vec3::UnitY()));
      pose.rotations[body::kRightHand] = Quat(Eigen::AngleAxisf(0.5F, Vec3::UnitX()));
      const auto frame = staged.Send(pose);
      if (!frame) continue;
      ++frames;
      ASSERT_EQ(frame->props_size(), 2);
      for (int p = 0; p < 2; ++p) {
        const auto expected =
            player::PlaceOf(specs[static_cast<std::size_t>(p)], rig::WristsOf(pose));
        const auto& q = frame->props(p).rotation();
        const auto& at = frame->props(p).position();
        EXPECT_LT((Vec3(at[0], at[1], at[2]) - expected->position_m).norm(), 0.002F) << p;
        EXPECT_LT(Quat(q[3], q[0], q[1], q[2]).angularDistance(expected->rotation), 0.01F) << p;
      }
    }
    EXPECT_GE(frames, 57);
  }
}

// The world poses of a body's joints, by plain forward kinematics.
struct At {
  Vec3 position;
  Quat rotation;
};
At JointOf(const v1::Frame& frame, const rig::Skeleton& skeleton, int joint) {
  const auto local = [&frame](int j) {
    const float* q = frame.rotations().data() + 4 * j;
    return Quat(q[3], q[0], q[1], q[2]);
  };
  const int parent = skeleton.parents[static_cast<std::size_t>(joint)];
  if (parent < 0) {
    const auto& p = frame.root_position();
    return {{p[0], p[1], p[2]}, local(joint)};
  }
  const At above = JointOf(frame, skeleton, parent);
  return {above.position + above.rotation * skeleton.offsets[static_cast<std::size_t>(joint)],
          above.rotation * local(joint)};
}
At PropOf(const v1::Frame& frame, int prop) {
  const auto& p = frame.props(prop).position();
  const auto& q = frame.props(prop).rotation();
  return {{p[0], p[1], p[2]}, {q[3], q[0], q[1], q[2]}};
}
// The prop against the hand.
At Against(const At& hand, const At& prop) {
  const Quat inverse = hand.rotation.conjugate();
  return {inverse * (prop.position - hand.position), inverse * prop.rotation};
}

struct Drift {
  float cm = 0, degrees = 0;
};
// How far the prop strays from its first pose against the hand.
Drift DriftOf(const std::vector<v1::Frame>& frames, const rig::Skeleton& skeleton, int hand,
              float metres_per_unit) {
  Drift worst;
  const At first = Against(JointOf(frames.front(), skeleton, hand), PropOf(frames.front(), 0));
  for (const v1::Frame& frame : frames) {
    const At now = Against(JointOf(frame, skeleton, hand), PropOf(frame, 0));
    const float metres = (now.position - first.position).norm() * metres_per_unit;
    worst.cm = std::max(worst.cm, 100 * metres);
    worst.degrees =
        std::max(worst.degrees, kDegrees * now.rotation.angularDistance(first.rotation));
  }
  return worst;
}

// The canonical humanoid, half as tall again and with longer arms.
rig::Skeleton Giant() {
  rig::Skeleton skeleton;
  for (const auto& row : body::kHumanoid) {
    skeleton.names.emplace_back(row.name);
    skeleton.parents.push_back(row.parent);
    const bool arm = row.name.ends_with("LowerArm") || row.name.ends_with("Hand");
    skeleton.offsets.emplace_back(Vec3(row.x_m, row.y_m, row.z_m) * (arm ? 1.8F : 1.5F));
  }
  return skeleton;
}

rig::Skeleton Canonical() {
  rig::Skeleton skeleton = Giant();
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    skeleton.offsets[j] = body::Offset(static_cast<int>(j));
  }
  return skeleton;
}

int Find(const rig::Skeleton& skeleton, const std::vector<std::string>& names) {
  for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
    if (std::find(names.begin(), names.end(), skeleton.names[j]) != names.end()) {
      return static_cast<int>(j);
    }
  }
  ADD_FAILURE() << "no hand";
  return 0;
}

// The datagrams of the clip with a sword in the right hand and a chair far off.
struct Take {
  std::vector<support::Bytes> datagrams;
  rig::Skeleton skeleton;
  static constexpr double kRate_hz = 60;
};
Take Play(const std::vector<std::string>& props) {
  struct Collector final : player::Link {
    Status Send(std::span<const std::byte> datagram) override {
      datagrams.emplace_back(datagram.begin(), datagram.end());
      return Status::Ok();
    }
    std::vector<support::Bytes> datagrams;
  };
  Take take;
  auto motion = player::ClipMotion::Make({kClip}, {.rate_hz = Take::kRate_hz});
  EXPECT_TRUE(motion.ok()) << motion.status().message();
  take.skeleton = motion.value()->body().skeleton;
  player::StreamOptions options{"sim", Take::kRate_hz, [] { return std::uint64_t{7}; }, {}, {}};
  for (const std::string& text : props) {
    options.props.push_back(player::ParseProp(text).value());
  }
  player::Stream stream(options, std::move(motion.value()), faults::Faults(faults::Spec()));
  Collector link;
  while (stream.Tick(link) == player::Sender::Step::kSent) {
  }
  take.datagrams = std::move(link.datagrams);
  return take;
}

v1::Request Elderly(bool stride) {
  v1::Request request;
  request.set_performer("*");
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style("elderly");
  mix.set_weight(1);
  request.mutable_set()->set_strength(1);
  request.mutable_set()->set_transition_ms(0);
  if (stride) request.mutable_set()->set_root(v1::ROOT_STRIDE);
  return request;
}

class PropsOfAClip : public testing::Test {
 protected:
  // Plays the take in the style; the frames of rig, canonical, source and avatar in turn.
  std::vector<v1::Frame> Styled(const Take& take, const config::PropHands& hands, float smooth_hz,
                                bool stride) {
    config::Config config;
    config.model.weights = kWeights;
    config.model.examples = "none";
    config.sources[0].props = hands;
    config.sources[0].smoothing.rest_hz = smooth_hz;
    clip::Motion giant;
    giant.skeleton = Giant();
    giant.metres_per_unit = 1;
    giant.times_s = {0};
    giant.frames = {rig::RigPose(giant.skeleton)};
    const std::string file = folder_ / ("giant" + std::to_string(++made_) + ".glb");
    EXPECT_TRUE(clip::WriteGlb(giant, file).ok());
    config.outputs = {{.name = "giant", .avatar = file, .place = "test"}};
    std::uint32_t crc = 0;
    auto made = pipeline::MakeRuntimeConfig(config, nullptr, crc);
    EXPECT_TRUE(made.ok()) << made.status().message();
    if (!made.ok()) return {};
    support::FakePipeline fake(made.value(), "");
    for (std::size_t i = 0; i < take.datagrams.size(); ++i) {
      fake.Deliver({take.datagrams[i]});
      if (i == 0) {
        EXPECT_EQ(fake.Ask(Elderly(stride)).code(), v1::CODE_OK);
      }
      fake.clock.now_ns += static_cast<std::int64_t>(1e9 / Take::kRate_hz);
    }
    EXPECT_EQ(fake.Count(Counter::kPipelinePropsLeftOut), 0U);
    EXPECT_EQ(fake.Count(Counter::kStylistFailed), 0U);
    return fake.publisher.frames;
  }
  support::TemporaryFolder folder_;
  int made_ = 0;
};

TEST_F(PropsOfAClip, AHeldSwordStaysInTheStyledHandAndAChairWhereItStands) {
  const Take take = Play({"sword=right_hand", "chair=20,0,20"});
  const int hand = Find(take.skeleton, {"rightHand"});
  constexpr int kHand = body::kRightHand;
  for (const bool named : {false, true}) {
    const config::PropHands hands =
        named ? config::PropHands{{"sword", rig::Hand::kRight}} : config::PropHands{};
    // Once on the way of the performer, once on the style's own, far from what was captured.
    const auto all = Styled(take, hands, 0, named);
    ASSERT_GT(all.size(), 4U * 200);
    const auto on_rig = Every(all, kRigTopic, 4), canonical = Every(all, kCanonicalTopic, 4),
               source = Every(all, kSourceTopic, 4), avatar = Every(all, kAvatarTopic, 4);
    ASSERT_EQ(avatar.front().output(), v1::OUTPUT_AVATAR);
    for (const auto& [what, drift] :
         {std::pair{"rig", DriftOf(on_rig, take.skeleton, hand, 0.01F)},
          std::pair{"canonical", DriftOf(canonical, Canonical(), kHand, 1)},
          std::pair{"avatar", DriftOf(avatar, Giant(), kHand, 1)}}) {
      std::cout << (named ? "named, " : "auto, ") << what << ": strays " << drift.cm << " cm, "
                << drift.degrees << " degrees\n";
      EXPECT_LT(drift.cm, 1) << what;
      EXPECT_LT(drift.degrees, 1) << what;
    }
    // The result of the simplest method, the captured pose.
    float worst_cm = 0, mean_cm = 0;
    for (std::size_t i = 0; i < source.size(); ++i) {
      // Centimetres are the clip's unit.
      const float off = (PropOf(source[i], 0).position - PropOf(on_rig[i], 0).position).norm();
      worst_cm = std::max(worst_cm, off);
      mean_cm += off / static_cast<float>(source.size());
    }
    std::cout << (named ? "stride, " : "") << "left where it was captured it would be " << mean_cm
              << " cm off, at most " << worst_cm << " cm\n";
    EXPECT_GT(mean_cm, 3) << "the style moves the hand: the test can fail";
    for (std::size_t i = 0; i < source.size(); ++i) {
      ASSERT_EQ(source[i].props_size(), 2);
      EXPECT_EQ(Bytes(on_rig[i].props(1)), Bytes(source[i].props(1)));
      EXPECT_LT((PropOf(canonical[i], 1).position - Vec3(20, 0, 20)).norm(), 1e-3F);
      EXPECT_LT((PropOf(avatar[i], 1).position - Vec3(30, 0, 30)).norm(), 2e-3F);
    }
    EXPECT_NEAR(
        Against(JointOf(canonical[9], Canonical(), kHand), PropOf(canonical[9], 0)).position.norm(),
        0.1F, 1e-3F);
    EXPECT_NEAR(Against(JointOf(avatar[9], Giant(), kHand), PropOf(avatar[9], 0)).position.norm(),
                0.15F, 2e-3F)
        << "as far from the giant's wrist as they are larger";
  }
}

// The filter makes the hand late: a sword that is not would lead it.
TEST_F(PropsOfAClip, AHeldSwordFollowsAFilteredHand) {
  const Take take = Play({"sword=right_hand"});
  const int hand = Find(take.skeleton, {"rightHand"});
  const auto all = Styled(take, {}, 1, false);
  for (const std::size_t topic : {kRigTopic, kSourceTopic}) {
    const Drift drift = DriftOf(Every(all, topic, 4), take.skeleton, hand, 0.01F);
    EXPECT_LT(drift.cm, 1) << topic;
    EXPECT_LT(drift.degrees, 1) << topic;
  }
}

TEST_F(PropsOfAClip, AnObjectThatNoHandHoldsStaysThoughItIsNearOne) {
  const Take take = Play({"sword=right_hand"});
  const auto all = Styled(take, {{"sword", rig::Hand::kNone}}, 0, true);
  const auto on_rig = Every(all, kRigTopic, 4), source = Every(all, kSourceTopic, 4);
  for (std::size_t i = 0; i < source.size(); ++i) {
    ASSERT_EQ(Bytes(on_rig[i].props(0)), Bytes(source[i].props(0)));
  }
}

TEST_F(PropsOfAClip, ARecordingWithPropsPlaysTheSame) {
  const Take take = Play({"sword=right_hand", "chair=20,0,20"});
  const std::string file = folder_ / "take.styrec";
  {
    recording::FileHeader header = recording::BeginningNow("test", "0");
    header.set_config("[[source]]\nname = 'rig'\nlisten = '127.0.0.1:0'\n");
    auto writer = recording::FileWriter::Create(file, header);
    ASSERT_TRUE(writer.ok()) << writer.status().message();
    std::int64_t now_ns = 1'000'000'000;
    for (const support::Bytes& datagram : take.datagrams) {
      recording::Record record;
      record.set_time_ns(now_ns);
      auto& arrival = *record.mutable_arrival();
      arrival.set_source("rig");
      arrival.set_type("udp");
      arrival.set_peer("127.0.0.1:5000");
      arrival.set_datagram(
          std::string(reinterpret_cast<const char*>(datagram.data()), datagram.size()));
      ASSERT_TRUE(writer.value()->Add(record, now_ns).ok());
      now_ns += static_cast<std::int64_t>(1e9 / Take::kRate_hz);
    }
  }
  std::vector<v1::Frame> played[2];
  for (auto& frames : played) {
    auto reader = recording::Reader::Open(file);
    ASSERT_TRUE(reader.ok());
    const auto config =
        replay::ConfigOf(*reader.value(), {{"model.weights", "'" + kWeights + "'", "test"},
                                           {"model.examples", "'none'", "test"},
                                           {"style.initial", "'elderly'", "test"}});
    ASSERT_TRUE(config.ok()) << config.status().message();
    std::uint32_t crc = 0;
    const auto made = pipeline::MakeRuntimeConfig(config.value(), nullptr, crc);
    ASSERT_TRUE(made.ok()) << made.status().message();
    runtime::Counters counters;
    const Status status = replay::Replay(
        *reader.value(), config.value(), made.value(), {"styled/rig.sim/rig/", true, {}}, counters,
        [&](std::int64_t, std::string_view topic, std::span<const std::byte> payload) {
          if (!topic.ends_with("/rig/")) return;
          frames.emplace_back().ParseFromArray(payload.data(), static_cast<int>(payload.size()));
        });
    ASSERT_TRUE(status.ok()) << status.message();
  }
  ASSERT_GT(played[0].size(), 200U);
  ASSERT_EQ(played[0].size(), played[1].size());
  for (std::size_t i = 0; i < played[0].size(); ++i) {
    ASSERT_EQ(played[0][i].props_size(), 2);
    for (int p = 0; p < 2; ++p) {
      EXPECT_EQ(Bytes(played[0][i].props(p)), Bytes(played[1][i].props(p)));
    }
  }
  const int hand = Find(take.skeleton, {"rightHand"});
  EXPECT_LT(DriftOf(played[0], take.skeleton, hand, 0.01F).cm, 1);
}

}  // namespace
}  // namespace styled::source
