#include "model/train/stgcn/windows.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "model/train/stgcn/networks.h"

namespace styled::train::st_gcn {
namespace {

using body::kJointCount;
using stgcn::Features;
using stgcn::kChannels;
using stgcn::kFeatureCount;
using stgcn::kPositionChannels;
using torch::Tensor;

constexpr float kPositionFloor_m = 0.02F, kRotationFloor = 0.05F;
constexpr float kConstant = 1e-5F;  // without floors: smaller deviations are those of constants
constexpr int kFrames = static_cast<int>(kWindowFrames);
// Windows of a cell: fewer are noise (a clip that stands still for an instant).
constexpr int kFewestWindows = 4;

// Of a reflection, per channel.
constexpr std::array<float, kChannels> kSigns{-1, 1, 1, 1, -1, -1, 1};

bool IsConstant(int feature) {
  return feature == kChannels * body::kHips || feature == kChannels * body::kHips + 2;
}

// Calls visit(features) for every frame of the clips.
template <typename Visit>
void EachFrame(const TrainingClip& clip, const stgcn::FeatureParameters& parameters,
               const Visit& visit) {
  stgcn::HeadingState state;
  Features features;
  for (const body::Pose& pose : clip.poses) {
    stgcn::ComputeFeatures(pose, parameters, state, features);
    visit(features);
  }
}

// Makes the moments of frames those of the frames and their mirror images.
void Symmetrize(Eigen::ArrayXd& mean, Eigen::ArrayXd& square) {
  const Eigen::ArrayXd one_mean = mean, one_square = square;
  for (int joint = 0; joint < kJointCount; ++joint) {
    for (int channel = 0; channel < kChannels; ++channel) {
      const int here = kChannels * joint + channel;
      const int there = kChannels * body::MirrorJoint(joint) + channel;
      mean[here] = 0.5 * (one_mean[here] + double{kSigns[channel]} * one_mean[there]);
      square[here] = 0.5 * (one_square[here] + one_square[there]);
    }
  }
}

float Usable(int feature, float deviation, bool floored) {
  if (IsConstant(feature)) return 1;
  if (!floored) return deviation < kConstant ? 1 : deviation;
  const bool position = feature % kChannels < kPositionChannels;
  return std::max(deviation, position ? kPositionFloor_m : kRotationFloor);
}

}  // namespace

Statistics ComputeStatistics(const std::vector<TrainingClip>& clips,
                             stgcn::FeatureParameters parameters, bool floored) {
  Statistics statistics;
  // First on the hemisphere of identity, then on that of the first pass's mean.
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::ArrayXd mean = Eigen::ArrayXd::Zero(kFeatureCount), square = mean;
    double count = 0;
    for (const TrainingClip& clip : clips) {
      EachFrame(clip, parameters, [&](const Features& features) {
        const Eigen::ArrayXd x =
            Eigen::Map<const Eigen::ArrayXf>(features.data(), kFeatureCount).cast<double>();
        mean += x;
        square += x.square();
        count += 1;
      });
    }
    mean /= count;
    square /= count;
    Symmetrize(mean, square);
    const Eigen::ArrayXd deviation = (square - mean.square()).max(0).sqrt();
    for (int i = 0; i < kFeatureCount; ++i) {
      statistics.mean[i] = IsConstant(i) ? 0 : static_cast<float>(mean[i]);
      statistics.deviation[i] = Usable(i, static_cast<float>(deviation[i]), floored);
    }
    stgcn::SetHemisphere(statistics.mean, parameters);
  }
  return statistics;
}

