#include "daemon/source/rigs/device_rig.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <utility>

#include "model/base/text.h"
#include "model/body/find_joint.h"

namespace styled::source {
namespace {

using devices::Seen;
using runtime::Counter;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kFarthest_m = 1000;
// The accepted sizes of performers, relative to the canonical humanoid: avatars may be smaller and
// larger than people.
constexpr float kSmallest = 0.2F, kLargest = 5;
constexpr float kDegrees = 57.29578F;

std::string_view PartName(int part) { return body::kHumanoid[static_cast<std::size_t>(part)].name; }

bool IsSane(const DeviceRig::Measured& measured) {
  const auto sane = [](const auto& values, float most) {
    const bool none = values.array().isNaN().all();
    return none || (values.allFinite() && values.cwiseAbs().maxCoeff() <= most);
  };
  const auto& q = measured.rotation.coeffs();
  return sane(measured.position_m, kFarthest_m) && sane(q, 2) &&
         (q.array().isNaN().all() || q.norm() > 0.5F);
}

}  // namespace

DeviceRig::DeviceRig(const config::Source& config)
    : assigned_(config.trackers), devices_(options_), stream_(config) {
  known_.reserve(kMaxDevices);
}

int DeviceRig::PartOf(const Device& device) const {
  int part = device.usual_part;
  for (const config::Tracker& row : assigned_) {
    if (row.id == device.name) part = body::FindJoint(row.part);
  }
  // If `trackers` assigns a part to another device, this one does not get it by default.
  for (const config::Tracker& row : assigned_) {
    if (row.id != device.name && part >= 0 && row.part == PartName(part)) return Seen::kUnknown;
  }
  const bool taken = std::ranges::any_of(known_, [&](const Known& known) {
    return known.part == part && known.fixed && known.name != device.name;
  });
  return taken ? Seen::kUnknown : part;
}

DeviceRig::Known* DeviceRig::Find(const Device& device, std::uint64_t peer, std::int64_t now_ns,
                                  Outbox& out) {
  const auto found = std::ranges::find(known_, device.name, &Known::name);
  if (found != known_.end()) {
    if (found->peer != peer && now_ns - found->heard_ns <= kSilent_ns) {
      out.Refuse(Counter::kPipelineSecondSender);
      return nullptr;
    }
    found->peer = peer;
    return &*found;
  }
  out.LeaveHotSection();
  if (known_.size() == kMaxDevices) {
    const auto oldest = std::ranges::min_element(known_, {}, &Known::heard_ns);
    if (now_ns - oldest->heard_ns <= kSilent_ns) {
      out.Refuse(Counter::kSourceTableFull);
      return nullptr;
    }
    known_.erase(oldest);
  }
  const int part = PartOf(device);
  Known& known = known_.emplace_back();  // reserved
  known.name = device.name;
  known.is_head = device.is_head;
  known.at_joint = device.at_joint;
  known.peer = peer;
  known.part = part;
  known.fixed = part != Seen::kUnknown;
  for (Known& other : known_) {  // an explicit assignment replaces a guess
    if (!other.fixed && other.part == part) other.part = Seen::kUnknown;
  }
  known.last = {body::Vec3::Constant(kNan), body::Quat(kNan, kNan, kNan, kNan)};
  Introduce(known, now_ns, out);
  return &known;
}

void DeviceRig::Introduce(Known& known, std::int64_t now_ns, Outbox& out) {
  const std::uint64_t times = strangers_.Count(now_ns);
  if (times == 0) return;
  out.Note([&] {
    return "device \"" + Printable(known.name, 64) + "\" " +
           (known.fixed
                ? "is worn on " + std::string(PartName(known.part))
                : "is on no known part: a calibration guesses it, or `trackers` assigns it") +
           "; to be calibrated while the performer stands in a T-pose" + Times(times);
  });
}

void DeviceRig::Accept(const Device& device, const Measured& measured, std::uint64_t peer,
                       std::int64_t now_ns, Outbox& out) {
  const bool nothing = !measured.position_m.allFinite() && !measured.rotation.coeffs().allFinite();
  if (device.name.empty() || device.name.size() > 64 || !IsUtf8(device.name) || nothing ||
      !IsSane(measured)) {
    return out.Refuse(Counter::kSourceMalformed);
  }
  Known* const known = Find(device, peer, now_ns, out);
  if (known == nullptr) return;
  known->heard_ns = now_ns;
  body::Quat rotation = measured.rotation;
  if (measured.position_m.allFinite()) {
    known->last.position_m = measured.position_m;
    known->place_ns = now_ns;
  }
  if (rotation.coeffs().allFinite()) {
    rotation.normalize();
    known->last.rotation = rotation;
    known->rotation_ns = now_ns;
  }
  heard_ns_ = now_ns;
  if (known->part != Seen::kUnknown) {
    devices_.Add(body::Joint(known->part), now_ns, measured.position_m, rotation);
  }
  stream_.Wake(now_ns);
}

void DeviceRig::NoteHeading(float heading, std::uint64_t peer, std::int64_t now_ns,
                            Outbox& out) noexcept {
  const bool fresh = noted_.heard_ns != 0 && now_ns - noted_.heard_ns <= kSilent_ns;
  if (fresh && noted_.peer != peer) return out.Refuse(Counter::kPipelineSecondSender);
  noted_ = {heading, peer, now_ns};
}

void DeviceRig::Tick(std::int64_t now_ns, Outbox& out) {
  if (!note_.empty()) {
    out.Notice([this] { return std::exchange(note_, {}); });
  }
  stream_.Tick(now_ns, options_.delay_ns, out, [this](std::int64_t time_ns, body::Pose& pose) {
    if (calibrated_) return devices_.Solve(time_ns, pose);
    if (time_ns - heard_ns_ > options_.stale_ns) return false;
    pose = body::Pose();
    return true;
  });
}

bool DeviceRig::IsTurned(const Known& known, std::int64_t now_ns) const {
  return known.rotation_ns != 0 && now_ns - known.rotation_ns <= options_.stale_ns;
}

// The live devices and their performers. Changes nothing.
std::vector<Seen> DeviceRig::See(std::int64_t now_ns, std::vector<Known*>& who) {
  std::vector<Seen> seen;
  for (Known& known : known_) {
    if (known.place_ns == 0 || now_ns - known.place_ns > options_.stale_ns) continue;
    Seen device{.position_m = known.last.position_m,
                .is_head = known.is_head,
                .at_joint = known.at_joint,
                .part = known.fixed ? known.part : Seen::kUnknown};
    if (IsTurned(known, now_ns)) {
      device.rotation = known.last.rotation;
      device.has_rotation = true;
    } else if (device.part == body::kHead && noted_.heard_ns != 0 && noted_.peer == known.peer) {
      device.rotation = body::Quat(Eigen::AngleAxisf(noted_.heading, body::Vec3::UnitY()));
      device.has_rotation = true;
    }
    seen.push_back(device);
    who.push_back(&known);
  }
  return seen;
}

Status DeviceRig::Calibrate(Calibration what, std::int64_t now_ns) {
  if (what != Calibration::kFull) {
    return Status::Error(
        "these devices share one heading and are calibrated at once; expected a full calibration "
        "in the T-pose");
  }
  std::vector<Known*> who;
  std::vector<Seen> seen = See(now_ns, who);
  if (seen.empty()) return Status::Error("no live device reports its position");
  devices::GuessParts(seen);
  const devices::Stance stance = devices::FindStance(seen);
  if (!(stance.scale >= kSmallest && stance.scale <= kLargest)) {
    char text[16];
    std::snprintf(text, sizeof text, "%.2f", static_cast<double>(stance.scale));
    return Status::Error(std::string("by ") + std::string(stance.scaled_by) +
                         " the performer has " + text +
                         " times the usual size; expected 0.2 to 5: metres, the floor at 0");
  }
  std::string worn, guessed, left;
  const auto add = [](std::string& list, const std::string& text) {
    list.append(list.empty() ? "" : ", ").append(text);
  };
  bool any_turned = false;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::string name = '"' + Printable(who[i]->name, 64) + '"';
    if (seen[i].part == Seen::kUnknown) {
      add(left, name);
      continue;
    }
    add(seen[i].guessed ? guessed : worn, name + " on " + std::string(PartName(seen[i].part)));
    any_turned = any_turned || IsTurned(*who[i], now_ns);
  }
  if (worn.empty() && guessed.empty()) {
    return Status::Error("no device is at a place that fits a T-pose: " + left);
  }
  if (!any_turned) return Status::Error("no worn device reports its rotation");
  // Nothing has changed so far. The guesses of the last calibration end here, including those of
  // silent devices.
  for (Known& known : known_) {
    if (!known.fixed) known.part = Seen::kUnknown;
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Known& known = *who[i];
    known.part = seen[i].part;
    if (known.part == Seen::kUnknown) continue;
    devices_.Add(
        body::Joint(known.part), now_ns, known.last.position_m,
        IsTurned(known, now_ns) ? known.last.rotation : body::Quat(kNan, kNan, kNan, kNan));
  }
  calibrated_ = devices_.Reset(now_ns, stance).done != 0;
  if (!calibrated_) return Status::Error("no worn device reports its rotation");
  char figures[64];
  std::snprintf(figures, sizeof figures, "%.0f degrees by ",
                static_cast<double>(kDegrees * stance.heading));
  note_ = "calibrated";
  if (!worn.empty()) note_ += " " + worn;
  if (!guessed.empty()) note_ += "; guessed by height and side: " + guessed;
  if (!left.empty()) note_ += "; on no part: " + left;
  note_ += "; facing " + std::string(figures) + std::string(stance.faced_by);
  std::snprintf(figures, sizeof figures, "%.2f of the canonical size by ",
                static_cast<double>(stance.scale));
  note_ += ", " + std::string(figures) + std::string(stance.scaled_by);
  stream_.Restart(stance.scale);
  return Status::Ok();
}

}  // namespace styled::source
