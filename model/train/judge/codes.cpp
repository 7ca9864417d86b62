#include "model/train/judge/codes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "model/clip/clip.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr std::size_t kExample = 64;   // frames of an example, at least
constexpr std::size_t kLongest = 150;  // frames of an input: 5 s
constexpr std::size_t kExamples = 10;  // of one style and content, at most
constexpr std::array kLine{0.0F, 0.25F, 0.5F, 0.75F, 1.0F};

using Example = std::span<const body::Pose>;

// All measurements on one set of weights.
class Measurement {
 public:
  Measurement(const Data& data, const Judges& judges, const ClipRestyler& restyler)
      : data_(data), judges_(judges), restyler_(restyler) {
    for (int content = 0; content < contents(); ++content) {
      std::size_t longest = 0;
      for (std::size_t i = 0; i < data.inputs.size(); ++i) {
        if (data.contents[i] == content) longest = std::max(longest, data.inputs[i].size());
      }
      Poses input;
      for (std::size_t i = 0; i < data.inputs.size() && input.empty(); ++i) {
        if (data.contents[i] == content && data.inputs[i].size() == longest) {
          input = Thin(data.inputs[i]);
        }
      }
      if (input.size() > kLongest) input.resize(kLongest);
      inputs_.push_back(std::move(input));
    }
    for (int style = 1; style < styles(); ++style) {
      if (restyler.Has(style)) present_.push_back(style);
    }
  }

  CodeSpace Measure(int count) {
    codes_.noise.by_style.resize(static_cast<std::size_t>(styles()));
    codes_.examples.by_style.resize(codes_.noise.by_style.size());
    codes_.real_by_content.resize(static_cast<std::size_t>(contents()));
    deviations_.resize(static_cast<std::size_t>(contents()));
    Mean between;  // mean codes
    for (const int a : present_) {
      for (const int b : present_) {
        if (b < a)
          between.Add(Apart(restyler_.CodeOf({.style = a}), restyler_.CodeOf({.style = b})));
      }
    }
    for (int content = 0; content < contents(); ++content) {
      if (inputs_[static_cast<std::size_t>(content)].empty()) continue;
      MeasureNoise(content, count, between.value());
      for (const int style : present_) MeasureExamples(content, style, count);
    }
    Follow();
    MeasureLines();
    return codes_;
  }

 private:
  int styles() const { return static_cast<int>(data_.manifest.styles.size()); }
  int contents() const { return static_cast<int>(data_.manifest.contents.size()); }
  const Poses& Input(int content) const { return inputs_[static_cast<std::size_t>(content)]; }

  static double Apart(const net::StyleCode& a, const net::StyleCode& b) {
    const auto size = static_cast<Eigen::Index>(a.size());
    return CodeDistance(Eigen::Map<const Eigen::VectorXf>(a.data(), size),
                        Eigen::Map<const Eigen::VectorXf>(b.data(), size));
  }

  // An input's output by a code, at kJudgeRate_hz.
  Poses By(int content, const net::StyleCode& code) const {
    if (restyler_.rate_hz() == kJudgeRate_hz) return restyler_.RestyleBy(Input(content), code);
    return Thin(restyler_.RestyleBy(
        clip::ResamplePoses(Input(content), kJudgeRate_hz, kStreamRate_hz), code));
  }
  LocalClip Local(const Poses& poses) const { return LocalPositions(poses, kJudgeRate_hz); }

  void AddSet(const std::vector<Poses>& outputs, int content, int style, Variety& variety) const {
    std::vector<LocalClip> set;
    for (const Poses& output : outputs) {
      set.push_back(Local(output));
      const std::vector<Verdicts> by_judge =
          judges_.Judge(MakeSequence(output, style, content, false, judges_.parameters()), kStride);
      const auto windows = static_cast<double>(by_judge.front().starts.size());
      variety.recognized.AddJudged(Hits(by_judge, &Verdicts::style, style), windows);
      variety.content_recognized.AddJudged(Hits(by_judge, &Verdicts::content, content), windows);
    }
    const Mean distance = PairwiseDistance_cm(set);
    if (distance.count <= 0) return;
    variety.distance_cm.Add(distance.value());
    variety.by_style[static_cast<std::size_t>(style)].Add(distance.value());
  }

