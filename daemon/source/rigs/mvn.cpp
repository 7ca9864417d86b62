#include "daemon/source/rigs/mvn.h"

#include <algorithm>
#include <optional>

#include "daemon/runtime/clock.h"
#include "daemon/source/note_limit.h"
#include "daemon/source/performer_stream.h"
#include "daemon/source/props.h"
#include "daemon/source/rigs/world_pose.h"
#include "proto/rigs/mvn/mvn.h"

namespace styled::source {
namespace {

using runtime::Counter;

// How long a new character may remain without name and T-pose: MVN sends them once a second.
constexpr std::int64_t kMvnPatience_ns = 3 * runtime::kSecond_ns / 2;
// A sample this far behind the newest one means a restart, not a late sample.
constexpr std::uint32_t kRestartSamples = 240;
constexpr std::size_t kMaxCharacters = 64;
constexpr int kHead = 6, kHandSegments = 20;

// The body, then for each hand: carpus, a thumb of three segments, four fingers of four.
rig::Skeleton MakeSkeleton(bool fingers) {
  rig::Skeleton skeleton;
  const auto add = [&skeleton](std::string name, int parent) {
    skeleton.names.push_back(std::move(name));
    skeleton.parents.push_back(parent);
    skeleton.offsets.emplace_back(rig::Vec3::Zero());
    return skeleton.joint_count() - 1;
  };
  for (const auto& row : mvn::kSegments) add(std::string(row.name), row.parent);
  for (const std::string side : {"Left", "Right"}) {
    if (!fingers) break;
    const int carpus = add(side + "Carpus", side == "Left" ? 14 : 10);
    for (const std::string finger : {"First", "Second", "Third", "Fourth", "Fifth"}) {
      int parent = add(side + finger + "MC", carpus);
      parent = add(side + finger + "PP", parent);
      if (finger != "First") parent = add(side + finger + "MP", parent);
      add(side + finger + "DP", parent);
    }
  }
  return skeleton;
}

class Character {
 public:
  Character(std::uint64_t peer, std::uint8_t id, std::int64_t now_ns, NoteLimit& incomplete_notes)
      : peer_(peer),
        id_(id),
        since_ns_(now_ns),
        seen_ns_(now_ns),
        incomplete_notes_(incomplete_notes) {}

  bool Is(std::uint64_t peer, std::uint8_t id) const { return peer_ == peer && id_ == id; }
  std::int64_t seen_ns() const { return seen_ns_; }
  std::uint8_t id() const { return id_; }
  std::string_view performer() const { return stream_ ? stream_->performer() : std::string_view(); }
  const std::string& called() const { return called_; }

  void HandleName(std::string_view name) {
    if (!stream_ && !name.empty()) called_ = MakeName(name);
  }
  void HandleScale(const mvn::Scale& scale, Outbox& out);
  STYLED_REALTIME void HandleTimecode(const mvn::Timecode& given) noexcept {
    timecode_ = {given.hours, given.minutes, given.seconds, given.milliseconds, 1000, false};
    has_timecode_ = true;
  }
  // Handles one datagram's part of a pose. `performer` supplies the name once it is needed.
  template <typename MakePerformer>
  void HandlePose(const mvn::Header& header, const mvn::Pose& pose, const std::string& up,
                  std::int64_t now_ns, const MakePerformer& performer, Outbox& out);

 private:
  enum class Order { kNext, kOld };
  Order Sort(const mvn::Header& header, std::int64_t now_ns, Outbox& out);
  bool Gather(const mvn::Header& header, const mvn::Pose& pose, std::int64_t now_ns, Outbox& out);
  void ReportIncomplete(std::int64_t now_ns, Outbox& out);
  void ReportMissingInput(Outbox& out);
  void MakeBody(const mvn::Header& header, const std::string& up, Outbox& out);
  void Send(const mvn::Header& header, std::int64_t now_ns, Outbox& out);
  // Props are between the body and the fingers.
  std::size_t SegmentOf(std::size_t joint) const noexcept {
    return joint + (joint < mvn::kBodySegments ? 0 : static_cast<std::size_t>(props_));
  }
  void NameProps(const mvn::Scale& scale, Outbox& out);

