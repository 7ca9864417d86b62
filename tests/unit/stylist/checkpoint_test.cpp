// A stylist that reads another's checkpoint continues like that one, bit for bit, at any moment and
// after any input of its own.
#include "model/base/checkpoint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "model/base/checkpoint_bytes.h"
#include "model/feet/legs.h"
#include "model/net/load.h"
#include "model/net/several.h"
#include "model/stylist/avatar.h"
#include "model/stylist/stylist.h"
#include "model/synthetic/performer.h"
#include "tests/unit/net/erd/random_weights.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"
#include "tests/unit/rig/rigs.h"

namespace styled::stylist {
namespace {

constexpr int kShowFrames = 420;

std::vector<std::byte> Bytes(auto& of) {
  return CheckpointBytes([&of](Checkpoint& c) { of.Carry(c); });
}

bool Read(auto& into, std::span<const std::byte> bytes) {
  Checkpoint c = Checkpoint::From(bytes);
  into.Carry(c);
  return c.complete();
}

struct Moment {
  std::int64_t time_ns = 0;
  rig::RigPose pose;
};

// Everything that a stylist remembers is made to matter: walks, runs and gestures, at 120 Hz and
// then at 50; a hole; joints that are not tracked; a place that jumps.
std::vector<Moment> Show(const rig::Binding& binding, std::uint64_t seed) {
  synthetic::Options options;
  options.seed = seed;
  synthetic::Performer performer(options);
  const rig::RigPose rest(binding.skeleton());
  std::vector<Moment> show;
  std::int64_t time_ns = 1'000'000'000;
  for (int frame = 0; frame < kShowFrames; ++frame) {
    time_ns += frame < 260 ? 8'333'333 : 20'000'000;
    if (frame == 150) time_ns += 90'000'000;   // bridged
    if (frame == 200) time_ns += 700'000'000;  // not bridged
    Moment moment{time_ns, rig::RigPose(binding.skeleton())};
    body::Pose pose;
    performer.Pose(static_cast<double>(time_ns) * 1e-9, pose);
    if (frame >= 330) pose.hips_position_m.x() += 9;
    binding.Unbind(pose, rest, moment.pose);
    if (frame % 40 > 30) {
      moment.pose.rotations[5].w() = std::numeric_limits<float>::quiet_NaN();
    }
    show.push_back(std::move(moment));
  }
  return show;
}

// Changes of style on the way; `styles`: the network's number of them, neutral included. With
// contents, they change, too.
void Direct(int frame, int styles, Stylist& stylist, int contents = 0) {
  Settings settings;
  settings.transition_s = 0.4F;
  switch (frame) {
    case 0:
      settings.mix[0] = {1, 1};
      break;
    case 60:
      settings.mix[0] = {2, 0.7F};
      settings.mix[1] = {styles - 1, 0.5F};
      settings.root = Root::kStride;
      settings.variation = 7;
      settings.drift_s = 1;
      break;
    case 120:
      settings.mix[0] = {styles - 1, 1};
      settings.absolute = true;
      settings.parts = 0b000111;
      break;
    case 230:
      settings.strength = 0;
      break;
    case 280:
      settings.mix[0] = {2, 1.2F};
      settings.input_style = 1;
      settings.transition_s = 0;
      break;
    default:
      return;
  }
  if (contents > 0 && frame == 120) settings.input_content = contents - 1;
  if (contents > 0 && frame == 280) settings.input_content = net::kContentUnknown;
  ASSERT_EQ(Validate(settings, styles, contents), SettingsError::kNone) << frame;
  stylist.Set(settings);
}

bool Same(const rig::RigPose& a, const rig::RigPose& b) {
  const std::size_t joints = a.rotations.size();
  return std::memcmp(a.rotations.data(), b.rotations.data(), joints * sizeof(rig::Quat)) == 0 &&
         std::memcmp(a.translations.data(), b.translations.data(), joints * sizeof(rig::Vec3)) == 0;
}

struct CheckpointOf : testing::Test {
  const std::shared_ptr<const rig::Binding> binding =
      std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  Options options;

