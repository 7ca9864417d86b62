#include "sim/rigs/slimevr.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <random>

#include "model/rig/trackers.h"
#include "proto/rigs/slimevr/udp.h"

namespace styled::rigs {
namespace {

using body::Joint;
using body::Quat;
using body::Vec3;

constexpr float kPi = 3.14159265F;
// Duration of the poses for the resets; each reset is requested shortly before the end.
constexpr double kStanding_s = 1, kSkiing_s = 0.5;
constexpr double kAsks_s = 0.2;
constexpr double kSeeks_s = 1, kAnnounces_s = 1, kNegotiates_s = 0.5, kGivesUp_s = 3;
constexpr auto kStance = rig::Trackers::Stance::kTPose;

// A place for a sensor, and SlimeVR's TrackerPosition for it.
struct WornPlace {
  Joint joint;
  std::uint8_t position;
};
constexpr std::array<WornPlace, 13> kPlaces{{{body::kHips, 6},
                                             {body::kChest, 4},
                                             {body::kHead, 1},
                                             {body::kLeftUpperArm, 15},
                                             {body::kLeftLowerArm, 13},
                                             {body::kRightUpperArm, 16},
                                             {body::kRightLowerArm, 14},
                                             {body::kLeftUpperLeg, 7},
                                             {body::kLeftLowerLeg, 9},
                                             {body::kLeftFoot, 11},
                                             {body::kRightUpperLeg, 8},
                                             {body::kRightLowerLeg, 10},
                                             {body::kRightFoot, 12}}};

std::string_view NameOf(const WornPlace& place) {
  return body::kHumanoid[static_cast<std::size_t>(place.joint)].name;
}

Quat About(const Vec3& axis, float angle) { return Quat(Eigen::AngleAxisf(angle, axis)); }

bool IsOfArm(Joint joint) { return joint >= body::kLeftShoulder && joint <= body::kRightHand; }

// World rotations of the second pose of a mounting reset.
std::array<Quat, body::kJointCount> Skier() {
  std::array<Quat, body::kJointCount> world;
  for (int j = 0; j < body::kJointCount; ++j) {
    auto& q = world[static_cast<std::size_t>(j)];
    const bool left = j <= body::kLeftHand;
    q = About(Vec3::UnitX(), 0.5F);
    if (IsOfArm(Joint(j))) q = About(Vec3::UnitZ(), left ? -kPi / 2 : kPi / 2);
    if (j == body::kLeftUpperLeg || j == body::kRightUpperLeg) q = About(Vec3::UnitX(), -0.9F);
  }
  return world;
}

class SlimeVr final : public Rig {
 public:
  SlimeVr(const Options& options, std::vector<WornPlace> places)
      : options_(options), random_(options.seed) {
    for (const WornPlace& place : places) {
      Sensor sensor{place};
      sensor.heading = Between(-kPi, kPi);
      sensor.part_from_sensor = Mount(place.joint);
      sensors_.push_back(sensor);
    }
  }

  void Encode(const Frame& frame, const Send& send) override {
    now_s_ = frame.time_s;
    if (connected_ && now_s_ - heard_s_ > kGivesUp_s) Lose();
    if (!connected_) {
      if (now_s_ >= next_seek_s_) Seek(send);
      return;
    }
    Negotiate(send);
    SendMotion(WorldOf(frame), send);
    Ask(send);
  }

  void Restart() override {
    Lose();
    number_ = 0;
    now_s_ = heard_s_ = next_seek_s_ = 0;
    connected_s_ = -1;
    asked_ = 0;
    // After a restart the sensor has lost its heading.
    for (Sensor& sensor : sensors_) sensor.heading = Between(-kPi, kPi);
  }

  void Receive(std::span<const std::byte> datagram, const Send& send) override {
    slimevr::Answer answer;
    if (slimevr::DecodeAnswer(datagram, answer) != slimevr::UdpResult::kOk) return;
    if (std::holds_alternative<slimevr::Greeting>(answer) && !connected_) {
      connected_ = true;
      next_announce_s_ = next_negotiate_s_ = now_s_;
      if (connected_s_ < 0) connected_s_ = now_s_;
    }
    if (!connected_) return;
    heard_s_ = now_s_;
    if (std::holds_alternative<slimevr::Heartbeat>(answer)) {
      SendPacket(slimevr::Heartbeat{}, send);
    } else if (std::holds_alternative<slimevr::Ping>(answer)) {
      send(datagram);
    } else if (const auto* ack = std::get_if<slimevr::SensorInfoAck>(&answer)) {
      if (ack->sensor < sensors_.size()) sensors_[ack->sensor].acknowledged = true;
    } else if (const auto* flags = std::get_if<slimevr::FeatureFlags>(&answer)) {
      negotiated_ = true;
      features_ = flags->bits;
    }
  }