  std::uint64_t peer_;
  std::uint8_t id_;
  std::int64_t since_ns_, seen_ns_;
  NoteLimit& incomplete_notes_;  // shared by all characters
  std::string called_;
  std::optional<PerformerStream> stream_;
  std::array<rig::Vec3, mvn::kBodySegments> scale_m_;  // T-pose, +Z up
  bool has_scale_ = false;
  bool y_up_ = false;  // type 02 of a sender that is set to +Y up
  mvn::Type type_ = mvn::Type::kEuler;
  std::uint32_t sample_ = 0;
  // State of the current sample: sent, or incomplete and counted.
  bool any_sample_ = false, sent_ = false, incomplete_ = false;
  std::array<rig::Vec3, mvn::kMaxSegments> positions_;
  std::array<rig::Quat, mvn::kMaxSegments> rotations_;
  int gathered_ = 0, wanted_ = 0, next_part_ = 0;
  mvn::Type gathered_type_ = mvn::Type::kEuler;
  int props_ = 0;  // number in the last sample
  std::array<std::string, mvn::kMaxProps> prop_names_{"Prop1", "Prop2", "Prop3", "Prop4"};
  std::vector<rig::Quat> joint_rotations_;
  rig::RigBody body_;
  rig::RigPose pose_;
  Timecode timecode_;
  bool has_timecode_ = false;
};

void Character::HandleScale(const mvn::Scale& scale, Outbox& out) {
  if (scale.count < mvn::kBodySegments) return;
  for (std::size_t s = 0; s < mvn::kBodySegments; ++s) {
    const auto& p = scale.segments[s].position_m;
    scale_m_[s] = {p[0], p[1], p[2]};
  }
  has_scale_ = true;
  NameProps(scale, out);
  if (!stream_ || !stream_->has_body()) return;
  // The T-pose arrived after the body was made: it changes the body, if it differs.
  mvn::Header header;
  header.type = type_;
  header.finger_segments =
      body_.skeleton.joint_count() > mvn::kBodySegments ? 2 * kHandSegments : 0;
  MakeBody(header, y_up_ ? "y" : "z", out);
}

// The rows of type 13 are in the order of a sample's segments.
void Character::NameProps(const mvn::Scale& scale, Outbox& out) {
  constexpr int kHands = 2 * kHandSegments;
  const int others = scale.count - mvn::kBodySegments;
  const int props = others >= kHands ? others - kHands : others;
  for (int i = 0; i < mvn::kMaxProps; ++i) {
    const auto row = static_cast<std::size_t>(mvn::kBodySegments + i);
    const std::string usual = "Prop" + std::to_string(i + 1);  // too short to allocate
    const bool named = i < props && !scale.segments[row].name.empty();
    const std::string_view name = named ? scale.segments[row].name : std::string_view(usual);
    std::string& kept = prop_names_[static_cast<std::size_t>(i)];
    if (kept == name) continue;
    out.LeaveHotSection();
    kept = name;
  }
}

Character::Order Character::Sort(const mvn::Header& header, std::int64_t now_ns, Outbox& out) {
  if (any_sample_ && header.sample < sample_ && sample_ - header.sample < kRestartSamples) {
    out.Refuse(Counter::kPipelineReordered);
    return Order::kOld;
  }
  if (any_sample_ && header.sample == sample_ && sent_) {
    // A part that the headers did not announce is not an error if the pose was complete without it.
    if (header.datagram < next_part_) out.Refuse(Counter::kPipelineDuplicate);
    return Order::kOld;
  }
  if (any_sample_ && header.sample < sample_ && stream_) stream_->Restart();
  if (!any_sample_ || header.sample != sample_) {
    if (any_sample_ && !sent_) ReportIncomplete(now_ns, out);
    gathered_ = next_part_ = 0;
    sent_ = incomplete_ = false;
  }
  sample_ = header.sample;
  any_sample_ = true;
  return Order::kNext;
}

// Collects the parts of a sample. Returns true once all segments that the headers announce are
// there; not every sender marks the last datagram. A missing part leaves the sample incomplete.
bool Character::Gather(const mvn::Header& header, const mvn::Pose& pose, std::int64_t now_ns,
                       Outbox& out) {
  wanted_ = mvn::kBodySegments + header.props + header.finger_segments;
  // The sample number is the same, but the sample begins again.
  if (header.datagram == 0 && next_part_ > 0) {
    ReportIncomplete(now_ns, out);
    gathered_ = next_part_ = 0;
    incomplete_ = false;
  }
  if (header.datagram == next_part_ && gathered_ + pose.count <= mvn::kMaxSegments &&
      (next_part_ == 0 || header.type == gathered_type_)) {
    gathered_type_ = header.type;
    ++next_part_;
    for (int i = 0; i < pose.count; ++i) {
      const auto& segment = pose.segments[static_cast<std::size_t>(i)];
      const auto& r = segment.rotation;
      positions_[static_cast<std::size_t>(gathered_)] = {segment.position[0], segment.position[1],
                                                         segment.position[2]};
      rotations_[static_cast<std::size_t>(gathered_)] = {r[3], r[0], r[1], r[2]};
      ++gathered_;
    }
    if (gathered_ >= wanted_) return true;
  }
  if (header.last) ReportIncomplete(now_ns, out);
  return false;
}

// Counts and logs an incomplete sample, once.
void Character::ReportIncomplete(std::int64_t now_ns, Outbox& out) {
  if (incomplete_) return;
  incomplete_ = true;
  out.Refuse(Counter::kSourceIncomplete);
  const std::uint64_t times = incomplete_notes_.Count(now_ns);
  if (times == 0) return;
  out.Note([&] {
    return "character " + std::to_string(id_) + ": " + std::to_string(gathered_) + " of " +
           std::to_string(wanted_) +
           " segments of a sample arrived, in order from its first datagram: no frame is made" +
           Times(times);
  });
}

// Logged once per character: it continues without the missing data, named after the source, with
// the bones of its first pose.
void Character::ReportMissingInput(Outbox& out) {
  out.Note([&] {
    return "character " + std::to_string(id_) + " sends " +
           (called_.empty() && !has_scale_ ? "neither name (type 12) nor T-pose (type 13)"
            : called_.empty()              ? "no name (type 12)"
                                           : "no T-pose (type 13)") +
           ", expected both within 1.5 s: it continues as " + stream_->performer() +
           (has_scale_ ? "" : ", with the bones of its first pose") +
           ". Switch on character information and scaling in MVN's network streamer";
  });
}

void Character::MakeBody(const mvn::Header& header, const std::string& up, Outbox& out) {
  out.LeaveHotSection();
  const bool fingers = header.finger_segments == 2 * kHandSegments;
  const bool euler = header.type == mvn::Type::kEuler;
  type_ = header.type;
  body_.skeleton = MakeSkeleton(fingers);
  body_.metres_per_unit = euler ? 0.01F : 1.0F;
  const auto joints = static_cast<std::size_t>(body_.skeleton.joint_count());
  joint_rotations_.resize(joints, rig::Quat::Identity());
  pose_ = rig::RigPose(body_.skeleton);
  if (!euler) {
    const rig::Vec3 spine = positions_[kHead] - positions_[0];
    y_up_ = up == "y" || (up == "auto" && std::abs(spine.y()) > std::abs(spine.z()));
  }
  std::vector<rig::Vec3> positions(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const std::size_t s = SegmentOf(j);
    positions[j] = positions_[s];
    joint_rotations_[j] = rotations_[s];
  }
  OffsetsFromWorld(body_.skeleton.parents, positions, joint_rotations_, body_.skeleton.offsets);
  // The T-pose is +Z up, +X forward. Cycling the axes makes it +Y up, +Z forward.
  for (std::size_t j = 0; has_scale_ && j < mvn::kBodySegments; ++j) {
    const int parent = body_.skeleton.parents[j];
    rig::Vec3 offset = scale_m_[j];
    if (parent >= 0) offset -= scale_m_[static_cast<std::size_t>(parent)];
    if (euler || y_up_) offset = {offset.y(), offset.z(), offset.x()};
    body_.skeleton.offsets[j] = offset / body_.metres_per_unit;
  }
  stream_->SetBody(body_, out);
}

template <typename MakePerformer>
void Character::HandlePose(const mvn::Header& header, const mvn::Pose& pose, const std::string& up,
                           std::int64_t now_ns, const MakePerformer& performer, Outbox& out) {
  seen_ns_ = now_ns;
  // The sender sends both types.
  if (header.type == mvn::Type::kEuler && type_ == mvn::Type::kQuaternion) return;
  if (Sort(header, now_ns, out) == Order::kOld || !Gather(header, pose, now_ns, out)) return;
  sent_ = true;
  props_ = header.props;
  if (!stream_) {
    if ((called_.empty() || !has_scale_) && now_ns - since_ns_ < kMvnPatience_ns) {
      return out.Refuse(Counter::kSourceBeforeRestPose);
    }
    out.LeaveHotSection();
    stream_.emplace(performer(*this));
    if (called_.empty() || !has_scale_) ReportMissingInput(out);
  }
  const bool fingers = header.finger_segments == 2 * kHandSegments;
  if (!stream_->has_body() || header.type != type_ ||
      fingers != (body_.skeleton.joint_count() > mvn::kBodySegments)) {
    MakeBody(header, up, out);
  }
  Send(header, now_ns, out);
}

void Character::Send(const mvn::Header& header, std::int64_t now_ns, Outbox& out) {
  for (std::size_t j = 0; j < joint_rotations_.size(); ++j) {
    joint_rotations_[j] = rotations_[SegmentOf(j)];
  }
  LocalFromWorld(body_.skeleton.parents, joint_rotations_, pose_);
  pose_.translations.front() = positions_.front();
  PerformerStream::FrameInfo info;
  info.source_time_ns = std::uint64_t{header.time_ms} * 1'000'000;
  info.now_ns = now_ns;
  info.timecode = has_timecode_ ? &timecode_ : nullptr;
  PropList props;
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::min(props_, mvn::kMaxProps)); ++i) {
    const std::size_t s = mvn::kBodySegments + i;
    props.Add({prop_names_[i], positions_[s], rotations_[s]});
  }
  info.props = props.all();
  stream_->Send(pose_, info, out);
}

