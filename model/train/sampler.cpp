#include "model/train/sampler.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <tuple>

namespace styled::train {
namespace {

// A cell with fewer windows than this is noise (a clip that stands still for an instant).
constexpr std::size_t kFewestPlaces = 8;
constexpr int kIdleStride = 5;
constexpr double kIdleFromTheStart = 0.5;  // of idle times: a session begins with it
constexpr double kGoesOn = 0.9;  // an idle window is followed by another one, the states carried

// Upright on both feet, hands down: a moment of what somebody who does nothing looks like.
bool Stands(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  const auto at = [&world](int joint) -> const body::Vec3& { return world.positions_m[joint]; };
  const body::Vec3& hips = at(body::kHips);
  const body::Vec3 stride = at(body::kLeftFoot) - at(body::kRightFoot);
  return std::max(at(body::kLeftHand).y(), at(body::kRightHand).y()) < hips.y() + 0.1F &&
         at(body::kHead).y() > hips.y() + 0.5F && std::abs(stride.y()) < 0.05F &&
         std::hypot(stride.x(), stride.z()) < 0.3F;
}

}  // namespace

Sampler::Sampler(const std::vector<TrainingClip>& clips, const Options& options)
    : clips_(clips), options_(options), random_(options.seed), cells_(options.styles) {
  int sources = 0;
  for (const TrainingClip& clip : clips) sources = std::max(sources, clip.source + 1);
  Cell empty;
  empty.places.resize(sources);
  std::vector<std::vector<Cell>> all(options.styles, std::vector<Cell>(options.contents, empty));
  for (std::size_t i = 0; i < clips.size(); ++i) {
    const int places = static_cast<int>(clips[i].poses.size()) - options.length + 1;
    for (int start = 0; start < places; ++start) {
      Cell& cell = all[clips[i].style][clips[i].ContentOf(start, options.length)];
      cell.places[clips[i].source].emplace_back(static_cast<int>(i), start);
    }
  }
  for (int style = 0; style < options.styles; ++style) {
    for (int content = 0; content < options.contents; ++content) {
      Cell& cell = all[style][content];
      cell.content = content;
      std::erase_if(cell.places, [](const auto& some) { return some.size() < kFewestPlaces; });
      if (!cell.places.empty()) cells_[style].push_back(std::move(cell));
    }
  }
  // Of a neutral window's contents, those that its target has.
  paired_.resize(options.styles);
  for (int style = 0; style < options.styles; ++style) {
    for (std::size_t i = 0; i < cells_[0].size(); ++i) {
      if (Has(style, cells_[0][i].content)) paired_[style].push_back(static_cast<int>(i));
    }
  }
  for (std::size_t i = 0; options.idle > 0 && i < clips.size(); ++i) {
    if (clips[i].style != 0 || clips[i].still_content < 0) continue;
    const int places = static_cast<int>(clips[i].poses.size()) - options.length + 1;
    for (int start = 0; start < places; start += kIdleStride) {
      if (Stands(clips[i].poses[start])) stands_.emplace_back(static_cast<int>(i), start);
    }
  }
  last_.resize(static_cast<std::size_t>(2) * options.per_style * (options.styles - 1));
}

bool Sampler::IsNeutralSlot(int slot) const {
  return slot % (2 * options_.per_style) < options_.per_style;
}

int Sampler::OwnStyle(int slot) const {
  return IsNeutralSlot(slot) ? 0 : 1 + slot / (2 * options_.per_style);
}

int Sampler::TargetStyle(int slot) const {
  return IsNeutralSlot(slot) ? 1 + slot / (2 * options_.per_style) : 0;
}

double Sampler::Uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

int64_t Sampler::Below(int64_t bound) {
  return std::min(static_cast<int64_t>(Uniform() * static_cast<double>(bound)), bound - 1);
}

bool Sampler::Has(int style, int content) const {
  return std::any_of(cells_[style].begin(), cells_[style].end(),
                     [content](const Cell& cell) { return cell.content == content; });
}

Sampler::Window Sampler::From(const Cell& cell) {
  const auto& places = cell.places[Below(static_cast<int64_t>(cell.places.size()))];
  const auto& [clip, start] = places[Below(static_cast<int64_t>(places.size()))];
  Window window;
  window.clip = clip;
  window.start = start;
  window.mirrored = Uniform() < 0.5;
  window.content = cell.content;
  return window;
}

Sampler::Window Sampler::Idle() {
  Window window;
  std::tie(window.clip, window.start) = stands_[Below(static_cast<int64_t>(stands_.size()))];
  window.content = clips_[window.clip].still_content;
  window.mirrored = Uniform() < 0.5;
  window.idle = true;
  window.paired = false;  // a critic would know it by its stillness
  return window;
}

Sampler::Window Sampler::Any(int style) {
  return From(cells_[style][Below(static_cast<int64_t>(cells_[style].size()))]);
}

const std::vector<Sampler::Window>& Sampler::Next() {
  for (int slot = 0; slot < slots(); ++slot) {
    const Window before = last_[slot];
    if (IsNeutralSlot(slot) && !stands_.empty()) {
      // Who stands goes on for eight seconds or so.
      const double begins = options_.idle / (1 - options_.idle) * (1 - kGoesOn);
      if (Uniform() < (before.idle ? kGoesOn : begins)) {
        Window& window = last_[slot];
        window = before.idle ? before : Idle();
        window.session_start = !before.idle && (before.clip < 0 || Uniform() < kIdleFromTheStart);
        window.carried = !window.session_start;
        continue;
      }
    }
    const bool carried = before.clip >= 0 && Uniform() < options_.carry;
    Window window;
    if (carried && !before.idle &&
        before.start + 2 * options_.length <= static_cast<int>(clips_[before.clip].poses.size())) {
      window = before;
      window.start += options_.length;
      window.session_start = false;
      window.content = clips_[window.clip].ContentOf(window.start, options_.length);
    } else {
      const std::vector<int>& paired = paired_[TargetStyle(slot)];
      if (IsNeutralSlot(slot) && !paired.empty() && Uniform() >= options_.unpaired) {
        window = From(cells_[0][paired[Below(static_cast<int64_t>(paired.size()))]]);
      } else {
        window = Any(OwnStyle(slot));
      }
      window.session_start = !carried && Uniform() < options_.session_start;
      if (Uniform() < options_.miscalibrated) window.miscalibration = random_() | 1;
    }
    window.carried = carried;
    window.paired = Has(TargetStyle(slot), window.content);
    last_[slot] = window;
  }
  return last_;
}

std::string Sampler::Save() const {
  std::ostringstream out;
  out << random_;
  for (const Window& w : last_) {
    out << ' ' << w.clip << ' ' << w.start << ' ' << w.mirrored << ' ' << w.session_start << ' '
        << w.carried << ' ' << w.content << ' ' << w.paired << ' ' << w.miscalibration << ' '
        << w.idle;
  }
  return out.str();
}

void Sampler::Restore(const std::string& text) {
  std::istringstream in(text);
  in >> random_;
  for (Window& w : last_) {
    in >> w.clip >> w.start >> w.mirrored >> w.session_start >> w.carried >> w.content >>
        w.paired >> w.miscalibration >> w.idle;
  }
  if (in.fail()) throw std::runtime_error("the sampler of another version");
}

}  // namespace styled::train
