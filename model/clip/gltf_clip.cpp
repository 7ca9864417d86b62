#include "model/clip/gltf_clip.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "model/base/text.h"
#include "model/clip/gltf_accessors.h"
#include "model/clip/gltf_meshopt.h"
#include "model/clip/gltf_nodes.h"
#include "model/rig/calibration.h"
#include "model/rig/dialects.h"

namespace styled::clip {
namespace {

using gltf::Accessors;
using gltf::IndexOf;
using gltf::kLatest_s;
using gltf::Member;
using gltf::Transform;
using nlohmann::json;
using rig::Quat;
using rig::Vec3;

constexpr std::size_t kMaxAbove = 64;  // nodes above the hips
constexpr double kSlowest_hz = 10, kFastest_hz = 240;
constexpr double kTooSlow_hz = 1;  // below, a file's keys are no motion
// The sampled frames take at most this many bytes for each byte of the file, in addition to a fixed
// allowance (60 s of 55 joints at 43 Hz). If they would take more, they are sampled at a lower
// rate, because such a file has few keys.
constexpr std::size_t kSampledBytesPerByte = 4;
constexpr std::size_t kSampledAllowance = std::size_t{4} << 20;
constexpr std::size_t kFramesPerCheck = 64;  // of the time limit

// The keys of one channel.
struct Track {
  enum class Interpolation { kLinear, kStep, kCubic };
  std::size_t width = 4;  // of a value: 3 or 4
  Interpolation interpolation = Interpolation::kLinear;
  Accessors::Values times, values;  // cubic: in-tangent, value, out-tangent per key

  bool empty() const { return times == nullptr; }
  const std::vector<float>& times_s() const { return *times; }
  const float* Value(std::size_t key) const {
    return values->data() + width * (interpolation == Interpolation::kCubic ? 3 * key + 1 : key);
  }
};

struct NodeTracks {
  Track rotation, translation;
};

// The nodes whose motion moves the humanoid: its bones, and the nodes above its hips.
class MovingNodes {
 public:
  MovingNodes(const gltf::Nodes& nodes, const gltf::Bones& bones, std::size_t count)
      : places_(count, -1) {
    for (int node = nodes.parent(bones.nodes[0]); node >= 0; node = nodes.parent(node)) {
      above_.push_back(node);
    }
    std::reverse(above_.begin(), above_.end());
    for (const int node : above_) places_[static_cast<std::size_t>(node)] = size_++;
    for (const int node : bones.nodes) places_[static_cast<std::size_t>(node)] = size_++;
  }

  const std::vector<int>& above() const { return above_; }  // outermost first
  std::size_t size() const { return static_cast<std::size_t>(size_); }
  std::size_t nodes() const { return places_.size(); }
  // A node's place among them; -1: not among them.
  int place(int node) const { return places_[static_cast<std::size_t>(node)]; }
  bool is_bone(int node) const { return place(node) >= static_cast<int>(above_.size()); }

