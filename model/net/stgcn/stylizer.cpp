#include "model/net/stgcn/stylizer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <deque>
#include <numbers>

#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/features.h"
#include "model/net/stgcn/network.h"

namespace styled::stgcn {
namespace {

using net::Prediction;

// The generator's result for some frames.
struct Output {
  std::vector<Features> own, styled;
};

// to = (1 - share) from + share to
void Blend(const Features& from, float share, Features& to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = from[i] + share * (to[i] - from[i]);
}

class StgcnStream final : public net::ClipStream {
 public:
  StgcnStream(std::shared_ptr<const Network> network, const Code& code, int input_style,
              net::Extent extent)
      : network_(std::move(network)), code_(code), input_style_(input_style), extent_(extent) {}

  void Add(const body::Pose& pose) override {
    assert(!ended_);
    const float heading_rad =
        ComputeFeatures(pose, network_->features(), heading_, frames_.emplace_back());
    headings_rad_.push_back(heading_rad);
    if (extent_ == net::Extent::kByLength && frames_.size() > kLongestWhole) {
      extent_ = net::Extent::kWindows;
    }
    // One frame more than the window, so that the next window has frames of its own to end with.
    while (extent_ == net::Extent::kWindows && frames_.size() > kWindow) RunWindow(kWindow, kHop);
  }

  void End() override {
    ended_ = true;
    if (!frames_.empty()) RunWindow(frames_.size(), frames_.size());
  }

  bool Pop(Prediction& out) override {
    if (done_.empty()) return false;
    out = done_.front();
    done_.pop_front();
    return true;
  }

 private:
  // Styles the first `count` remaining frames, and finishes the first `finished` of them.
  void RunWindow(std::size_t count, std::size_t finished) {
    std::span<const Features> clip(frames_.data(), count);
    std::vector<Features> filled;
    if (count < kLeastFrames) {
      filled.assign(kLeastFrames, clip.back());
      std::copy(clip.begin(), clip.end(), filled.begin());
      clip = filled;
    }
    network_->Encode(clip, content_, scratch_);
    Output output{std::vector<Features>(clip.size()), std::vector<Features>(clip.size())};
    network_->Decode(content_, network_->space().EncodeStyle(clip, input_style_, scratch_),
                     output.own, scratch_);
    network_->Decode(content_, code_, output.styled, scratch_);
    // The last window's end fades into the beginning of this window.
    const std::size_t overlap = std::min(last_.own.size(), count);
    for (std::size_t i = 0; i < overlap; ++i) {
      const double turn = std::numbers::pi / 2 * (static_cast<double>(i) + 0.5) /
                          static_cast<double>(last_.own.size());
      const auto share = static_cast<float>(std::pow(std::sin(turn), 2));
      Blend(last_.own[i], share, output.own[i]);
      Blend(last_.styled[i], share, output.styled[i]);
    }
    for (std::size_t i = 0; i < finished; ++i) {
      Prediction& out = done_.emplace_back();
      ToDecoded(output.own[i], out.reconstruction);
      ToDecoded(output.styled[i], out.styled);
      out.heading_rad = headings_rad_[i];
    }
    const auto begin = static_cast<std::ptrdiff_t>(finished);
    const auto end = static_cast<std::ptrdiff_t>(count);
    last_.own.assign(output.own.begin() + begin, output.own.begin() + end);
    last_.styled.assign(output.styled.begin() + begin, output.styled.begin() + end);
    frames_.erase(frames_.begin(), frames_.begin() + begin);
    headings_rad_.erase(headings_rad_.begin(), headings_rad_.begin() + begin);
  }

  std::shared_ptr<const Network> network_;
  Code code_;
  int input_style_;
  net::Extent extent_;
  HeadingState heading_;
  std::vector<Features> frames_;     // not finished
  std::vector<float> headings_rad_;  // the results of these frames
  Output last_;                      // results of the first frames_, from the window before
  std::deque<Prediction> done_;
  Network::Content content_;
  Scratch scratch_;
  bool ended_ = false;
};

class StgcnStylizer final : public net::ClipStylizer {
 public:
  explicit StgcnStylizer(std::shared_ptr<const Network> network) : network_(std::move(network)) {}

  const net::Model& model() const noexcept override { return network_->model(); }
  int least_frames() const noexcept override { return kLeastFrames; }

  net::StyleCode MakeCode(const net::StyleRequest& request) const override {
    return network_->space().MakeCode(request);
  }
  net::NearestStyle Nearest(const net::StyleCode& code) const override {
    return network_->space().Nearest(code);
  }

  std::unique_ptr<net::ClipStream> MakeStream(const net::StyleCode& code, int input_style,
                                              net::Extent extent) const override {
    return std::make_unique<StgcnStream>(network_, ToCode(code), input_style, extent);
  }

 private:
  std::shared_ptr<const Network> network_;
};

}  // namespace

Result<std::shared_ptr<const net::ClipStylizer>> Load(net::WeightsFile& file) {
  auto network = Network::Read(file);
  if (!network.ok()) return network.status();
  return std::shared_ptr<const net::ClipStylizer>(
      std::make_shared<StgcnStylizer>(std::move(network.value())));
}

}  // namespace styled::stgcn