WindowStore::WindowStore(const std::vector<TrainingClip>& clips, const Statistics& statistics,
                         const stgcn::FeatureParameters& parameters, int hop)
    : clips_(clips) {
  const Eigen::Map<const Eigen::ArrayXf> mean(statistics.mean.data(), kFeatureCount);
  const Eigen::Map<const Eigen::ArrayXf> deviation(statistics.deviation.data(), kFeatureCount);
  for (const TrainingClip& clip : clips) {
    const int frames = static_cast<int>(clip.poses.size());
    Tensor all = torch::empty({frames, kJointCount, kChannels});
    float* out = all.data_ptr<float>();
    EachFrame(clip, parameters, [&](const Features& features) {
      Eigen::Map<Eigen::ArrayXf>(out, kFeatureCount) =
          (Eigen::Map<const Eigen::ArrayXf>(features.data(), kFeatureCount) - mean) / deviation;
      out += kFeatureCount;
    });
    features_.push_back(all);
    std::vector<int> starts;
    if (frames < kFrames) starts.push_back(-(kFrames - frames) / 2);
    for (int start = 0; start + kFrames <= frames; start += hop) starts.push_back(start);
    if (frames > kFrames && starts.back() + kFrames < frames) starts.push_back(frames - kFrames);
    starts_.push_back(std::move(starts));
  }
}

int WindowStore::ContentOf(int clip, int start) const {
  const int frames = static_cast<int>(clips_[clip].poses.size());
  return clips_[clip].ContentOf(std::max(start, 0), std::min(kFrames, frames));
}

Tensor WindowStore::Read(const std::vector<Window>& windows) const {
  Tensor out =
      torch::empty({static_cast<int64_t>(windows.size()), kWindowFrames, kJointCount, kChannels});
  float* to = out.data_ptr<float>();
  for (const Window& window : windows) {
    const Tensor& clip = features_[window.clip];
    const int last = static_cast<int>(clip.size(0)) - 1;
    for (int t = 0; t < kFrames; ++t) {
      const int frame = std::clamp(window.start + t, 0, last);
      const float* from =
          clip.data_ptr<float>() + static_cast<std::ptrdiff_t>(frame) * kFeatureCount;
      if (!window.mirrored) {
        std::copy_n(from, kFeatureCount, to);
      } else {
        Features features;
        std::copy_n(from, kFeatureCount, features.begin());
        stgcn::MirrorFeatures(features, features);
        std::copy(features.begin(), features.end(), to);
      }
      to += kFeatureCount;
    }
  }
  return out;
}

Sampler::Sampler(const WindowStore& store, const Options& options)
    : store_(store), options_(options), random_(options.seed) {
  FindCells();
  FindContents();
}

// Every window, by domain, content and folder.
void Sampler::FindCells() {
  const auto domains = static_cast<std::size_t>(options_.domains);
  const auto contents = static_cast<std::size_t>(options_.contents);
  const WindowStore& store = store_;
  int sources = 0;
  for (int clip = 0; clip < store.clips(); ++clip) {
    sources = std::max(sources, store.SourceOf(clip) + 1);
  }
  windows_.resize(domains);
  cells_.assign(domains, std::vector<Cell>(contents, Cell(static_cast<std::size_t>(sources))));
  for (int clip = 0; clip < store.clips(); ++clip) {
    for (const int start : store.Starts(clip)) {
      Cell& cell = cells_[static_cast<std::size_t>(store.StyleOf(clip))]
                         [static_cast<std::size_t>(store.ContentOf(clip, start))];
      std::vector<Place>& places = cell[static_cast<std::size_t>(store.SourceOf(clip))];
      if (places.empty() || places.back().clip != clip) places.push_back({clip, {}});
      places.back().starts.push_back(start);
      if (options_.even_contents) continue;
      windows_[static_cast<std::size_t>(store.StyleOf(clip))].push_back({clip, start, false});
    }
  }
}

