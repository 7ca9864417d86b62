// VRChat's trackers as others' OSC reads them: liblo's oscdump and npm's osc-min print what
// `stylevmc --as vrchat` sends. Its addresses, types and order are compared with VRChat's document,
// its values with the frames that the daemon published: forward kinematics here, and Eigen for the
// angles. None of our codec of VRChat takes part.
#include <gtest/gtest.h>
#include <signal.h>

#include <Eigen/Geometry>

#include "model/body/pose.h"
#include "tests/support/clients.h"
#include "tests/witness/osc/reader.h"

namespace styled::support {
namespace {

using body::Quat;
using body::Vec3;

constexpr std::size_t kBundles = 30;
constexpr float kDegreesPerRadian = 57.29578F;
// oscdump prints six decimals of a metre or a degree. Near a pitch of 90 degrees a float's angle is
// good to a few hundredths.
constexpr float kNear_m = 1e-4F, kNear_deg = 0.1F;
constexpr const char* kStyled = "styled/rig.a/canonical/";

// A tracker by its number is at one joint and turns as another.
struct Place {
  int at, turns_as;
};
constexpr std::array<Place, 9> kPlaces{{{body::kHead, body::kHead},
                                        {body::kHips, body::kHips},
                                        {body::kLeftFoot, body::kLeftFoot},
                                        {body::kRightFoot, body::kRightFoot},
                                        {body::kLeftLowerLeg, body::kLeftUpperLeg},
                                        {body::kRightLowerLeg, body::kRightUpperLeg},
                                        {body::kChest, body::kChest},
                                        {body::kLeftLowerArm, body::kLeftUpperArm},
                                        {body::kRightLowerArm, body::kRightUpperArm}}};

struct Message {
  std::string address;
  Vec3 values;
};

// A printed line: "ADDRESS ,fff HEX HEX HEX" of osc-min, "ADDRESS fff NUMBER NUMBER NUMBER" of
// oscdump.
Message Parse(const std::string& line) {
  std::istringstream words(line);
  Message message;
  std::string types, word;
  words >> message.address >> types;
  const bool bits = types.starts_with(',');
  EXPECT_EQ(types, bits ? ",fff" : "fff") << line;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(words >> word) << line << ": a value is missing";
    message.values[i] =
        bits ? std::bit_cast<float>(static_cast<std::uint32_t>(std::stoul(word, nullptr, 16)))
             : std::stof(word);
  }
  EXPECT_FALSE(words >> word) << line << ": more than three values";
  return message;
}

// Where the trackers are in a published frame, in our space.
body::WorldPose WorldOf(const v1::Frame& frame) {
  body::Pose pose;
  const auto& p = frame.root_position();
  pose.hips_position_m = {p[0], p[1], p[2]};
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    const float* q = frame.rotations().data() + 4 * j;
    pose.rotations[j] = Quat(q[3], q[0], q[1], q[2]);
  }
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return world;
}

// Unity mirrors x. Its angles are a turn about z, then x, then y, on fixed axes.
Vec3 FromUnity(const Vec3& p) { return {-p.x(), p.y(), p.z()}; }
Quat RotationOf(const Vec3& euler_deg) {
  const Vec3 angles = euler_deg / kDegreesPerRadian;
  const Quat q = Eigen::AngleAxisf(angles.y(), Vec3::UnitY()) *
                 Eigen::AngleAxisf(angles.x(), Vec3::UnitX()) *
                 Eigen::AngleAxisf(angles.z(), Vec3::UnitZ());
  return {q.w(), q.x(), -q.y(), -q.z()};
}

// How far what was read is from a published frame, as a share of what is allowed.
float Distance(const std::vector<Message>& read, const body::WorldPose& world, float scale) {
  float worst = 0;
  for (const Message& message : read) {
    const char which = message.address[std::strlen("/tracking/trackers/")];
    const Place& place = kPlaces[which == 'h' ? 0 : static_cast<std::size_t>(which - '0')];
    if (message.address.ends_with("/position")) {
      const Vec3 expected = scale * world.positions_m[static_cast<std::size_t>(place.at)];
      worst = std::max(worst, (FromUnity(message.values) - expected).norm() / kNear_m);
      continue;
    }
    Quat expected = world.rotations[static_cast<std::size_t>(place.turns_as)];
    if (which == 'h') {  // its heading alone: where it faces, seen from above
      const Vec3 ahead = expected * Vec3::UnitZ();
      expected = Eigen::AngleAxisf(std::atan2(ahead.x(), ahead.z()), Vec3::UnitY());
    }
    worst = std::max(worst, kDegreesPerRadian *
                                RotationOf(message.values).angularDistance(expected) / kNear_deg);
  }
  return worst;
}

// The addresses of a bundle, in order.
Lines AddressesOf(const std::vector<int>& trackers, bool turns) {
  const std::string all = "/tracking/trackers/";
  Lines addresses{all + "head/position"};
  if (turns) addresses.push_back(all + "head/rotation");
  for (const int number : trackers) {
    addresses.push_back(all + std::to_string(number) + "/position");
    addresses.push_back(all + std::to_string(number) + "/rotation");
  }
  return addresses;
}

