#include "model/train/judge/pictures.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "model/train/judge/mixed.h"

namespace styled::judge {
namespace {

constexpr std::size_t kLead = 30;  // frames before the first figure, for states to settle
constexpr std::size_t kWide = 10;  // frames between figures of the mixed clip: 4 s a strip
constexpr int kReferenced = 4;     // styles
constexpr std::uint64_t kNoises = 3;

class Painter {
 public:
  Painter(const Data& data, const ClipRestyler& restyler, const train::TrainingClip& walk)
      : data_(data), restyler_(restyler), walk_(walk) {
    for (int style = 1; style < static_cast<int>(data.manifest.styles.size()); ++style) {
      if (restyler.Has(style) && WalkOf(data, style, walk.content) != nullptr) {
        present_.push_back(style);
      }
    }
    double farthest = -1;
    for (const int a : present_) {
      for (const int b : present_) {
        const double apart = a < b ? Apart(Mean(a), Mean(b)) : -1;
        if (apart > farthest) farthest = apart, pair_ = {a, b};
      }
    }
  }

  // The longest clip of a style and content, or null.
  static const train::TrainingClip* WalkOf(const Data& data, int style, int content) {
    const train::TrainingClip* longest = nullptr;
    for (const train::TrainingClip& clip : data.validation) {
      if (clip.style != style || clip.content != content) continue;
      if (longest == nullptr || clip.poses.size() > longest->poses.size()) longest = &clip;
    }
    return longest;
  }

  std::vector<Picture> Paint() const {
    if (present_.size() < 2) return {};
    return {References(), Noises(), Between(), Mixed()};
  }

 private:
  static double Apart(const net::StyleCode& a, const net::StyleCode& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
  }
  net::StyleCode Mean(int style) const { return restyler_.CodeOf({.style = style}); }
  const std::string& Name(int style) const {
    return data_.manifest.styles[static_cast<std::size_t>(style)].name;
  }

  Strip Real(const train::TrainingClip& clip, const char* what) const {
    return {what + (", " + Name(clip.style)) + " " +
                data_.manifest.contents[static_cast<std::size_t>(clip.content)] + ", " +
                std::filesystem::path(clip.file).filename().string(),
            clip.poses, std::min(kLead, clip.poses.size() / 4)};
  }
  Strip Styled(std::string caption, const net::StyleCode& code) const {
    return {std::move(caption), RestyleRecorded(restyler_, walk_.poses, code),
            std::min(kLead, walk_.poses.size() / 4), walk_.poses};
  }

  Picture References() const {
    Picture picture{"One source, an example each of some styles", {Real(walk_, "source")}};
    const std::size_t count = std::min<std::size_t>(kReferenced, present_.size());
    for (std::size_t i = 0; i < count; ++i) {
      const int style = present_[i * (present_.size() - 1) / (count - 1)];  // spread over the list
      const train::TrainingClip& example = *WalkOf(data_, style, walk_.content);
      picture.strips.push_back(
          Styled("output, " + Name(style) + " by the example below",
                 restyler_.CodeOf({.style = style, .references = {example.poses}})));
      picture.strips.push_back(Real(example, "example"));
    }
    return picture;
  }

  Picture Noises() const {
    Picture picture{"One source, three noises in two styles", {Real(walk_, "source")}};
    for (const int style : {pair_.first, pair_.second}) {
      for (std::uint64_t seed = 1; seed <= kNoises; ++seed) {
        picture.strips.push_back(
            Styled("output, " + Name(style) + ", noise " + std::to_string(seed),
                   restyler_.CodeOf({.style = style, .noise = seed})));
      }
      picture.strips.push_back(Real(*WalkOf(data_, style, walk_.content), "real"));
    }
    return picture;
  }

  Picture Between() const {
    Picture picture{"Between two styles", {Real(walk_, "source")}};
    const net::StyleCode from = Mean(pair_.first);
    const net::StyleCode to = Mean(pair_.second);
    for (const float share : {0.0F, 0.25F, 0.5F, 0.75F, 1.0F}) {
      net::StyleCode code(from.size());
      for (std::size_t i = 0; i < code.size(); ++i) {
        code[i] = (1 - share) * from[i] + share * to[i];
      }
      char text[16];
      std::snprintf(text, sizeof text, "%.2f", static_cast<double>(share));
      picture.strips.push_back(
          Styled("output, " + Name(pair_.first) + " to " + Name(pair_.second) + ", " + text, code));
    }
    return picture;
  }

  Picture Mixed() const {
    const MixedClip mixed = MakeMixed(data_);
    Picture picture{
        std::to_string(mixed.poses.size()) + " frames of mixed acts, all in " + Name(pair_.first),
        {},
        kWide};
    const Poses styled = RestyleRecorded(restyler_, mixed.poses, Mean(pair_.first));
    const std::size_t row = kWide * static_cast<std::size_t>(picture.figures);
    for (std::size_t begin = 0; begin < mixed.poses.size(); begin += row) {
      std::string acts;
      for (const MixedClip::Segment& segment : mixed.segments) {
        if (segment.begin >= begin + row || segment.end <= begin) continue;
        acts += (acts.empty() ? "" : ", ") +
                data_.manifest.contents[static_cast<std::size_t>(segment.content)];
      }
      const std::string from = " from frame " + std::to_string(begin) + ": " + acts;
      picture.strips.push_back({"source" + from, mixed.poses, begin});
      picture.strips.push_back({"output" + from, styled, begin, mixed.poses});
    }
    return picture;
  }

  const Data& data_;
  const ClipRestyler& restyler_;
  const train::TrainingClip& walk_;
  std::vector<int> present_;  // styles with a walk
  std::pair<int, int> pair_{0, 0};
};

}  // namespace

std::vector<Picture> PicturesOf(const Data& data, const ClipRestyler& restyler) {
  const std::vector<std::string>& contents = data.manifest.contents;
  const auto walk = std::find(contents.begin(), contents.end(), "walk");
  if (walk == contents.end()) return {};
  const train::TrainingClip* source =
      Painter::WalkOf(data, 0, static_cast<int>(walk - contents.begin()));
  return source == nullptr ? std::vector<Picture>() : Painter(data, restyler, *source).Paint();
}

}  // namespace styled::judge
