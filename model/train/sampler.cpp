#include "model/train/sampler.h"

#include <algorithm>
#include <sstream>

namespace styled::train {
namespace {

// A cell with fewer windows than this is noise (a clip that stands still for an instant).
constexpr std::size_t kFewestPlaces = 8;

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

Sampler::Window Sampler::Any(int style) {
  return From(cells_[style][Below(static_cast<int64_t>(cells_[style].size()))]);
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
        << w.carried << ' ' << w.content << ' ' << w.paired << ' ' << w.miscalibration;
  }
  return out.str();
}

void Sampler::Restore(const std::string& text) {
  std::istringstream in(text);
  in >> random_;
  for (Window& w : last_) {
    in >> w.clip >> w.start >> w.mirrored >> w.session_start >> w.carried >> w.content >>
        w.paired >> w.miscalibration;
  }
}

}  // namespace styled::train