  // Compares the stylist with copies that read its checkpoint every `every` frames: into one that
  // is new, and into one in the middle of another show.
  void GoesOn(const std::shared_ptr<const net::Stylizer>& network, int every) {
    const auto styles = static_cast<int>(network->model().styles.size());
    const auto contents = static_cast<int>(network->model().contents.size());
    const std::vector<Moment> show = Show(*binding, 1), other = Show(*binding, 2);
    struct Copy {
      Stylist stylist;
      Output out;
      std::size_t until;
    };
    Stylist first(network, binding, options);
    Output out(binding->skeleton());
    std::vector<Copy> copies;
    for (std::size_t frame = 0; frame < show.size(); ++frame) {
      Direct(static_cast<int>(frame), styles, first, contents);
      for (Copy& copy : copies) Direct(static_cast<int>(frame), styles, copy.stylist, contents);
      first.Process(show[frame].time_ns, show[frame].pose, out);
      for (Copy& copy : copies) {
        copy.stylist.Process(show[frame].time_ns, show[frame].pose, copy.out);
        ASSERT_TRUE(Same(out.rig, copy.out.rig)) << frame << " until " << copy.until;
        ASSERT_TRUE(Same(out.source, copy.out.source)) << frame;
        ASSERT_EQ(out.flags, copy.out.flags) << frame;
        ASSERT_EQ(out.contacts, copy.out.contacts) << frame;
        ASSERT_EQ(out.steps, copy.out.steps) << frame;
        ASSERT_EQ(out.limb_weights, copy.out.limb_weights) << frame;
        ASSERT_EQ(out.travel.moved_m, copy.out.travel.moved_m) << frame;
      }
      std::erase_if(copies, [&](const Copy& copy) { return copy.until == frame; });
      if (frame % static_cast<std::size_t>(every) != 0) continue;
      const std::vector<std::byte> bytes = Bytes(first);
      Copy fresh{Stylist(network, binding, options), Output(binding->skeleton()), frame + 90};
      ASSERT_TRUE(Read(fresh.stylist, bytes)) << frame;
      Copy used{Stylist(network, binding, options), Output(binding->skeleton()), frame + 90};
      for (std::size_t past = 0; past < 40; ++past) {
        Direct(static_cast<int>(past == 0 ? 60 : 0), styles, used.stylist, contents);
        used.stylist.Process(other[past].time_ns, other[past].pose, used.out);
      }
      ASSERT_TRUE(Read(used.stylist, bytes)) << frame;
      EXPECT_EQ(Bytes(fresh.stylist), bytes) << frame;
      EXPECT_EQ(Bytes(used.stylist), bytes) << frame;
      copies.push_back(std::move(fresh));
      copies.push_back(std::move(used));
    }
    EXPECT_EQ(out.flags & kFailed, 0U);
  }
};

std::shared_ptr<const net::Stylizer> Graph(unsigned seed) {
  auto loaded = net::Parse(stgcn_causal::RandomWeights(5, 16, seed).Bytes(), "random");
  EXPECT_TRUE(loaded.ok());
  return loaded.value();
}

TEST_F(CheckpointOf, ARecurrentNetworkGoesOn) { GoesOn(erd::RandomStylizer(5, 1), 13); }

TEST_F(CheckpointOf, ARecurrentNetworkWithoutTheLimbGateGoesOn) {
  options.limb_gate = false;  // a random network knows no limb: with the gate little is shown
  GoesOn(erd::RandomStylizer(5, 2, erd::kWide), 13);
}

TEST_F(CheckpointOf, ANetworkWithContentsGoesOn) {
  options.limb_gate = false;
  GoesOn(erd::StylizerOf(erd::RandomWeightsWithContents(5, 3, 1)), 13);
}

// The bytes of a network without contents are those of before.
TEST_F(CheckpointOf, OnlyANetworkWithContentsCarriesOne) {
  Stylist without(erd::RandomStylizer(5, 1), binding, options);
  Stylist with(erd::StylizerOf(erd::RandomWeightsWithContents(5, 3, 1)), binding, options);
  EXPECT_EQ(Bytes(with).size(), Bytes(without).size() + 2 * sizeof(int));
}

TEST_F(CheckpointOf, AGraphNetworkGoesOn) {
  options.limb_gate = false;
  GoesOn(Graph(1), 29);
}

TEST_F(CheckpointOf, SeveralNetworksGoOn) {
  options.limb_gate = false;
  auto both = net::Combine({{"erd", erd::RandomStylizer(3, 1)}, {"graph", Graph(2)}});
  ASSERT_TRUE(both.ok()) << both.status().message();
  GoesOn(both.value(), 17);
}

TEST_F(CheckpointOf, TheShippedNetworksGoOn) {
  const std::string folder = STYLED_SHIPPED "/";
  std::vector<net::NamedNetwork> networks;
  for (const char* name : {"v2", "graph"}) {
    auto loaded = net::Load(folder + name + ".safetensors");
    ASSERT_TRUE(loaded.ok()) << loaded.status().message();
    networks.push_back({name, loaded.value()});
  }
  auto both = net::Combine(std::move(networks));
  ASSERT_TRUE(both.ok()) << both.status().message();
  GoesOn(both.value(), 97);
}

// A checkpoint with a value that is not finite is refused, or the published pose is sound.
TEST_F(CheckpointOf, NumbersThatAreNoneAreNotPublished) {
  options.limb_gate = false;
  const std::vector<Moment> show = Show(*binding, 1);
  Stylist stylist(erd::RandomStylizer(5, 1), binding, options);
  Output out(binding->skeleton());
  constexpr std::size_t kFramesBefore = 111;  // in the next frames a joint is not tracked, and held
  for (std::size_t frame = 0; frame < kFramesBefore; ++frame) {
    Direct(static_cast<int>(frame), 5, stylist);
    stylist.Process(show[frame].time_ns, show[frame].pose, out);
  }
  const std::vector<std::byte> sound = Bytes(stylist);
  std::size_t read = 0;
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30F}) {
    // A value of which nothing is looked at may be at any place.
    for (std::size_t at = 0; at + sizeof value <= sound.size(); at += 3) {
      std::vector<std::byte> bytes = sound;
      std::memcpy(&bytes[at], &value, sizeof value);
      if (!Read(stylist, bytes)) continue;
      ++read;
      for (std::size_t frame = kFramesBefore; frame < kFramesBefore + 2; ++frame) {
        stylist.Process(show[frame].time_ns, show[frame].pose, out);
        for (const rig::RigPose* pose : {&out.rig, &out.source}) {
          for (const auto& rotation : pose->rotations) {
            ASSERT_NEAR(rotation.squaredNorm(), 1, 2e-3F) << value << " at byte " << at;
          }
          for (const auto& place : pose->translations) {
            ASSERT_TRUE(place.allFinite()) << value << " at byte " << at << " of " << bytes.size();
          }
        }
        ASSERT_TRUE(out.canonical.hips_position_m.allFinite()) << value << " at byte " << at;
      }
    }
  }
  EXPECT_GT(read, 1000U) << "not all are refused";
}

