#include "clients/rec/take.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "clients/cpp/transforms.h"
#include "clients/rec/rig_frames.h"
#include "model/base/crc32c.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"

namespace styled::rec {
namespace {

using rig::Quat;
using rig::Vec3;

constexpr std::size_t kMostBytes = std::size_t{2} << 30;  // of poses
constexpr std::uint64_t kBack_ns = 1'000'000'000, kJump_ns = 3600ULL * 1'000'000'000;

// A frame, from either of the two message types.
struct Frame {
  std::uint64_t body = 0;  // hash or crc that identifies the body
  std::uint64_t time_ns = 0;
  std::int64_t arrival_ns = 0;
  const google::protobuf::RepeatedField<float>* root = nullptr;
  const google::protobuf::RepeatedField<float>* rotations = nullptr;
};

// Finds the bodies and frames of one performer among the records.
class Finder {
 public:
  Finder(std::string performer, What what, std::string output, bool from_arrivals)
      : performer_(std::move(performer)),
        what_(what),
        output_(std::move(output)),
        from_arrivals_(from_arrivals) {
    const std::string name = what == What::kRig         ? "rig"
                             : what == What::kCanonical ? "canonical"
                                                        : output_;
    topic_ = what == What::kSource ? "source/" + performer_ + "/"
                                   : "styled/" + performer_ + "/" + name + "/";
    const std::size_t dot = performer_.find('.');
    source_ = performer_.substr(0, dot);
    name_ = dot == std::string::npos ? "" : performer_.substr(dot + 1);
  }

  const std::string& topic() const { return topic_; }
  const std::map<std::uint64_t, styled::v1::Body>& bodies() const { return bodies_; }

  // The frame in `record`, valid until the next call; empty if there is none.
  std::optional<Frame> Look(const recording::Record& record) {
    if (from_arrivals_) return record.has_arrival() ? LookAt(record) : std::nullopt;
    if (!record.has_published()) return std::nullopt;
    const std::string& payload = record.published().payload();
    if (record.published().topic() == "body/" + performer_ + "/") NoteBody(payload);
    if (record.published().topic() != topic_ || !frame_.ParseFromString(payload) ||
        (frame_.flags() & styled::v1::FLAG_STALE) != 0) {
      return std::nullopt;
    }
    return Frame{frame_.body_hash(), frame_.source_time_ns(), record.time_ns(),
                 &frame_.root_position(), &frame_.rotations()};
  }

 private:
  void NoteBody(const std::string& payload) {
    styled::v1::Body body;
    const auto output = what_ == What::kCanonical ? styled::v1::OUTPUT_CANONICAL
                        : what_ == What::kAvatar  ? styled::v1::OUTPUT_AVATAR
                                                  : styled::v1::OUTPUT_RIG;
    if (!body.ParseFromString(payload) || body.output() != output ||
        (what_ == What::kAvatar && body.output_name() != output_) ||
        client::Validate(body) != client::BodyError::kNone) {
      return;
    }
    bodies_[body.hash()] = std::move(body);
  }

  std::optional<Frame> LookAt(const recording::Record& record) {
    native::Datagram datagram;
    const auto bytes = std::as_bytes(std::span(record.arrival().datagram()));
    if (record.arrival().source() != source_ ||
        native::Decode(bytes, datagram) != native::DecodeResult::kOk) {
      return std::nullopt;
    }
    const auto size = static_cast<int>(datagram.payload.size());
    if (datagram.kind == native::Kind::kBody) {
      styled::v1::Body body;
      if (body.ParseFromArray(datagram.payload.data(), size) && body.performer() == name_ &&
          client::Validate(body) == client::BodyError::kNone) {
        last_body_ = Crc32c(datagram.payload);
        bodies_[last_body_] = std::move(body);
      }
      return std::nullopt;
    }
    if (!source_frame_.ParseFromArray(datagram.payload.data(), size) ||
        source_frame_.performer() != name_) {
      return std::nullopt;
    }
    const std::uint64_t named = source_frame_.body_crc();
    return Frame{named != 0 ? named : last_body_, source_frame_.source_time_ns(), record.time_ns(),
                 &source_frame_.root_position(), &source_frame_.rotations()};
  }