  void MeasureNoise(int content, int count, double between) {
    std::vector<std::vector<double>> moved;  // by style, by seed
    const Eigen::VectorXd of_input = MeanPoseOf(Local(Input(content)));
    for (const int style : present_) {
      std::vector<Poses> outputs;
      std::vector<double>& here = moved.emplace_back();
      for (int seed = 0; seed < count; ++seed) {
        const net::StyleCode code =
            restyler_.CodeOf({.style = style, .noise = static_cast<std::uint64_t>(seed + 1)});
        outputs.push_back(By(content, code));
        here.push_back((MeanPoseOf(Local(outputs.back())) - of_input).norm());
        const net::StyleCode read =
            restyler_.CodeOf({.style = style, .references = {outputs.back()}});
        if (between > 0) codes_.consistency.Add(Apart(code, read) / between);
      }
      AddSet(outputs, content, style, codes_.noise);
    }
    for (std::size_t a = 0; a < moved.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const double correlation = RankCorrelation(moved[a], moved[b]);
        if (std::isfinite(correlation)) codes_.intensity.Add(correlation);
      }
    }
  }

  // Real clips of a style and content that are long enough for an example.
  std::vector<Example> Examples(int style, int content) const {
    std::vector<Example> examples;
    for (const train::TrainingClip& clip : data_.validation) {
      if (clip.style != style || clip.content != content || clip.poses.size() < kExample) continue;
      if (examples.size() < kExamples) examples.emplace_back(clip.poses);
    }
    return examples;
  }
  Poses ByExample(int content, int style, Example example) const {
    return By(content, restyler_.CodeOf({.style = style, .references = {example}}));
  }

  void MeasureExamples(int content, int style, int count) {
    const std::vector<Example> examples = Examples(style, content);
    std::vector<Poses> outputs;
    std::vector<LocalClip> real;
    for (const Example example : examples) {
      real.push_back(LocalPositions(example, kJudgeRate_hz));
      outputs.push_back(ByExample(content, style, example));
    }
    const Mean apart = ShiftedPairwiseDistance_cm(real, kExample / 2);
    if (apart.count > 0) {
      codes_.real_cm.Add(apart.value());
      codes_.real_by_content[static_cast<std::size_t>(content)].Add(apart.value());
    }
    if (examples.size() >= 3) AddDeviations(content, real, outputs);
    if (examples.size() >= 2) MeasureHalves(content, style, examples);
    outputs.resize(std::min(outputs.size(), static_cast<std::size_t>(count)));
    AddSet(outputs, content, style, codes_.examples);
  }

  void AddDeviations(int content, const std::vector<LocalClip>& real,
                     const std::vector<Poses>& outputs) {
    const auto count = static_cast<double>(real.size());
    Eigen::VectorXd mean_real = Eigen::VectorXd::Zero(3 * body::kJointCount);
    Eigen::VectorXd mean_output = mean_real;
    for (std::size_t i = 0; i < real.size(); ++i) {
      mean_real += MeanPoseOf(real[i]) / count;
      mean_output += MeanPoseOf(Local(outputs[i])) / count;
    }
    for (std::size_t i = 0; i < real.size(); ++i) {
      deviations_[static_cast<std::size_t>(content)].push_back(
          {MeanPoseOf(real[i]) - mean_real, MeanPoseOf(Local(outputs[i])) - mean_output});
    }
  }

  void Follow() {
    std::vector<Deviation> of_all;
    for (std::size_t content = 0; content < deviations_.size(); ++content) {
      codes_.following.push_back(MeasureFollowing(deviations_[content]));
      const std::vector<std::size_t>& labels = data_.manifest.content_labels;
      if (content < labels.size() && labels[content] > 1) continue;
      of_all.insert(of_all.end(), deviations_[content].begin(), deviations_[content].end());
    }
    codes_.of_all = MeasureFollowing(of_all);
  }

  // The first example's halves against the second example.
  void MeasureHalves(int content, int style, const std::vector<Example>& examples) {
    const auto longest =
        std::max_element(examples.begin(), examples.end(),
                         [](const Example& a, const Example& b) { return a.size() < b.size(); });
    if (longest->size() < 2 * kExample) return;
    const Example other = longest == examples.begin() ? examples[1] : examples[0];
    const std::size_t half = longest->size() / 2;
    const auto local = [&](Example example) { return Local(ByExample(content, style, example)); };
    const double ratio =
        HalvesRatio(local(longest->first(half)), local(longest->last(half)), local(other));
    if (std::isfinite(ratio)) codes_.halves.Add(ratio);
  }

  void MeasureLines() {
    const std::vector<std::string>& names = data_.manifest.contents;
    const auto walk = std::find(names.begin(), names.end(), "walk");
    const int content = walk == names.end() ? 0 : static_cast<int>(walk - names.begin());
    if (Input(content).empty()) return;
    for (const int a : present_) {
      for (const int b : present_) {
        if (b >= a) continue;
        const net::StyleCode from = restyler_.CodeOf({.style = a});
        const net::StyleCode to = restyler_.CodeOf({.style = b});
        std::vector<LocalClip> outputs;
        for (const float t : kLine) {
          net::StyleCode code(from.size());
          for (std::size_t i = 0; i < code.size(); ++i) code[i] = (1 - t) * from[i] + t * to[i];
          outputs.push_back(Local(By(content, code)));
        }
        const Interpolation line = MeasureInterpolation(outputs);
        codes_.pairs += 1;
        codes_.monotone += line.monotone ? 1 : 0;
        if (!std::isfinite(line.places[1])) continue;  // both ends are equal
        codes_.quarter.Add(line.places[1]);
        codes_.half.Add(line.places[2]);
        codes_.three_quarters.Add(line.places[3]);
        codes_.largest_step = std::fmax(codes_.largest_step, line.largest_step);
      }
    }
  }

  const Data& data_;
  const Judges& judges_;
  const ClipRestyler& restyler_;
  std::vector<Poses> inputs_;                       // by content
  std::vector<int> present_;                        // styles
  std::vector<std::vector<Deviation>> deviations_;  // by content
  CodeSpace codes_;
};