std::vector<std::vector<Message>> BundlesOf(const Lines& lines) {
  std::vector<std::vector<Message>> bundles;
  for (const std::string& line : lines) {
    Message message = Parse(line);
    if (bundles.empty() || message.address == "/tracking/trackers/head/position") {
      bundles.emplace_back();
    }
    bundles.back().push_back(std::move(message));
  }
  return bundles;
}

// A performer who turns to their left and walks away, so that no two frames are the same.
Bytes NextFrame(Rig& rig, int index) {
  return rig.Frame([index](v1::SourceFrame& frame) {
    const auto i = static_cast<float>(index);
    frame.set_root_position(0, frame.root_position(0) + 0.002F * i);
    const Quat turn(Eigen::AngleAxisf(0.5F + 0.002F * i, Vec3::UnitY()));
    auto& r = *frame.mutable_rotations();
    const Quat hips = turn * Quat(r[3], r[0], r[1], r[2]);
    for (int k = 0; k < 4; ++k) r[k] = hips.coeffs()[k];
  });
}

class VrChatReaderTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (const std::string why = Missing(GetParam()); !why.empty()) GTEST_SKIP() << why;
  }

  // The result of these options of stylevmc for a user.
  void Check(const Lines& options, const std::vector<int>& trackers, float scale) {
    Daemon daemon;
    const Reader reader(GetParam());
    const Ear ear;
    TemporaryFolder folder;
    Lines command{STYLEVMC_BINARY, "--publish", daemon.publish,   "--as",   "vrchat", "--to",
                  ear.address(),   "--to",      reader.address(), "--rate", "20"};
    command.insert(command.end(), options.begin(), options.end());
    Child stylevmc(command, folder / "stderr.txt");
    Subscriber published(daemon.publish, {"body/", kStyled});
    const UdpLink link(daemon.udp);
    Rig rig("a");
    std::size_t sent = 0;
    for (int i = 0; i < 2400 && sent < kBundles; ++i) {
      if (i % 60 == 0) link.Send(rig.Body());
      link.Send(NextFrame(rig, i));
      while (!ear.Receive(0).empty()) ++sent;
      Sleep(1.0 / 120);
    }
    stylevmc.Signal(SIGTERM);
    EXPECT_EQ(stylevmc.Wait(5).value_or(-1), 0) << ReadText(folder / "stderr.txt");
    while (!ear.Receive(200).empty()) ++sent;
    ASSERT_GE(sent, kBundles);
    const auto bundles = BundlesOf(reader.WaitFor(sent * AddressesOf(trackers, false).size()));
    ASSERT_EQ(bundles.size(), sent);
    std::vector<body::WorldPose> worlds;
    for (const v1::Frame& frame : published.Frames(kStyled)) worlds.push_back(WorldOf(frame));
    ExpectTheFrames(bundles, trackers, worlds, scale);
  }

 private:
  // Each bundle is one of the published frames, later than that of the bundle before.
  static void ExpectTheFrames(const std::vector<std::vector<Message>>& bundles,
                              const std::vector<int>& trackers,
                              const std::vector<body::WorldPose>& worlds, float scale) {
    std::size_t next = 0;
    for (std::size_t b = 0; b < bundles.size(); ++b) {
      const auto& bundle = bundles[b];
      Lines addresses;
      for (const Message& message : bundle) addresses.push_back(message.address);
      // VRChat turns its space by the head's heading: with the first bundle, and after a pause.
      const bool turns = b == 0 || bundle.size() > AddressesOf(trackers, false).size();
      ASSERT_EQ(addresses, AddressesOf(trackers, turns)) << "bundle " << b;
      float least = 1e9F;
      for (; next < worlds.size(); ++next) {
        const float distance = Distance(bundle, worlds[next], scale);
        least = std::min(least, distance);
        if (distance <= 1) break;
      }
      ASSERT_LT(next, worlds.size())
          << "bundle " << b << " is no published frame: the nearest one is " << least
          << " times too far, of " << kNear_m << " m and " << kNear_deg << " degrees";
      ++next;
    }
  }
};

TEST_P(VrChatReaderTest, PrintsAllTrackersOfThePublishedFrames) {
  Check({"--trackers", "all"}, {1, 2, 3, 4, 5, 6, 7, 8}, 1);
}

TEST_P(VrChatReaderTest, PrintsHipAndFeetOfAUserOfHalfTheSize) {
  Check({"--user-height", "0.855"}, {1, 2, 3}, 0.5F);
}

INSTANTIATE_TEST_SUITE_P(Others, VrChatReaderTest, testing::Values("oscdump", "osc-min"),
                         [](const auto& info) {
                           return info.param == "oscdump" ? "oscdump" : "oscmin";
                         });

}  // namespace
}  // namespace styled::support