 private:
  std::vector<int> above_, places_;
  int size_ = 0;
};

// The value at a time, of a rotation not normalized (glTF 2.0, appendix C).
Eigen::Vector4f ValueOf(const Track& track, double time_s) {
  Eigen::Vector4f value = Eigen::Vector4f::Zero();
  const auto read = [&](const float* from) {
    Eigen::Vector4f read = Eigen::Vector4f::Zero();
    for (std::size_t i = 0; i < track.width; ++i) read[static_cast<Eigen::Index>(i)] = from[i];
    return read;
  };
  const auto& times = track.times_s();
  const auto next = static_cast<std::size_t>(
      std::upper_bound(times.begin(), times.end(), static_cast<float>(time_s)) - times.begin());
  if (next == 0) return read(track.Value(0));
  if (next == times.size() || track.interpolation == Track::Interpolation::kStep)
    return read(track.Value(next - 1));
  const float step_s = times[next] - times[next - 1];
  const float t = (static_cast<float>(time_s) - times[next - 1]) / step_s;
  const Eigen::Vector4f a = read(track.Value(next - 1)), b = read(track.Value(next));
  if (track.interpolation == Track::Interpolation::kLinear) {
    if (track.width == 3) return a + t * (b - a);
    return Quat(a).normalized().slerp(t, Quat(b).normalized()).coeffs();
  }
  const Eigen::Vector4f out = step_s * read(track.Value(next - 1) + track.width);
  const Eigen::Vector4f in = step_s * read(track.Value(next) - track.width);
  const float t2 = t * t, t3 = t2 * t;
  value =
      (2 * t3 - 3 * t2 + 1) * a + (t3 - 2 * t2 + t) * out + (3 * t2 - 2 * t3) * b + (t3 - t2) * in;
  return value;
}

Result<Track> ReadTrack(const json& sampler, std::size_t width, Accessors& accessors) {
  Track track;
  track.width = width;
  const json& interpolation = Member(sampler, "interpolation");
  if (interpolation == "STEP") track.interpolation = Track::Interpolation::kStep;
  if (interpolation == "CUBICSPLINE") track.interpolation = Track::Interpolation::kCubic;
  const auto input = IndexOf(sampler, "input"), output = IndexOf(sampler, "output");
  if (!input || !output) return Status::Error("found a sampler without input or output");
  auto times = accessors.Read(*input, "SCALAR");
  if (!times.ok()) return times.status();
  auto values = accessors.Read(*output, width == 3 ? "VEC3" : "VEC4");
  if (!values.ok()) return values.status();
  track.times = std::move(times.value());
  track.values = std::move(values.value());
  const std::size_t per_key = width * (track.interpolation == Track::Interpolation::kCubic ? 3 : 1);
  if (track.values->size() != per_key * track.times->size()) {
    return Status::Error("found " + std::to_string(track.times->size()) + " times for " +
                         std::to_string(track.values->size() / per_key) + " values");
  }
  return track;
}

// The channels of an animation that move the humanoid, by the places of their nodes; empty if it
// turns no bone. Of two channels of one target the last one counts.
Result<std::vector<NodeTracks>> ReadTracks(const json& animation, const MovingNodes& moving,
                                           Accessors& accessors) {
  const json &channels = Member(animation, "channels"), &samplers = Member(animation, "samplers");
  if (!channels.is_array() || !samplers.is_array()) return std::vector<NodeTracks>();
  struct Sampled {
    int rotation = -1, translation = -1;  // samplers
  };
  std::vector<Sampled> sampled;
  bool turns_bone = false;
  for (const json& channel : channels) {
    const json& target = Member(channel, "target");
    const auto node = IndexOf(target, "node"), sampler = IndexOf(channel, "sampler");
    const bool turns = Member(target, "path") == "rotation";
    if (!node || (!turns && Member(target, "path") != "translation")) continue;
    if (static_cast<std::size_t>(*node) >= moving.nodes() || !sampler ||
        static_cast<std::size_t>(*sampler) >= samplers.size()) {
      return Status::Error("found a channel whose node or sampler does not exist");
    }
    const int place = moving.place(*node);
    if (place < 0) continue;
    sampled.resize(moving.size());
    Sampled& own = sampled[static_cast<std::size_t>(place)];
    (turns ? own.rotation : own.translation) = *sampler;
    turns_bone = turns_bone || (turns && moving.is_bone(*node));
  }
  if (!turns_bone) return std::vector<NodeTracks>();
  std::vector<NodeTracks> tracks(moving.size());
  const auto read = [&](int sampler, std::size_t width, Track& track) {
    if (sampler < 0) return Status::Ok();
    auto own = ReadTrack(samplers[static_cast<std::size_t>(sampler)], width, accessors);
    if (own.ok()) track = std::move(own.value());
    return own.status();
  };
  for (std::size_t place = 0; place < tracks.size(); ++place) {
    for (const Status& status : {read(sampled[place].rotation, 4, tracks[place].rotation),
                                 read(sampled[place].translation, 3, tracks[place].translation)}) {
      if (!status.ok()) return status;
    }
  }
  return tracks;
}

// An animation as a clip of the bones.
class Sampler {
 public:
  // `bytes`: the size of the file; `longest_s`: of the motion that is sampled.
  Sampler(const gltf::Nodes& nodes, const gltf::Bones& bones, const MovingNodes& moving,
          const std::vector<NodeTracks>& tracks, std::size_t bytes, double longest_s)
      : nodes_(nodes),
        bones_(bones),
        moving_(moving),
        tracks_(tracks),
        bytes_(bytes),
        longest_s_(longest_s) {}

  Status Check() const {
    const Grid grid = MakeGrid();
    if (grid.rate_hz >= kTooSlow_hz) return Status::Ok();
    return Status::Error("found " + NumberText(grid.end_s - grid.begin_s, 2) +
                         " s of hardly a key, expected a motion");
  }
  Result<Clip> Sample(const WorkLimit& work) const {
    Clip clip;
    clip.skeleton = bones_.skeleton.skeleton;
    const Grid grid = MakeGrid();
    clip.rate_hz = grid.rate_hz;
    if (grid.cut) clip.remark = OnlyBegin(longest_s_);
    const auto frames =
        static_cast<std::size_t>(std::floor((grid.end_s - grid.begin_s) * grid.rate_hz + 1e-3)) + 1;
    clip.frames.reserve(frames);
    for (std::size_t frame = 0; frame < frames; ++frame) {
      if (frame % kFramesPerCheck == 0 && work.exceeded()) return work.Refusal();
      clip.frames.push_back(PoseAt(grid.begin_s + static_cast<double>(frame) / grid.rate_hz));
      const auto& places = clip.frames.back().translations;
      if (!std::all_of(places.begin(), places.end(), [](const Vec3& v) { return v.allFinite(); })) {
        return Status::Error(
            "found scales and translations of more than a number holds, expected "
            "a humanoid's");
      }
      if (frame > 0) KeepSigns(clip.frames[frame - 1], clip.frames[frame]);
    }
    return clip;
  }

