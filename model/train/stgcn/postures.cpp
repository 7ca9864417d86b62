#include "model/train/stgcn/postures.h"

#include <algorithm>
#include <array>
#include <utility>

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

// Shares of recorded differences, somewhat beyond 1, so that styles stronger than the recorded ones
// are learnt too. Larger: more of such styles, and more postures that no person has. One pair was
// tried: examples of styles never seen went from cosine 0.28 to 0.65.
constexpr float kMostOfStyles = 1.2F, kMostOfClips = 1.5F;

// Trunk and head, arms, legs: consecutive joints of the humanoid.
constexpr int kLimbs = 5;
constexpr std::array<int, kLimbs + 1> kFirstOfLimb{0,
                                                   body::kLeftShoulder,
                                                   body::kRightShoulder,
                                                   body::kLeftUpperLeg,
                                                   body::kRightUpperLeg,
                                                   body::kJointCount};

Tensor Mirrored(const Tensor& posture) {
  stgcn::Features features;
  std::copy_n(posture.contiguous().data_ptr<float>(), features.size(), features.begin());
  stgcn::MirrorFeatures(features, features);
  Tensor out = torch::empty_like(posture);
  std::copy(features.begin(), features.end(), out.data_ptr<float>());
  return out;
}

float Uniform(std::mt19937_64& random, float most) {
  return most * static_cast<float>(random() >> 40) * 0x1p-24F;
}

template <typename T>
const T& Any(const std::vector<T>& of, std::mt19937_64& random) {
  return of[random() % of.size()];
}

}  // namespace

Postures::Postures(const WindowStore& store, int domains, std::vector<bool> single_act)
    : store_(store), single_act_(std::move(single_act)) {
  const std::size_t contents = single_act_.size();
  std::vector<std::vector<int>> counts(static_cast<std::size_t>(domains),
                                       std::vector<int>(contents, 0));
  cells_.assign(counts.size(), std::vector<Tensor>(contents));
  for (int clip = 0; clip < store_.clips(); ++clip) {
    clips_.push_back(store_.FramesOf(clip).mean(0).contiguous());
    const auto domain = static_cast<std::size_t>(store_.StyleOf(clip));
    const auto content = static_cast<std::size_t>(store_.ContentOf(clip, store_.Starts(clip)[0]));
    Tensor& cell = cells_[domain][content];
    cell = cell.defined() ? cell + clips_.back() : clips_.back().clone();
    ++counts[domain][content];
    if (single_act_[content]) drawn_.push_back(clip);
  }
  for (int domain = 0; domain < domains; ++domain) {
    for (int content = 0; content < static_cast<int>(contents); ++content) {
      Tensor& cell = cells_[static_cast<std::size_t>(domain)][static_cast<std::size_t>(content)];
      if (!cell.defined()) continue;
      cell = cell / counts[static_cast<std::size_t>(domain)][static_cast<std::size_t>(content)];
      for (int other = 0; other < domain; ++other) {
        if (!HasCell(other, content)) continue;
        pairs_.push_back({other, domain, content});
        pairs_.push_back({domain, other, content});
      }
    }
  }
}

bool Postures::HasCell(int domain, int content) const { return CellOf(domain, content).defined(); }

Tensor Postures::Own(const Window& window) const {
  const int content = store_.ContentOf(window.clip, store_.Starts(window.clip)[0]);
  const Tensor own =
      clips_[static_cast<std::size_t>(window.clip)] - CellOf(store_.StyleOf(window.clip), content);
  return window.mirrored ? Mirrored(own) : own;
}

bool Postures::Wanted(const Sample& sample, Tensor& shift) const {
  const int of_reference =
      store_.ContentOf(sample.reference1.clip, store_.Starts(sample.reference1.clip)[0]);
  if (!single_act_[static_cast<std::size_t>(of_reference)]) return false;
  if (!HasCell(sample.domain, sample.content) || !HasCell(sample.target, sample.content)) {
    return false;
  }
  const Tensor style =
      CellOf(sample.target, sample.content) - CellOf(sample.domain, sample.content);
  shift = (sample.source.mirrored ? Mirrored(style) : style) + Own(sample.reference1);
  return true;
}

Tensor Postures::DrawWhole(std::mt19937_64& random) const {
  Tensor shift = torch::zeros_like(clips_[0]);
  if (!pairs_.empty()) {
    const Pair& pair = Any(pairs_, random);
    const Tensor style = CellOf(pair.to, pair.content) - CellOf(pair.from, pair.content);
    const bool mirrored = random() % 2 == 0;
    shift = shift + Uniform(random, kMostOfStyles) * (mirrored ? Mirrored(style) : style);
  }
  if (!drawn_.empty()) {
    const Window window{Any(drawn_, random), 0, random() % 2 == 0};
    shift = shift + Uniform(random, kMostOfClips) * Own(window);
  }
  return shift;
}

// The features' rotations are not relative to a parent's, so that limbs can be shifted one by one.
Tensor Postures::Draw(std::mt19937_64& random) const {
  Tensor shift = DrawWhole(random);
  if (random() % 2 == 0) return shift;
  for (int limb = 0; limb < kLimbs; ++limb) {
    const int joints = kFirstOfLimb[limb + 1] - kFirstOfLimb[limb];
    const Tensor of_limb = DrawWhole(random).narrow(0, kFirstOfLimb[limb], joints);
    shift.narrow(0, kFirstOfLimb[limb], joints).copy_(of_limb);
  }
  return shift;
}

}  // namespace styled::train::st_gcn
