#include "model/train/sampler.h"

#include <algorithm>
#include <sstream>

namespace styled::train {

Sampler::Sampler(const std::vector<TrainingClip>& clips, const Options& options)
    : clips_(clips), options_(options), random_(options.seed), cells_(options.styles) {
  std::vector<std::vector<Cell>> all(options.styles, std::vector<Cell>(options.contents));
  for (std::size_t i = 0; i < clips.size(); ++i) {
    const int64_t places = static_cast<int64_t>(clips[i].poses.size()) - options.length + 1;
    if (places <= 0) continue;
    Cell& cell = all[clips[i].style][clips[i].content];
    cell.clips.push_back(static_cast<int>(i));
    cell.places.push_back(places + (cell.places.empty() ? 0 : cell.places.back()));
  }
  for (int style = 0; style < options.styles; ++style) {
    for (Cell& cell : all[style]) {
      if (!cell.clips.empty()) cells_[style].push_back(std::move(cell));
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

Sampler::Window Sampler::Any(int style) {
  const Cell& cell = cells_[style][Below(static_cast<int64_t>(cells_[style].size()))];
  const int64_t place = Below(cell.places.back());
  const auto found = std::upper_bound(cell.places.begin(), cell.places.end(), place);
  const auto index = found - cell.places.begin();
  Window window;
  window.clip = cell.clips[index];
  window.start = static_cast<int>(place - (index == 0 ? 0 : cell.places[index - 1]));
  window.mirrored = Uniform() < 0.5;
  return window;
}

const std::vector<Sampler::Window>& Sampler::Next() {
  for (int slot = 0; slot < slots(); ++slot) {
    const Window before = last_[slot];
    const bool carried = before.clip >= 0 && Uniform() < options_.carry;
    Window window;
    if (carried &&
        before.start + 2 * options_.length <= static_cast<int>(clips_[before.clip].poses.size())) {
      window = before;
      window.start += options_.length;
      window.session_start = false;
    } else {
      window = Any(OwnStyle(slot));
      window.session_start = !carried && Uniform() < options_.session_start;
    }
    window.carried = carried;
    last_[slot] = window;
  }
  return last_;
}

std::string Sampler::Save() const {
  std::ostringstream out;
  out << random_;
  for (const Window& w : last_) {
    out << ' ' << w.clip << ' ' << w.start << ' ' << w.mirrored << ' ' << w.session_start << ' '
        << w.carried;
  }
  return out.str();
}

void Sampler::Restore(const std::string& text) {
  std::istringstream in(text);
  in >> random_;
  for (Window& w : last_) in >> w.clip >> w.start >> w.mirrored >> w.session_start >> w.carried;
}

}  // namespace styled::train