class Mvn final : public Translator {
 public:
  explicit Mvn(const config::Source& config) : config_(config) {}

  void Handle(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
              Outbox& out) override {
    mvn::Header header;
    if (mvn::DecodeHeader(datagram, header) != mvn::DecodeResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    switch (header.type) {
      case mvn::Type::kEuler:
      case mvn::Type::kQuaternion:
        return HandlePose(datagram, peer, now_ns, out);
      case mvn::Type::kMeta: {
        std::string_view name;
        if (mvn::DecodeName(datagram, name) != mvn::DecodeResult::kOk) break;
        if (auto* character = Find(header, peer, now_ns, out)) character->HandleName(name);
        return;
      }
      case mvn::Type::kScale: {
        if (mvn::DecodeScale(datagram, scale_) != mvn::DecodeResult::kOk) break;
        if (auto* character = Find(header, peer, now_ns, out)) character->HandleScale(scale_, out);
        return;
      }
      case mvn::Type::kTimecode: {
        mvn::Timecode timecode;
        if (mvn::DecodeTimecode(datagram, timecode) != mvn::DecodeResult::kOk) break;
        if (auto* character = Find(header, peer, now_ns, out)) character->HandleTimecode(timecode);
        return;
      }
      default:
        return out.Refuse(Counter::kSourceIgnored);
    }
    out.Refuse(Counter::kSourceMalformed);
  }

 private:
  void HandlePose(std::span<const std::byte> datagram, const Peer& peer, std::int64_t now_ns,
                  Outbox& out) {
    mvn::Header header;
    if (mvn::DecodePose(datagram, header, pose_) != mvn::DecodeResult::kOk) {
      return out.Refuse(Counter::kSourceMalformed);
    }
    Character* character = Find(header, peer, now_ns, out);
    if (character == nullptr) return out.Refuse(Counter::kPipelinePerformersRefused);
    character->HandlePose(
        header, pose_, config_.up, now_ns,
        [this](const Character& who) { return PerformerOf(who); }, out);
  }

  // Returns null if there are kMaxCharacters and none of them was silent for 10 s.
  Character* Find(const mvn::Header& header, const Peer& peer, std::int64_t now_ns, Outbox& out) {
    for (auto& character : characters_) {
      if (character->Is(peer.id, header.character)) return character.get();
    }
    out.LeaveHotSection();
    if (characters_.size() >= kMaxCharacters) {
      std::erase_if(characters_, [now_ns](const auto& character) {
        return now_ns - character->seen_ns() > 10 * runtime::kSecond_ns;
      });
    }
    if (characters_.size() >= kMaxCharacters) return nullptr;
    characters_.push_back(
        std::make_unique<Character>(peer.id, header.character, now_ns, incomplete_notes_));
    return characters_.back().get();
  }

  // A name that no other character of the same sender has.
  std::string PerformerOf(const Character& who) const {
    std::string name = config_.performer;
    if (name.empty()) name = who.called().empty() ? config_.name : who.called();
    const std::string stem = name.substr(0, 28);
    for (int i = 2; IsInUse(name, who); ++i) name = stem + "-" + std::to_string(i);
    return name;
  }
  // Another sender's character may have the same name: the pipeline admits one sender at a time.
  bool IsInUse(std::string_view name, const Character& who) const {
    return std::any_of(characters_.begin(), characters_.end(), [&](const auto& other) {
      return other->id() != who.id() && other->performer() == name;
    });
  }

  config::Source config_;
  NoteLimit incomplete_notes_;
  std::vector<std::unique_ptr<Character>> characters_;
  mvn::Pose pose_;
  mvn::Scale scale_;
};

}  // namespace

std::unique_ptr<Translator> MakeMvn(const config::Source& config) {
  return std::make_unique<Mvn>(config);
}

}  // namespace styled::source