TEST_F(CheckpointOf, AnAvatarGoesOn) {
  const auto network = erd::RandomStylizer(5, 1);
  options.limb_gate = false;
  const auto avatar = std::make_shared<const rig::Binding>(feet::HumanoidBinding());
  const rig::RigPose rest(avatar->skeleton());
  const std::vector<Moment> show = Show(*binding, 1);
  Stylist stylist(network, binding, options);
  Output out(binding->skeleton());
  Avatar first(binding, avatar, rest, options), copy(binding, avatar, rest, options);
  for (std::size_t frame = 0; frame < show.size(); ++frame) {
    Direct(static_cast<int>(frame), 5, stylist);
    stylist.Process(show[frame].time_ns, show[frame].pose, out);
    (void)first.Process(show[frame].time_ns, out);
    if (frame % 60 > 30) {
      (void)copy.Process(show[frame].time_ns, out);
      ASSERT_TRUE(Same(first.pose(), copy.pose())) << frame;
    }
    if (frame % 60 == 30) {
      ASSERT_TRUE(Read(copy, Bytes(first)));
    }
  }
}

// Bytes from elsewhere are refused, or leave a stylist that stays in bounds.
TEST_F(CheckpointOf, SpoiltBytesDoNoHarm) {
  auto both = net::Combine({{"erd", erd::RandomStylizer(3, 1)}, {"graph", Graph(2)}});
  ASSERT_TRUE(both.ok());
  const std::vector<Moment> show = Show(*binding, 1);
  Stylist stylist(both.value(), binding, options);
  Output out(binding->skeleton());
  for (std::size_t frame = 0; frame < 100; ++frame) {
    Direct(static_cast<int>(frame), 5, stylist);
    stylist.Process(show[frame].time_ns, show[frame].pose, out);
  }
  const std::vector<std::byte> bytes = Bytes(stylist);
  std::mt19937 random(1);
  int refused = 0;
  constexpr int kTries = 300;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::vector<std::byte> spoilt = bytes;
    // The front holds the counts and indices; the networks' floats are most of the rest.
    const std::size_t reach = attempt % 2 == 0 ? 6000 : spoilt.size();
    for (int i = 0; i < 8; ++i) {
      spoilt[random() % std::min(reach, spoilt.size())] = static_cast<std::byte>(random());
    }
    if (attempt % 10 == 0) spoilt.resize(random() % spoilt.size());
    Stylist hurt(both.value(), binding, options);
    if (!Read(hurt, spoilt)) {
      ++refused;
      continue;
    }
    for (std::size_t frame = 100; frame < 110; ++frame) {
      hurt.Process(show[frame].time_ns, show[frame].pose, out);
      for (const rig::Quat& rotation : out.rig.rotations) {
        ASSERT_TRUE(rotation.coeffs().allFinite()) << attempt;
      }
    }
  }
  EXPECT_GT(refused, kTries / 10);
}