  std::string performer_, topic_, source_, name_;
  What what_;
  std::string output_;
  bool from_arrivals_;
  std::map<std::uint64_t, styled::v1::Body> bodies_;
  std::uint64_t last_body_ = 0;
  styled::v1::Frame frame_;
  styled::v1::SourceFrame source_frame_;
};

// Joins the source times of several sessions.
class Timeline {
 public:
  // Seconds since the first frame; empty if the frame is not after the previous one.
  std::optional<double> Next(const Frame& frame, std::uint64_t& restarts) {
    const bool first = !started_;
    started_ = true;
    if (!first && frame.time_ns <= last_ns_ && last_ns_ - frame.time_ns < kBack_ns) {
      return std::nullopt;
    }
    if (first) {
      begin_ns_ = frame.time_ns;
    } else if (frame.time_ns <= last_ns_ || frame.time_ns - last_ns_ > kJump_ns) {
      // The clock restarted: continue by the time between the arrivals, at least 1 ms.
      ++restarts;
      const double silence_ns =
          std::max(static_cast<double>(frame.arrival_ns) - static_cast<double>(arrival_ns_), 1e6);
      before_s_ += static_cast<double>(last_ns_ - begin_ns_) * 1e-9 + silence_ns * 1e-9;
      begin_ns_ = frame.time_ns;
    }
    last_ns_ = frame.time_ns;
    arrival_ns_ = frame.arrival_ns;
    return before_s_ + static_cast<double>(last_ns_ - begin_ns_) * 1e-9;
  }