nlohmann::json ToJson(const clip::Manifest& manifest, const Variety& variety) {
  nlohmann::json json = {{"distance_cm", Value(Measured(variety.distance_cm))},
                         {"recognized", Value(Measured(variety.recognized))},
                         {"recognized_spread", Value(variety.recognized.spread())},
                         {"content_recognized", Value(Measured(variety.content_recognized))},
                         {"content_recognized_spread", Value(variety.content_recognized.spread())},
                         {"windows", variety.recognized.count}};
  for (std::size_t style = 1; style < variety.by_style.size(); ++style) {
    json["styles"][manifest.styles[style].name] = Value(Measured(variety.by_style[style]));
  }
  return json;
}

void PrintVariety(const clip::Manifest& manifest, const CodeSpace& codes) {
  std::printf(
      "\nvariety: distance between outputs of one input in one style (real clips of a style and "
      "content, after the best shift: %s cm",
      Padded(Measured(codes.real_cm), 0, 2).c_str());
  for (std::size_t c = 0; c < codes.real_by_content.size(); ++c) {
    std::printf("%s %s %s", c == 0 ? ";" : ",", manifest.contents[c].c_str(),
                Padded(Measured(codes.real_by_content[c]), 0, 2).c_str());
  }
  std::printf(")\n%-10s %9s %10s %9s %8s", "", "APD cm", "recognized", "content", "windows");
  for (std::size_t style = 1; style < manifest.styles.size(); ++style) {
    std::printf(" %9.9s", manifest.styles[style].name.c_str());
  }
  std::printf("\n");
  for (const auto& [name, variety] :
       {std::pair("noise", &codes.noise), std::pair("examples", &codes.examples)}) {
    std::printf("%-10s %s %s %s %8.0f", name, Padded(Measured(variety->distance_cm), 9, 2).c_str(),
                Padded(variety->recognized, 10, 2).c_str(),
                Padded(variety->content_recognized, 9, 2).c_str(), variety->recognized.count);
    for (std::size_t style = 1; style < variety->by_style.size(); ++style) {
      std::printf(" %s", Padded(Measured(variety->by_style[style]), 9, 2).c_str());
    }
    std::printf("\n");
  }
}