  std::string default_address() const override { return "udp://127.0.0.1:6969"; }

 private:
  struct Sensor {
    WornPlace place;
    float heading = 0;
    Quat part_from_sensor = Quat::Identity();
    bool acknowledged = false;
  };

  float Between(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }

  Quat Mount(Joint joint) {
    if (HasQuirk(options_, "anyhow")) {
      Quat any;
      for (float& part : any.coeffs()) part = std::normal_distribution<float>()(random_);
      return any.normalized();
    }
    // The sensor's face (or its top, if the body part is horizontal) points in this direction; then
    // a random pitch and roll are added.
    const Quat towards = About(Vec3::UnitY(), rig::Trackers::Facing(joint, kStance));
    const float lift = Between(-0.7F, 0.7F), turn = Between(-kPi, kPi);
    return IsOfArm(joint)
               ? towards * About(Vec3::UnitX(), kPi / 2 - lift) * About(Vec3::UnitY(), turn)
               : towards * About(Vec3::UnitX(), -lift) * About(Vec3::UnitZ(), turn);
  }

  void Lose() {
    connected_ = negotiated_ = false;
    features_ = 0;
    for (Sensor& sensor : sensors_) sensor.acknowledged = false;
  }

  void SendPacket(const slimevr::Packet& packet, const Send& send, bool numbered = true) {
    send(std::span(buffer_).first(slimevr::Encode(numbered ? ++number_ : 0, packet, buffer_)));
  }

  void Seek(const Send& send) {
    next_seek_s_ = now_s_ + kSeeks_s;
    slimevr::Handshake handshake;
    handshake.board = 4;  // a custom board
    handshake.imu = 13;
    handshake.mcu = 2;
    handshake.protocol = HasQuirk(options_, "legacy") ? 5 : 22;
    handshake.firmware = HasQuirk(options_, "legacy") ? "" : "stand-in";
    const auto seed = static_cast<std::uint32_t>(options_.seed);
    handshake.mac = {0x02,
                     0x53,
                     0x56,
                     static_cast<std::uint8_t>(seed >> 16U),
                     static_cast<std::uint8_t>(seed >> 8U),
                     static_cast<std::uint8_t>(seed)};
    SendPacket(handshake, send, false);
  }

  void Negotiate(const Send& send) {
    if (HasQuirk(options_, "legacy")) return;
    if (now_s_ >= next_announce_s_) {
      next_announce_s_ = now_s_ + kAnnounces_s;
      for (std::size_t k = 0; k < sensors_.size(); ++k) {
        if (sensors_[k].acknowledged) continue;
        slimevr::SensorInfo info;
        info.sensor = static_cast<std::uint8_t>(k);
        info.imu = 13;
        info.calibrated = 1;
        if (!HasQuirk(options_, "unplaced")) info.position = sensors_[k].place.position;
        SendPacket(info, send);
      }
    }
    if (!negotiated_ && now_s_ >= next_negotiate_s_) {
      next_negotiate_s_ = now_s_ + kNegotiates_s;
      SendPacket(slimevr::FeatureFlags{}, send);
    }
  }

  // The performer's global rotations.
  using World = std::array<Quat, body::kJointCount>;
  World WorldOf(const Frame& frame) const {
    const body::Pose& pose = frame.poses[0];
    const double playing_s = now_s_ - connected_s_;
    if (HasQuirk(options_, "no-reset") || playing_s >= kStanding_s + kSkiing_s) {
      // An untracked joint affects only its own sensor: child joints are computed from the whole
      // pose.
      body::Pose seen = frame.whole.empty() ? pose : frame.whole[0];
      for (Quat& q : seen.rotations) {
        if (!q.coeffs().allFinite()) q = Quat::Identity();
      }
      body::WorldPose world;
      body::ForwardKinematics(seen, world);
      for (std::size_t j = 0; j < pose.rotations.size(); ++j) {
        if (!pose.rotations[j].coeffs().allFinite()) world.rotations[j] = pose.rotations[j];
      }
      return world.rotations;
    }
    World world;
    world.fill(Quat::Identity());
    if (playing_s >= kStanding_s) world = Skier();
    return world;
  }