// The contents of each domain that have enough windows, and those that two domains share.
void Sampler::FindContents() {
  const std::size_t domains = cells_.size();
  contents_of_.resize(domains);
  for (std::size_t domain = 0; domain < domains; ++domain) {
    for (std::size_t content = 0; content < cells_[domain].size(); ++content) {
      Cell& cell = cells_[domain][content];
      std::erase_if(cell, [](const std::vector<Place>& places) {
        std::size_t windows = 0;
        for (const Place& place : places) windows += place.starts.size();
        return windows < kFewestWindows;
      });
      if (!cell.empty()) contents_of_[domain].push_back(static_cast<int>(content));
    }
  }
  shared_.assign(domains, std::vector<std::vector<int>>(domains));
  for (std::size_t a = 0; a < domains; ++a) {
    for (std::size_t b = 0; b < domains; ++b) {
      std::set_intersection(contents_of_[a].begin(), contents_of_[a].end(), contents_of_[b].begin(),
                            contents_of_[b].end(), std::back_inserter(shared_[a][b]));
    }
  }
}

bool Sampler::HasAll() const {
  const auto lacks = [](const auto& all) {
    return std::any_of(all.begin(), all.end(), [](const auto& of) { return of.empty(); });
  };
  return options_.even_contents ? !lacks(contents_of_) : !lacks(windows_);
}

double Sampler::Uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

int Sampler::Below(std::size_t bound) {
  return std::min(static_cast<int>(Uniform() * static_cast<double>(bound)),
                  static_cast<int>(bound) - 1);
}

Window Sampler::Draw(const Cell& cell) {
  const std::vector<Place>& places = cell[Below(cell.size())];
  const Place& place = places[Below(places.size())];
  Window window;
  window.clip = place.clip;
  window.start = place.starts[Below(place.starts.size())];
  window.mirrored = options_.mirror && Uniform() < 0.5;
  return window;
}

Window Sampler::DrawAny(int domain) {
  const std::vector<Window>& all = windows_[static_cast<std::size_t>(domain)];
  Window window = all[static_cast<std::size_t>(Below(all.size()))];
  window.mirrored = options_.mirror && Uniform() < 0.5;
  return window;
}

Window Sampler::DrawReference(int domain) {
  if (!options_.even_contents) return DrawAny(domain);
  const std::vector<int>& contents = contents_of_[domain];
  return Draw(cells_[domain][contents[Below(contents.size())]]);
}

// Half a window away or more if the clip is long enough, otherwise any other one.
Window Sampler::AnotherOf(const Window& window) {
  const std::vector<int>& starts = store_.Starts(window.clip);
  std::vector<int> others;
  for (const int nearest : {kFrames / 2, 1}) {
    if (!others.empty()) break;
    std::copy_if(starts.begin(), starts.end(), std::back_inserter(others),
                 [&](int start) { return std::abs(start - window.start) >= nearest; });
  }
  Window other = window;
  if (!others.empty()) other.start = others[Below(others.size())];
  return other;
}

std::vector<Sample> Sampler::Next(int count) {
  std::vector<Sample> samples;
  for (int i = 0; i < count; ++i) {
    Sample sample;
    sample.domain = Below(contents_of_.size());
    if (options_.neutral > 0 && Uniform() < options_.neutral) sample.domain = 0;
    sample.target = Below(contents_of_.size());
    const std::vector<int>& shared = shared_[sample.domain][sample.target];
    const bool any = !options_.shared_contents || shared.empty() || Uniform() < options_.unpaired;
    sample.paired = !any || !options_.shared_contents;
    if (options_.even_contents) {
      const std::vector<int>& from = any ? contents_of_[sample.domain] : shared;
      sample.content = from[Below(from.size())];
      sample.source = Draw(cells_[sample.domain][sample.content]);
    } else {
      sample.source = DrawAny(sample.domain);
      sample.content = store_.ContentOf(sample.source.clip, sample.source.start);
    }
    sample.same_clip = AnotherOf(sample.source);
    sample.reference1 = DrawReference(sample.target);
    sample.reference2 = DrawReference(sample.target);
    samples.push_back(sample);
  }
  return samples;
}

std::string Sampler::Save() const {
  std::ostringstream out;
  out << random_;
  return out.str();
}

void Sampler::Restore(const std::string& text) {
  std::istringstream in(text);
  in >> random_;
  if (in.fail()) throw std::runtime_error("the sampler of another version");
}

}  // namespace styled::train::st_gcn
