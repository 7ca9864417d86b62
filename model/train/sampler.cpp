#include "model/train/sampler.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <tuple>

namespace styled::train {
namespace {

// Windows of a cell: fewer are noise (a clip that stands still for an instant).
constexpr std::size_t kFewestPlaces = 8;
constexpr int kIdleStride = 5;  // frames between those that are tested for an idle posture
// Share of idle sequences that begin like a session, as many real ones do.
constexpr double kIdleFromTheStart = 0.5;
// Probability that an idle window is followed by another, the states carried: 10 windows, 8 s, on
// average. Longer ones leave fewer sequences to learn from.
constexpr double kIdleContinues = 0.9;

// The limits of an idle posture: upright, both feet on the floor and together, the hands down.
constexpr float kHandsAboveHips_m = 0.1F, kHeadAboveHips_m = 0.5F;
constexpr float kFeetApart_m = 0.3F, kFeetUneven_m = 0.05F;

bool IsIdlePosture(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  const auto at = [&world](int joint) -> const body::Vec3& { return world.positions_m[joint]; };
  const body::Vec3& hips = at(body::kHips);
  const body::Vec3 stride = at(body::kLeftFoot) - at(body::kRightFoot);
  const float hands = std::max(at(body::kLeftHand).y(), at(body::kRightHand).y());
  return hands < hips.y() + kHandsAboveHips_m &&
         at(body::kHead).y() > hips.y() + kHeadAboveHips_m &&
         std::abs(stride.y()) < kFeetUneven_m && std::hypot(stride.x(), stride.z()) < kFeetApart_m;
}

}  // namespace

Sampler::Sampler(const std::vector<TrainingClip>& clips, const Options& options)
    : clips_(clips), options_(options), random_(options.seed), cells_(options.styles) {
  FindPlaces();
  if (options.idle > 0) FindIdleFrames();
  if (options.pairs > 0) FindPairs();
  last_.resize(options.pairs > 0
                   ? static_cast<std::size_t>(2) * options.pairs
                   : static_cast<std::size_t>(2) * options.per_style * (options.styles - 1));
}

void Sampler::FindPlaces() {
  // 1. Every window of every clip, by style, content and source.
  int sources = 0;
  for (const TrainingClip& clip : clips_) sources = std::max(sources, clip.source + 1);
  Cell empty;
  empty.places.resize(sources);
  std::vector<std::vector<Cell>> all(options_.styles, std::vector<Cell>(options_.contents, empty));
  for (std::size_t i = 0; i < clips_.size(); ++i) {
    const int places = static_cast<int>(clips_[i].poses.size()) - options_.length + 1;
    for (int start = 0; start < places; ++start) {
      Cell& cell = all[clips_[i].style][clips_[i].ContentOf(start, options_.length)];
      cell.places[clips_[i].source].emplace_back(static_cast<int>(i), start);
    }
  }
  // 2. The cells with enough of them.
  for (int style = 0; style < options_.styles; ++style) {
    for (int content = 0; content < options_.contents; ++content) {
      Cell& cell = all[style][content];
      cell.content = content;
      std::erase_if(cell.places, [](const auto& some) { return some.size() < kFewestPlaces; });
      if (!cell.places.empty()) cells_[style].push_back(std::move(cell));
    }
  }
  // 3. The contents of a neutral window that its target has.
  paired_.resize(options_.styles);
  for (int style = 0; style < options_.styles; ++style) {
    for (std::size_t i = 0; i < cells_[0].size(); ++i) {
      if (Has(style, cells_[0][i].content)) paired_[style].push_back(static_cast<int>(i));
    }
  }
}

void Sampler::FindPairs() {
  neutral_.resize(options_.contents);
  for (int style = 0; style < options_.styles; ++style) {
    for (const Cell& cell : cells_[style]) {
      std::vector<Window>& to = style == 0 ? neutral_[cell.content] : styled_;
      if (style > 0 && neutral_[cell.content].empty()) continue;
      for (const auto& places : cell.places) {
        for (const auto& [clip, start] : places) {
          to.push_back({.style = style, .clip = clip, .start = start, .content = cell.content});
        }
      }
    }
  }
  if (styled_.empty()) throw std::runtime_error("no content has both neutral and styled windows");
}

void Sampler::NextPairs() {
  for (std::size_t i = 0; i < last_.size(); i += 2) {
    Window& styled = last_[i + 1];
    styled = styled_[Below(static_cast<int64_t>(styled_.size()))];
    const std::vector<Window>& neutral = neutral_[styled.content];
    last_[i] = neutral[Below(static_cast<int64_t>(neutral.size()))];
    last_[i].target = styled.style;
  }
}

void Sampler::FindIdleFrames() {
  for (std::size_t i = 0; i < clips_.size(); ++i) {
    if (clips_[i].style != 0 || clips_[i].still_content < 0) continue;
    const int places = static_cast<int>(clips_[i].poses.size()) - options_.length + 1;
    for (int start = 0; start < places; start += kIdleStride) {
      if (IsIdlePosture(clips_[i].poses[start])) idle_.emplace_back(static_cast<int>(i), start);
    }
  }
}

bool Sampler::IsNeutralSlot(int slot) const {
  return slot % (2 * options_.per_style) < options_.per_style;
}

int Sampler::InputStyle(int slot) const {
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

Sampler::Window Sampler::DrawFrom(const Cell& cell) {
  const auto& places = cell.places[Below(static_cast<int64_t>(cell.places.size()))];
  const auto& [clip, start] = places[Below(static_cast<int64_t>(places.size()))];
  Window window;
  window.clip = clip;
  window.start = start;
  window.mirrored = Uniform() < 0.5;
  window.content = cell.content;
  return window;
}

Sampler::Window Sampler::DrawIdle() {
  Window window;
  std::tie(window.clip, window.start) = idle_[Below(static_cast<int64_t>(idle_.size()))];
  window.content = clips_[window.clip].still_content;
  window.mirrored = Uniform() < 0.5;
  window.idle = true;
  window.paired = false;  // a critic would recognize it by its stillness
  return window;
}

Sampler::Window Sampler::Draw(int style) {
  return DrawFrom(cells_[style][Below(static_cast<int64_t>(cells_[style].size()))]);
}

// Whether the slot's next window is idle; then it is in place. Idle windows begin so often that
// their share is options.idle.
bool Sampler::NextIdle(int slot) {
  if (!IsNeutralSlot(slot) || idle_.empty()) return false;
  const Window before = last_[slot];
  const double begins = options_.idle / (1 - options_.idle) * (1 - kIdleContinues);
  if (Uniform() >= (before.idle ? kIdleContinues : begins)) return false;
  Window& window = last_[slot];
  window = before.idle ? before : DrawIdle();
  window.session_start = !before.idle && (before.clip < 0 || Uniform() < kIdleFromTheStart);
  window.carried = !window.session_start;
  return true;
}

// Whether the clip of a slot's last window is long enough for one more.
bool Sampler::Continues(const Window& before) const {
  return !before.idle &&
         before.start + 2 * options_.length <= static_cast<int>(clips_[before.clip].poses.size());
}

Sampler::Window Sampler::NextFor(int slot, bool carried) {
  Window window;
  if (carried && Continues(last_[slot])) {
    window = last_[slot];
    window.start += options_.length;
    window.session_start = false;
    window.content = clips_[window.clip].ContentOf(window.start, options_.length);
    return window;
  }
  const std::vector<int>& paired = paired_[TargetStyle(slot)];
  if (IsNeutralSlot(slot) && !paired.empty() && Uniform() >= options_.unpaired) {
    window = DrawFrom(cells_[0][paired[Below(static_cast<int64_t>(paired.size()))]]);
  } else {
    window = Draw(InputStyle(slot));
  }
  window.session_start = !carried && Uniform() < options_.session_start;
  if (Uniform() < options_.miscalibrated) window.miscalibration = random_() | 1;
  return window;
}

const std::vector<Sampler::Window>& Sampler::Next() {
  if (options_.pairs > 0) {
    NextPairs();
    return last_;
  }
  for (int slot = 0; slot < slots(); ++slot) {
    if (NextIdle(slot)) continue;
    const bool carried = last_[slot].clip >= 0 && Uniform() < options_.carry;
    Window window = NextFor(slot, carried);
    window.carried = carried;
    window.paired = Has(TargetStyle(slot), window.content);
    last_[slot] = window;
  }
  for (int slot = 0; slot < slots(); ++slot) {
    last_[slot].style = InputStyle(slot);
    last_[slot].target = TargetStyle(slot);
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