  void SendMotion(const World& world, const Send& send) {
    std::vector<slimevr::Packet> packets;
    const bool compact =
        HasQuirk(options_, "compact") && (features_ & slimevr::kCompactBundles) != 0;
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      const Sensor& sensor = sensors_[k];
      const Quat& part = world[static_cast<std::size_t>(sensor.place.joint)];
      if (!part.coeffs().allFinite()) continue;  // out of reach: the sensor sends nothing
      // +Y up -> +Z up.
      const Quat q = About(Vec3::UnitX(), kPi / 2) * About(Vec3::UnitY(), sensor.heading) * part *
                     sensor.part_from_sensor;
      const slimevr::Orientation orientation{{q.x(), q.y(), q.z(), q.w()}, true};
      const auto number = static_cast<std::uint8_t>(k);
      if (HasQuirk(options_, "legacy")) {
        packets.emplace_back(slimevr::LegacyRotation{number, orientation});
      } else if (compact) {
        packets.emplace_back(slimevr::RotationAndAcceleration{number, {orientation, {}}});
      } else {
        packets.emplace_back(slimevr::Rotation{number, 1, orientation, 0});
      }
    }
    if (packets.empty()) return;
    if ((features_ & slimevr::kBundles) == 0) {
      for (const auto& packet : packets) SendPacket(packet, send);
    } else {
      send(std::span(buffer_).first(slimevr::EncodeBundle(++number_, packets, compact, buffer_)));
    }
  }

  void Ask(const Send& send) {
    if (HasQuirk(options_, "no-reset") || sensors_.front().place.joint != body::kHips) return;
    const double playing_s = now_s_ - connected_s_;
    if (asked_ == 0 && playing_s >= kStanding_s - kAsks_s) {
      asked_ = 1;
      SendPacket(slimevr::UserAction{slimevr::UserAction::kFullReset}, send);
    } else if (asked_ == 1 && playing_s >= kStanding_s + kSkiing_s - kAsks_s) {
      asked_ = 2;
      SendPacket(slimevr::UserAction{slimevr::UserAction::kMountingReset}, send);
    }
  }

  Options options_;
  std::mt19937_64 random_;
  std::vector<Sensor> sensors_;
  std::array<std::byte, slimevr::kMaxUdpSize> buffer_;
  std::uint64_t number_ = 0;
  bool connected_ = false, negotiated_ = false;
  std::uint32_t features_ = 0;
  double now_s_ = 0, heard_s_ = 0, connected_s_ = -1;
  double next_seek_s_ = 0, next_announce_s_ = 0, next_negotiate_s_ = 0;
  int asked_ = 0;
};

}  // namespace

std::string SlimeVrTrackerId(std::uint64_t seed, std::size_t sensor) {
  char text[40];
  std::snprintf(text, sizeof text, "025356%06X/%u", static_cast<unsigned>(seed & 0xFFFFFFU),
                static_cast<unsigned>(sensor));
  return text;
}

Result<std::unique_ptr<Rig>> MakeSlimeVr(const Options& options) {
  const Status status = CheckOptions(
      "slimevr", options, 1,
      {"anyhow", "unplaced", "no-reset", "compact", "legacy", "hips", "chest", "head",
       "leftUpperArm", "leftLowerArm", "rightUpperArm", "rightLowerArm", "leftUpperLeg",
       "leftLowerLeg", "leftFoot", "rightUpperLeg", "rightLowerLeg", "rightFoot"});
  if (!status.ok()) return status;
  const auto has = [&options](std::string_view quirk) {
    return std::find(options.quirks.begin(), options.quirks.end(), quirk) != options.quirks.end();
  };
  std::vector<WornPlace> places;
  for (const WornPlace& place : kPlaces) {
    if (has(NameOf(place))) places.push_back(place);
  }
  if (places.empty()) places.assign(kPlaces.begin(), kPlaces.end());
  if (has("legacy")) places.resize(1);
  return std::unique_ptr<Rig>(std::make_unique<SlimeVr>(options, std::move(places)));
}

}  // namespace styled::rigs