 private:
  bool started_ = false;
  std::uint64_t begin_ns_ = 0, last_ns_ = 0;
  std::int64_t arrival_ns_ = 0;
  double before_s_ = 0;
};

// Lists what can be exported, for an error message.
std::string Holdings(recording::Reader& reader) {
  std::set<std::string> held;
  reader.Rewind();
  recording::Record record;
  while (reader.Next(record) && held.size() < 12) {
    const std::string& topic = record.published().topic();
    if (topic.starts_with("styled/") || topic.starts_with("source/")) held.insert(topic);
    if (record.has_arrival()) {
      held.insert("arrivals of source " + record.arrival().source() + " (" +
                  record.arrival().type() + ")");
    }
  }
  std::string text;
  for (const std::string& one : held) text += (text.empty() ? "" : ", ") + one;
  return text.empty() ? "nothing to export" : text;
}

// Counts the frames of each body.
std::map<std::uint64_t, std::uint64_t> CountBodies(recording::Reader& reader, Finder& finder) {
  std::map<std::uint64_t, std::uint64_t> used;
  reader.Rewind();
  recording::Record record;
  while (reader.Next(record)) {
    if (const auto frame = finder.Look(record)) ++used[frame->body];
  }
  return used;
}

// The signed source axis with the largest component from one joint to another; zero without these
// joints.
Vec3 AxisBetween(const std::vector<Vec3>& places, int from, int to) {
  Vec3 axis = Vec3::Zero();
  if (from < 0 || to < 0) return axis;
  const Vec3 way = places[static_cast<std::size_t>(to)] - places[static_cast<std::size_t>(from)];
  Eigen::Index longest = 0;
  way.cwiseAbs().maxCoeff(&longest);
  axis[longest] = way[longest] < 0 ? -1.0F : 1.0F;
  return axis;
}

// Derives the axes from the T-pose, and the unit if it is not given, as the daemon's binding does
// (daemon/perform/performer/body_binding.cpp).
void ReadRest(Take& take) {
  const auto& skeleton = take.skeleton;
  rig::BindingSpec spec;
  spec.skeleton = skeleton;
  spec.rest_rotations = take.rest;
  spec.source_joint = rig::MapJointNames(skeleton);
  std::vector<Vec3> places(skeleton.offsets);
  for (std::size_t j = 1; j < places.size(); ++j) {
    const auto parent = static_cast<std::size_t>(skeleton.parents[j]);
    places[j] = places[parent] + take.rest[parent] * skeleton.offsets[j];
  }
  const auto& joint = spec.source_joint;
  const Vec3 up = AxisBetween(places, joint[body::kHips], joint[body::kHead]);
  const Vec3 left = AxisBetween(places, joint[body::kRightUpperArm], joint[body::kLeftUpperArm]);
  // Not a humanoid: leave it unchanged.
  if (up.isZero() || left.isZero() || up.dot(left) != 0) return;
  Eigen::Matrix3f axes;
  axes.row(0) = left;
  axes.row(1) = up;
  axes.row(2) = left.cross(up);
  spec.canonical_from_source = take.canonical_from_source = Quat(axes).normalized();
  if (take.unit_known) return;
  const auto binding = rig::Binding::Make(std::move(spec));
  if (binding.ok()) take.metres_per_unit = binding.value().scale();
}

void FindMeasures(const styled::v1::Body& body, Take& take) {
  const float unit_m = body.metres_per_unit();
  take.unit_known = unit_m > 0 && std::isfinite(unit_m);
  take.metres_per_unit = take.unit_known ? unit_m : 1;
  std::vector<Quat> rest;
  for (int j = 0; 4 * j < body.rest_size(); ++j) {
    rest.emplace_back(body.rest(4 * j + 3), body.rest(4 * j), body.rest(4 * j + 1),
                      body.rest(4 * j + 2));
    if (!(std::abs(rest.back().norm() - 1) < 1e-3F)) return;
  }
  if (rest.empty()) return;
  take.rest = std::move(rest);
  ReadRest(take);
}

void SetSkeleton(const styled::v1::Body& body, Take& take) {
  for (int j = 0; j < body.names_size(); ++j) {
    take.skeleton.names.push_back(body.names(j));
    take.skeleton.parents.push_back(body.parents(j));
    take.skeleton.offsets.emplace_back(body.offsets(3 * j), body.offsets(3 * j + 1),
                                       body.offsets(3 * j + 2));
  }
}

// Adds a frame. False, and nothing is added, if it is not a pose of the skeleton. Joints without a
// rotation keep that of the previous frame.
bool AddPose(const Frame& frame, Take& take) {
  const int joints = take.skeleton.joint_count();
  if (frame.root->size() != 3 || frame.rotations->size() != 4 * joints) return false;
  const Vec3 root(frame.root->Get(0), frame.root->Get(1), frame.root->Get(2));
  if (!root.allFinite()) return false;
  rig::RigPose pose(take.skeleton);
  pose.translations[0] = root;
  for (int j = 0; j < joints; ++j) {
    const float* const q = frame.rotations->data() + 4 * j;
    Quat rotation(q[3], q[0], q[1], q[2]);
    const float square = rotation.squaredNorm();
    auto& place = pose.rotations[static_cast<std::size_t>(j)];
    if (!take.frames.empty()) place = take.frames.back().rotations[static_cast<std::size_t>(j)];
    if (!std::isfinite(square) || square < 1e-6F) continue;
    rotation.coeffs() /= std::sqrt(square);
    if (rotation.dot(place) < 0) rotation.coeffs() = -rotation.coeffs();
    place = rotation;
  }
  take.frames.push_back(std::move(pose));
  return true;
}

// Shifts the times to begin with 0, and removes the part of a pause beyond kLongestPause_s.
void ShortenPauses(Take& take) {
  double before_s = take.times_s.front(), left_out_s = before_s;
  for (double& time_s : take.times_s) {
    const double pause_s = time_s - std::exchange(before_s, time_s);
    if (pause_s > kLongestPause_s) {
      ++take.pauses;
      take.left_out_s += pause_s - kLongestPause_s;
      left_out_s += pause_s - kLongestPause_s;
    }
    time_s -= left_out_s;
  }
}

}  // namespace

Result<Take> ReadTake(recording::Reader& reader, const std::string& performer, What what,
                      const std::string& output) {
  Finder finder(performer, what, output, false);
  auto used = CountBodies(reader, finder);
  if (used.empty() && what == What::kSource) {
    finder = Finder(performer, what, output, true);
    used = CountBodies(reader, finder);
  }
  if (used.empty()) {
    return Status::Error(reader.name() + ": found no frames of " + finder.topic() +
                         "; it holds: " + Holdings(reader));
  }
  std::uint64_t chosen = 0, most = 0;
  for (const auto& [body, count] : used) {
    if (count <= most || !finder.bodies().contains(body)) continue;
    chosen = body;
    most = count;
  }
  if (most == 0) {
    return Status::Error(reader.name() + ": found no body that the frames of " + finder.topic() +
                         " are on; expected one on body/" + performer + "/");
  }
  Take take;
  take.performer = performer;
  SetSkeleton(finder.bodies().at(chosen), take);
  FindMeasures(finder.bodies().at(chosen), take);
  Timeline timeline;
  reader.Rewind();
  recording::Record record;
  while (reader.Next(record)) {
    const auto frame = finder.Look(record);
    if (!frame) continue;
    if (frame->body != chosen) {
      ++(finder.bodies().contains(frame->body) ? take.on_other_bodies : take.unusable);
      continue;
    }
    const auto time_s = timeline.Next(*frame, take.restarts);
    if (!time_s) continue;
    if (take.frames.size() >= kMostBytes / clip::FrameBytes(take.skeleton.names.size())) {
      return Status::Error(reader.name() + ": found more than " +
                           std::to_string(take.frames.size()) + " frames of " + finder.topic() +
                           ", expected at most 2 GiB of poses");
    }
    if (AddPose(*frame, take)) {
      take.times_s.push_back(*time_s);
    } else {
      ++take.unusable;
    }
  }
  if (take.frames.empty()) {
    return Status::Error(reader.name() + ": found no frame of " + finder.topic() +
                         " that is a pose of its body");
  }
  ShortenPauses(take);
  return take;
}

}  // namespace styled::rec