TEST_F(CheckpointOf, AnotherNetworkOrBodyIsRefused) {
  Stylist stylist(erd::RandomStylizer(5, 1), binding, options);
  const std::vector<Moment> show = Show(*binding, 1);
  Output out(binding->skeleton());
  for (std::size_t frame = 0; frame < 20; ++frame) {
    Direct(static_cast<int>(frame), 5, stylist);
    stylist.Process(show[frame].time_ns, show[frame].pose, out);
  }
  const std::vector<std::byte> bytes = Bytes(stylist);
  Stylist wide(erd::RandomStylizer(5, 1, erd::kWide), binding, options);
  EXPECT_FALSE(Read(wide, bytes));
  Stylist graph(Graph(1), binding, options);
  EXPECT_FALSE(Read(graph, bytes));
  rig::BindingSpec spec = rig::HumanoidSpec();
  spec.skeleton.names.push_back("tail");
  spec.skeleton.parents.push_back(0);
  spec.skeleton.offsets.emplace_back(0, 0, -0.1F);
  if (!spec.rest_rotations.empty()) spec.rest_rotations.push_back(spec.rest_rotations.front());
  auto tailed = rig::Binding::Make(std::move(spec));
  ASSERT_TRUE(tailed.ok()) << tailed.status().message();
  Stylist other(erd::RandomStylizer(5, 1),
                std::make_shared<const rig::Binding>(std::move(tailed.value())), options);
  EXPECT_FALSE(Read(other, bytes));
}

}  // namespace
}  // namespace styled::stylist
