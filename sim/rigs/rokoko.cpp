#include "sim/rigs/rokoko.h"

#include <algorithm>

#include "proto/rigs/rokoko/rokoko.h"
#include "sim/rigs/synthetic_face.h"

namespace styled::rigs {
namespace {

using body::Quat;
using body::Vec3;
using rokoko::kJoints;

constexpr std::size_t kMaxDatagramSize = 65507;

// Studio's joint for each canonical one; both lists have the same order.
constexpr std::array<int, body::kJointCount> kJointOf = [] {
  std::array<int, body::kJointCount> joints{};
  for (int c = 0; c < body::kJointCount; ++c) {
    const int toe_ends = c > body::kLeftToes ? 1 : 0;  // the humanoid has no toe ends
    joints[static_cast<std::size_t>(c)] = c + toe_ends;
  }
  return joints;
}();
static_assert(kJointOf[body::kLeftHand] == rokoko::kLeftHand &&
              kJointOf[body::kRightShoulder] == rokoko::kRightShoulder &&
              kJointOf[body::kLeftToes] == rokoko::kLeftToe &&
              kJointOf[body::kRightToes] == rokoko::kRightToe);

class Rokoko final : public Rig {
 public:
  explicit Rokoko(const Options& options)
      : options_(options),
        lz4_(HasQuirk(options_, "lz4")),
        gloves_(HasQuirk(options_, "gloves")),
        face_(HasQuirk(options_, "face")),
        text_(rokoko::kMaxTextSize),
        packed_(kMaxDatagramSize) {
    frame_.fps = static_cast<float>(options.rate_hz);
    frame_.actor_count = static_cast<int>(options.performers.size());
    for (std::size_t k = 0; k < options.performers.size(); ++k) {
      frame_.actors[k].set_name(options.performers[k]);
      frame_.actors[k].hip_height_m = body::kHumanoid[body::kHips].y_m;
      frame_.actors[k].total_height_m = 1.75F;
    }
  }

  void Encode(const Frame& frame, const Send& send) override {
    frame_.time_s = frame.time_s;
    for (std::size_t k = 0; k < frame.poses.size(); ++k) {
      Place(frame.poses[k], frame_.actors[k]);
      frame_.actors[k].has_face = face_;
      if (face_) frame_.actors[k].face = SyntheticFace(frame.time_s);
    }
    frame_.prop_count = 0;
    for (std::size_t k = 0; k < frame.props.size(); ++k) {
      if (frame.props[k]) PutProp(options_.props[k].name, *frame.props[k]);
    }
    std::span<const std::byte> datagram =
        std::as_bytes(std::span(text_).first(rokoko::EncodeText(frame_, text_)));
    if (lz4_) datagram = std::span(packed_).first(packer_.Pack(datagram, packed_));
    if (!datagram.empty() && datagram.size() <= kMaxDatagramSize) send(datagram);
  }

  std::string default_address() const override { return "udp://127.0.0.1:14043"; }

 private:
  // Writes a joint with this global position and rotation from the T-pose, in canonical axes.
  static void Put(std::size_t joint, const Vec3& position, const Quat& turn, rokoko::Actor& actor) {
    const auto& t = rokoko::kJointTable[joint].t_pose;
    const Quat q = Quat(turn.w(), turn.x(), -turn.y(), -turn.z()) * Quat(t[3], t[0], t[1], t[2]);
    actor.joints[joint] = {{-position.x(), position.y(), position.z()},
                           {q.x(), q.y(), q.z(), q.w()}};
    actor.has.set(joint, position.allFinite() && q.coeffs().allFinite());
  }

  void PutProp(const std::string& name, const rig::Placed& placed) {
    rokoko::Prop& prop = frame_.props[static_cast<std::size_t>(frame_.prop_count++)];
    prop.set_name(name);
    const Vec3& p = placed.position_m;
    const Quat& q = placed.rotation;
    prop.pose = {{-p.x(), p.y(), p.z()}, {q.x(), -q.y(), -q.z(), q.w()}};
  }

  void Place(const body::Pose& pose, rokoko::Actor& actor) const {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    actor.has.reset();
    for (std::size_t c = 0; c < body::kJointCount; ++c) {
      Put(static_cast<std::size_t>(kJointOf[c]), world.positions_m[c], world.rotations[c], actor);
    }
    for (const auto& [toe, canonical] : {std::pair{rokoko::kLeftToe, body::kLeftToes},
                                         std::pair{rokoko::kRightToe, body::kRightToes}}) {
      const Quat& turn = world.rotations[canonical];
      Put(static_cast<std::size_t>(toe) + 1,
          world.positions_m[canonical] + turn * Vec3(0, 0, 0.07F), turn, actor);
    }
    for (std::size_t j = rokoko::kBodyJoints; gloves_ && j < kJoints; ++j) {
      const std::size_t index = (j - rokoko::kBodyJoints) % rokoko::kFingerJoints;
      const std::size_t phalanx = index % 4;
      const std::size_t finger = (index - phalanx) / 4;
      const bool left = j < rokoko::kBodyJoints + rokoko::kFingerJoints;
      const body::Joint hand = left ? body::kLeftHand : body::kRightHand;
      const float out_m = 0.07F + 0.03F * static_cast<float>(phalanx);
      const Vec3 offset(left ? out_m : -out_m, 0, 0.04F - 0.02F * static_cast<float>(finger));
      Put(j, world.positions_m[hand] + world.rotations[hand] * offset, world.rotations[hand],
          actor);
    }
  }

  Options options_;
  bool lz4_, gloves_, face_;
  rokoko::Frame frame_;
  std::vector<char> text_;
  std::vector<std::byte> packed_;
  rokoko::Lz4Packer packer_;
};

}  // namespace

Result<std::unique_ptr<Rig>> MakeRokoko(const Options& options) {
  const auto has = [&options](std::string_view quirk) {
    return std::find(options.quirks.begin(), options.quirks.end(), quirk) != options.quirks.end();
  };
  const int with_gloves = has("face") ? 4 : 5;  // that fit into a datagram
  const int most = has("gloves") && !has("lz4") ? with_gloves : rokoko::kMaxActors;
  const Status status =
      CheckOptions("rokoko", options, most, {"lz4", "gloves", "face"}, rokoko::kMaxProps);
  if (!status.ok()) return status;
  return std::unique_ptr<Rig>(std::make_unique<Rokoko>(options));
}

}  // namespace styled::rigs