 private:
  struct Grid {
    double begin_s = kLatest_s, end_s = 0, rate_hz = kSlowest_hz;
    bool cut = false;  // the motion continues
  };
  Grid MakeGrid() const {
    Grid grid;
    const auto look = [&grid](const Track& track) {
      if (track.empty()) return;
      const double first = static_cast<double>(track.times_s().front());
      const double last = static_cast<double>(track.times_s().back());
      grid.begin_s = std::min(grid.begin_s, first);
      grid.end_s = std::max(grid.end_s, last);
      if (last <= first) return;
      grid.rate_hz =
          std::max(grid.rate_hz, static_cast<double>(track.times_s().size() - 1) / (last - first));
    };
    for (const NodeTracks& tracks : tracks_) {
      look(tracks.rotation);
      look(tracks.translation);
    }
    grid.cut = grid.end_s - grid.begin_s > longest_s_;
    if (grid.cut) grid.end_s = grid.begin_s + longest_s_;
    grid.rate_hz = std::min(std::round(grid.rate_hz), kFastest_hz);
    const auto most = static_cast<double>((kSampledBytesPerByte * bytes_ + kSampledAllowance) /
                                          FrameBytes(bones_.nodes.size()));
    const double length_s = grid.end_s - grid.begin_s;
    if (length_s * grid.rate_hz > most) grid.rate_hz = std::floor(most / length_s);
    return grid;
  }
  Transform LocalAt(int node, double time_s) const {
    Transform local = nodes_.local(node);
    const NodeTracks& tracks = tracks_[static_cast<std::size_t>(moving_.place(node))];
    if (!tracks.rotation.empty()) {
      const Quat rotation(ValueOf(tracks.rotation, time_s));
      if (rotation.norm() > 1e-6F) local.rotation = rotation.normalized();
    }
    if (!tracks.translation.empty()) {
      local.translation = ValueOf(tracks.translation, time_s).head<3>();
    }
    return local;
  }
  rig::RigPose PoseAt(double time_s) const {
    rig::RigPose pose(bones_.skeleton.skeleton);
    Transform world;  // of the hips
    for (const int node : moving_.above()) world = world * LocalAt(node, time_s);
    std::vector<float> scales(bones_.nodes.size());
    for (std::size_t joint = 0; joint < bones_.nodes.size(); ++joint) {
      const int node = bones_.nodes[joint];
      const Transform local = LocalAt(node, time_s);
      if (joint == 0) {
        world = world * local;
        pose.translations[0] = world.translation;
        pose.rotations[0] = world.rotation;
        scales[0] = world.scale;
        continue;
      }
      const int parent = bones_.skeleton.skeleton.parents[joint];
      const float over = scales[static_cast<std::size_t>(parent)];
      scales[joint] = over * local.scale;
      pose.translations[joint] = over * local.translation;
      pose.rotations[joint] = local.rotation;
    }
    return pose;
  }
  static void KeepSigns(const rig::RigPose& before, rig::RigPose& pose) {
    for (std::size_t joint = 0; joint < pose.rotations.size(); ++joint) {
      Quat& rotation = pose.rotations[joint];
      if (rotation.dot(before.rotations[joint]) < 0) rotation.coeffs() = -rotation.coeffs();
    }
  }