void PrintFollowing(const clip::Manifest& manifest, const CodeSpace& codes) {
  std::printf("following: slope %s, cosine %s of %d examples",
              Padded(codes.of_all.slope, 0, 2).c_str(), Padded(codes.of_all.cosine, 0, 2).c_str(),
              codes.of_all.examples);
  for (std::size_t c = 0; c < codes.following.size(); ++c) {
    std::printf("%s%s %s, %s", c == 0 ? " (" : "; ", manifest.contents[c].c_str(),
                Padded(codes.following[c].slope, 0, 2).c_str(),
                Padded(codes.following[c].cosine, 0, 2).c_str());
  }
  std::printf("); halves of one example over two: %s\n",
              Padded(Measured(codes.halves), 0, 2).c_str());
}

nlohmann::json ToJson(const Following& following) {
  return {{"slope", Value(following.slope)},
          {"cosine", Value(following.cosine)},
          {"examples", following.examples}};
}

}  // namespace

CodeSpace MeasureCodes(const Data& data, const Judges& judges, const ClipRestyler& restyler,
                       int count) {
  return Measurement(data, judges, restyler).Measure(count);
}

void Print(const clip::Manifest& manifest, const CodeSpace& codes) {
  PrintVariety(manifest, codes);
  std::printf(
      "read off: %s of the distance between styles; strength of one noise in two styles: rank "
      "correlation %s\n",
      Padded(Measured(codes.consistency), 0, 2).c_str(),
      Padded(Measured(codes.intensity), 0, 2).c_str());
  PrintFollowing(manifest, codes);
  std::printf(
      "between styles: monotone in %d of %d pairs, at 1/4, 1/2, 3/4: %s, %s, %s; largest "
      "step %s of the mean\n",
      codes.monotone, codes.pairs, Padded(Measured(codes.quarter), 0, 2).c_str(),
      Padded(Measured(codes.half), 0, 2).c_str(),
      Padded(Measured(codes.three_quarters), 0, 2).c_str(),
      Padded(codes.largest_step, 0, 2).c_str());
}

nlohmann::json ToJson(const clip::Manifest& manifest, const CodeSpace& codes) {
  nlohmann::json by_content;
  for (std::size_t c = 0; c < codes.real_by_content.size(); ++c) {
    by_content[manifest.contents[c]] = Value(Measured(codes.real_by_content[c]));
  }
  nlohmann::json following = ToJson(codes.of_all);
  following["halves"] = Value(Measured(codes.halves));
  for (std::size_t c = 0; c < codes.following.size(); ++c) {
    following["contents"][manifest.contents[c]] = ToJson(codes.following[c]);
  }
  return {{"noise", ToJson(manifest, codes.noise)},
          {"examples", ToJson(manifest, codes.examples)},
          {"real_cm", Value(Measured(codes.real_cm))},
          {"real_contents", std::move(by_content)},
          {"consistency", Value(Measured(codes.consistency))},
          {"intensity", Value(Measured(codes.intensity))},
          {"following", std::move(following)},
          {"interpolation",
           {{"pairs", codes.pairs},
            {"monotone", codes.monotone},
            {"quarter", Value(Measured(codes.quarter))},
            {"half", Value(Measured(codes.half))},
            {"three_quarters", Value(Measured(codes.three_quarters))},
            {"largest_step", Value(codes.largest_step)}}}};
}

}  // namespace styled::judge
