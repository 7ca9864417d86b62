#include "daemon/source/rigs/tracker_rig.h"

#include <algorithm>
#include <utility>

#include "daemon/config/sources.h"
#include "model/body/find_joint.h"

namespace styled::source {
namespace {

// SlimeVR's TrackerPosition.kt: the positions that a tracker can report. 1 is the head; 0 is
// unused, and the positions beyond are fingers.
constexpr std::array<int, 21> kPartOfPosition{TrackerRig::kUnassigned,
                                              body::kHead,
                                              body::kNeck,
                                              body::kChest,
                                              body::kChest,
                                              body::kSpine,
                                              body::kHips,
                                              body::kLeftUpperLeg,
                                              body::kRightUpperLeg,
                                              body::kLeftLowerLeg,
                                              body::kRightLowerLeg,
                                              body::kLeftFoot,
                                              body::kRightFoot,
                                              body::kLeftLowerArm,
                                              body::kRightLowerArm,
                                              body::kLeftUpperArm,
                                              body::kRightUpperArm,
                                              body::kLeftHand,
                                              body::kRightHand,
                                              body::kLeftShoulder,
                                              body::kRightShoulder};

std::string TrackedPart(int part) {
  return std::string(body::kHumanoid[static_cast<std::size_t>(part)].name);
}

std::string PartNames(std::uint32_t bits) {
  std::string names;
  for (int j = 0; j < body::kJointCount; ++j) {
    if ((bits >> static_cast<unsigned>(j) & 1U) == 0) continue;
    names += (names.empty() ? "" : ", ") + TrackedPart(j);
  }
  return names;
}

}  // namespace

TrackerRig::TrackerRig(const config::Source& config) : trackers_(options_), stream_(config) {
  const Status status = config::CheckTrackers(config.trackers);
  if (!status.ok()) note_ = status.message() + "; it is left out";
  for (const auto& [id_text, part_text] : config.trackers) {
    const auto id = slimevr::ParseTrackerId(id_text);
    const int part = body::FindJoint(part_text);
    if (id && part >= 0) assigned_.push_back({*id, part});
  }
}

std::vector<std::uint64_t> TrackerRig::ConfiguredDevices() const {
  std::vector<std::uint64_t> addresses;
  for (const Known& row : assigned_) {
    if (std::ranges::find(addresses, row.id.address) == addresses.end()) {
      addresses.push_back(row.id.address);
    }
  }
  return addresses;
}

int TrackerRig::FreePart(int position) const {
  if (position <= 0 || position >= static_cast<int>(kPartOfPosition.size())) return kUnassigned;
  const int part = kPartOfPosition[static_cast<std::size_t>(position)];
  const auto has_it = [part](const Known& row) { return row.part == part; };
  if (std::ranges::any_of(assigned_, has_it) || std::ranges::any_of(known_, has_it)) {
    return kUnassigned;
  }
  return part;
}

int TrackerRig::PartOf(const slimevr::TrackerId& id, int position, std::int64_t now_ns,
                       Outbox& out) {
  const auto row = std::ranges::find(assigned_, id, &Known::id);
  if (row != assigned_.end()) {
    if (!row->logged) ReportPart(id, row->part, now_ns, out);
    row->logged = true;
    return row->part;
  }
  const auto found = std::ranges::find(known_, id, &Known::id);
  if (found != known_.end() && (found->part != kUnassigned || position == 0)) return found->part;
  const int part = FreePart(position);
  if (found != known_.end()) {
    if (part == kUnassigned) return part;
    found->part = part;
  } else {
    out.LeaveHotSection();
    // Trackers can be forged, so a tracker without a joint is replaced. There are fewer joints than
    // kMaxKnown.
    if (known_.size() == kMaxKnown) {
      known_.erase(std::ranges::find(known_, kUnassigned, &Known::part));
    }
    known_.push_back({id, part});
  }
  ReportPart(id, part, now_ns, out);
  return part;
}

void TrackerRig::ReportPart(const slimevr::TrackerId& id, int part, std::int64_t now_ns,
                            Outbox& out) {
  const std::uint64_t times = part == kUnassigned ? strangers_.Count(now_ns) : 1;
  if (times == 0) return;
  out.Note([&] {
    return "tracker " + slimevr::ToText(id) +
           (part == kUnassigned ? " is assigned to no joint: assign it in `trackers`"
                                : " is worn on " + TrackedPart(part)) +
           (times > 1 ? "; so are " + std::to_string(times - 1) + " others" : "");
  });
  if (part != kUnassigned && !calibration_requested_) {
    out.Note([] {
      return "to be calibrated: a full reset, while the performer stands in a T-pose, looking "
             "ahead";
    });
    calibration_requested_ = true;
  }
}

// The sensors' world is +Z up. A rotation by -90 degrees about x, as in SlimeVR's server, makes it
// +Y up.
void TrackerRig::Accept(body::Joint part, const slimevr::Orientation& orientation,
                        std::int64_t now_ns) noexcept {
  if (!orientation.usable) return;
  constexpr float kHalfRoot = 0.70710678F;
  const rig::Quat y_up_from_z_up(kHalfRoot, -kHalfRoot, 0, 0);
  const auto& q = orientation.rotation;
  trackers_.Add(part, now_ns, (y_up_from_z_up * rig::Quat(q[3], q[0], q[1], q[2])).normalized());
  stream_.Wake(now_ns);
}

void TrackerRig::Tick(std::int64_t now_ns, Outbox& out) {
  if (!note_.empty()) {
    out.Note([this] { return std::exchange(note_, {}); });
  }
  stream_.Tick(now_ns, options_.delay_ns, out, [this](std::int64_t time_ns, body::Pose& pose) {
    return trackers_.Solve(time_ns, pose);
  });
}

Status TrackerRig::Calibrate(Calibration what, std::int64_t now_ns) {
  rig::Trackers::Outcome outcome;
  std::string why;
  switch (what) {
    case Calibration::kFull:
      outcome = trackers_.ResetFull(now_ns);
      break;
    case Calibration::kYaw:
      outcome = trackers_.ResetYaw(now_ns);
      why = " had no full reset";
      break;
    case Calibration::kMounting:
      outcome = trackers_.ResetMounting(now_ns);
      why = " had no full reset, or did not turn as in the ski pose since";
      break;
  }
  if (outcome.done == 0) {
    return Status::Error(outcome.left == 0 ? "no tracker that is assigned to a part is live"
                                           : PartNames(outcome.left) + why);
  }
  note_ = "calibrated " + PartNames(outcome.done);
  if (outcome.left != 0)
    note_ += "; left as they are, because they" + why + ": " + PartNames(outcome.left);
  stream_.Restart();
  return Status::Ok();
}

}  // namespace styled::source