  const gltf::Nodes& nodes_;
  const gltf::Bones& bones_;
  const MovingNodes& moving_;
  const std::vector<NodeTracks>& tracks_;
  std::size_t bytes_;
  double longest_s_;
};

// The first animation that turns a bone; an empty list if there is none.
Result<std::vector<NodeTracks>> FindTracks(const json& file, std::string_view data,
                                           const MovingNodes& moving) {
  const json& animations = Member(file, "animations");
  if (!animations.is_array() || animations.empty()) {
    return Status::Error("found no animation, expected one of the humanoid's bones");
  }
  Accessors accessors(file, data);
  for (const json& animation : animations) {
    auto tracks = ReadTracks(animation, moving, accessors);
    if (!tracks.ok() || !tracks.value().empty()) return tracks;
  }
  return Status::Error("found no animation that turns the humanoid's bones, expected one");
}

// For a refusal: the extensions without which, by the file's own word, it cannot be read. Those
// that are read, or are about meshes alone, are left out; "" if there are no others.
std::string Required(const json& file) {
  constexpr std::size_t kMost = 4, kMostName = 64;
  std::string names;
  std::size_t found = 0;
  for (const json& entry : Member(file, "extensionsRequired")) {
    if (!entry.is_string()) continue;
    const auto& name = entry.get_ref<const std::string&>();
    if (name == gltf::kMeshopt || name == "KHR_mesh_quantization" ||
        name == "KHR_draco_mesh_compression") {
      continue;
    }
    if (++found > kMost) break;
    names += (names.empty() ? "" : ", ") + gltf::Shown(name.substr(0, kMostName));
  }
  return names.empty() ? "" : "; it requires " + names + ", which is not read";
}

// VRMC_vrm_animation-1.0 requires a T-pose of the nodes, but exporters write what they have.
// Another pose, if it stands upright, is bound as that of a file without a table of bones.
void CheckTPose(GltfClip& read) {
  GltfSkeleton& of = read.skeleton;
  const auto binds = [&of](bool t_pose) {
    return rig::BindStanding(of.skeleton, of.source_joint, of.stance, t_pose).ok();
  };
  if (!of.t_pose || binds(true) || !binds(false)) return;
  of.t_pose = false;
  read.clip.remark +=
      std::string(read.clip.remark.empty() ? "" : "; ") +
      "the nodes of its VRM humanoid stand in no T-pose: it is found from how they stand";
}

Result<GltfClip> Read(std::string_view bytes, const ReadLimits& limits,
                      const rig::JointNames& joints) {
  const auto chunks = gltf::SplitGlb(bytes);
  if (!chunks.ok()) return gltf::Broken(chunks.status().message());
  auto file = gltf::ParseMotionJson(chunks.value().text, bytes.size());
  if (!file.ok()) return file.status();
  auto model = gltf::ReadModel(file.value());
  if (!model.ok()) return model.status();
  const auto nodes = gltf::Nodes::Make(model.value());
  if (!nodes.ok()) return nodes.status();
  auto bones = gltf::FindBones(model.value(), nodes.value(), joints);
  if (!bones.ok()) return bones.status();
  const MovingNodes moving(nodes.value(), bones.value(), model.value().nodes.size());
  // Before the animations, of each of which a table of these nodes is made.
  if (const std::size_t above = moving.above().size(); above > kMaxAbove) {
    return Status::Error("found " + std::to_string(above) +
                         " nodes above the hips, expected at most " + std::to_string(kMaxAbove));
  }
  if (limits.work.exceeded()) return limits.work.Refusal();
  const auto tracks = FindTracks(file.value(), chunks.value().data, moving);
  if (!tracks.ok()) return Status::Error(tracks.status().message() + Required(file.value()));
  // Freed, so that they are not in memory together with the frames.
  file.value() = json();
  model.value() = gltf::Model();
  const Sampler sampler(nodes.value(), bones.value(), moving, tracks.value(), bytes.size(),
                        limits.longest_s);
  if (const Status status = sampler.Check(); !status.ok()) return status;
  auto clip = sampler.Sample(limits.work);
  if (!clip.ok()) return clip.status();
  GltfClip read{std::move(clip.value()), std::move(bones.value().skeleton)};
  CheckTPose(read);
  return read;
}

}  // namespace

bool IsGltfBinary(std::string_view bytes) { return bytes.starts_with("glTF"); }

Result<GltfClip> ParseGltfClip(std::string_view bytes, const std::string& name,
                               const ReadLimits& limits, const rig::JointNames& joints) {
  auto clip = IsGltfBinary(bytes)
                  ? Read(bytes, limits, joints)
                  : Result<GltfClip>(Status::Error("expected glTF binary (.glb, .vrm, .vrma)"));
  return clip.ok() ? std::move(clip) : Status::Error(name + ": " + clip.status().message());
}

Result<rig::Binding> BindGltf(const GltfClip& clip, std::string_view dialect) {
  const GltfSkeleton& of = clip.skeleton;
  if (dialect != "auto" && !dialect.empty() && !of.t_pose) {
    return rig::BindDialect(of.skeleton, dialect);
  }
  auto bound = rig::BindStanding(of.skeleton, of.source_joint, of.stance, of.t_pose);
  if (bound.ok() || of.t_pose) return bound;
  auto standing = BindStanding(clip.clip);
  return standing.ok() ? standing : bound;
}

}  // namespace styled::clip
