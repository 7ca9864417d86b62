#include "model/train/stgcn/monitor.h"

#include <ATen/CPUGeneratorImpl.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "model/train/stgcn/losses.h"

namespace styled::train::st_gcn {
namespace {

using torch::Tensor;

constexpr double kInCm = 100;       // a metre
constexpr double kTiny_m2 = 1e-12;  // m²; keeps a cosine without a change at 0
constexpr int kPerContent = 5;      // neutral windows that are watched
constexpr int kPerCell = 24;        // windows that judges learn from and shifts are measured in
constexpr double kRidge = 1e-2;     // of correlations of standardized statistics
constexpr uint64_t kNoiseSeed = 77;

// Windows of clips, spread over a cell's clips: at most `most` of each style and content.
struct Chosen {
  std::vector<Window> windows;
  std::vector<int64_t> style, content;
};
Chosen Choose(const WindowStore& store, int styles, int contents, int most, int only_style) {
  std::vector<std::vector<Window>> cells(static_cast<std::size_t>(styles) * contents);
  for (int clip = 0; clip < store.clips(); ++clip) {
    const int style = store.StyleOf(clip);
    if (only_style >= 0 && style != only_style) continue;
    int last = -1000;
    for (const int start : store.Starts(clip)) {
      if (start - last < kWindowFrames / 2) continue;
      last = start;
      cells[static_cast<std::size_t>(style) * contents + store.ContentOf(clip, start)].push_back(
          {clip, start, false});
    }
  }
  Chosen chosen;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const std::size_t count = cells[cell].size(), taken = std::min<std::size_t>(count, most);
    for (std::size_t i = 0; i < taken; ++i) {
      chosen.windows.push_back(cells[cell][i * count / taken]);
      chosen.style.push_back(static_cast<int64_t>(cell) / contents);
      chosen.content.push_back(static_cast<int64_t>(cell) % contents);
    }
  }
  return chosen;
}

Tensor Labels(const std::vector<int64_t>& labels) { return torch::tensor(labels, torch::kInt64); }

double Share(const Tensor& right) { return right.to(torch::kFloat32).mean().item<double>(); }

// Moments over time of windows: [N, 3 * 147].
Tensor Moments(const Tensor& windows) {
  const Tensor flat = windows.flatten(2);
  return torch::cat({flat.mean(1), flat.std(1), flat.diff(1, 1).abs().mean(1)}, 1);
}

double MeanJerk(const Tensor& positions) {
  const Tensor third = positions.diff(3, 1);
  return MeanDistance(third, torch::zeros_like(third)).item<double>();
}

}  // namespace

void QuickJudge::Learn(const Tensor& windows, const Tensor& label, int64_t labels) {
  const Tensor raw = Moments(windows);
  mean_ = raw.mean(0);
  deviation_ = raw.std(0) + 1e-3;
  const Tensor x = torch::cat({(raw - mean_) / deviation_, torch::ones({raw.size(0), 1})}, 1);
  const Tensor target = torch::one_hot(label, labels).to(torch::kFloat32);
  const Tensor weight = (1.0 / target.sum(0).clamp_min(1)).index_select(0, label).unsqueeze(1);
  const Tensor weighted = x * (weight / weight.sum());
  const Tensor correlation = torch::matmul(weighted.t(), x) + kRidge * torch::eye(x.size(1));
  weights_ = torch::linalg_solve(correlation, torch::matmul(weighted.t(), target));
}

Tensor QuickJudge::Judge(const Tensor& windows) const {
  const Tensor x = (Moments(windows) - mean_) / deviation_;
  return (torch::matmul(x, weights_.slice(0, 0, -1)) + weights_[-1]).argmax(1);
}

Monitor::Monitor(const WindowStore& train, const WindowStore& validation,
                 const std::vector<clip::ManifestStyle>& styles, int contents,
                 const Kinematics& kinematics, const torch::Device& device)
    : kinematics_(kinematics), device_(device) {
  for (const clip::ManifestStyle& style : styles) names_.push_back(style.name);
  const int count = static_cast<int>(styles.size());
  const Chosen neutral = Choose(validation, count, contents, kPerContent, 0);
  TORCH_CHECK(!neutral.windows.empty(), "the validation split has no neutral clip");
  source_ = validation.Read(neutral.windows).to(device);
  content_ = Labels(neutral.content);
  std::vector<Window> references;
  for (int style = 0; style < count; ++style) {
    const Chosen of_style = Choose(train, count, contents, 1, style);
    TORCH_CHECK(!of_style.windows.empty(), "no training clip of ", names_[style]);
    references.push_back(of_style.windows.front());
  }
  reference_ = train.Read(references).to(device);
  TeachJudges(train, validation, contents);
  MeasureShifts(train, contents);
}

void Monitor::TeachJudges(const WindowStore& train, const WindowStore& validation, int contents) {
  const int styles = static_cast<int>(names_.size());
  const Chosen known = Choose(train, styles, contents, kPerCell, -1);
  const Tensor windows = train.Read(known.windows);
  style_judge_.Learn(windows, Labels(known.style), styles);
  content_judge_.Learn(windows, Labels(known.content), contents);
  const Chosen fresh = Choose(validation, styles, contents, kPerCell, -1);
  const Tensor seen = validation.Read(fresh.windows);
  std::ostringstream text;
  text << "quick judges of " << seen.size(0) << " real validation windows: style "
       << Share(style_judge_.Judge(seen) == Labels(fresh.style)) << ", content "
       << Share(content_judge_.Judge(seen) == Labels(fresh.content));
  reals_ = text.str();
}

void Monitor::MeasureShifts(const WindowStore& train, int contents) {
  const int styles = static_cast<int>(names_.size());
  const Chosen known = Choose(train, styles, contents, kPerCell, -1);
  const Tensor poses =
      kinematics_.Positions_m(train.Read(known.windows).to(device_)).mean(1).flatten(1).cpu();
  const int64_t cells = int64_t{styles} * contents;
  const Tensor cell = Labels(known.style) * contents + Labels(known.content);
  const Tensor count = torch::zeros({cells}).index_add(0, cell, torch::ones({cell.size(0)}));
  const Tensor sum = torch::zeros({cells, poses.size(1)}).index_add(0, cell, poses);
  const Tensor mean = (sum / count.clamp_min(1).unsqueeze(1)).view({styles, contents, -1});
  const Tensor has = (count > 0).view({styles, contents});
  shift_m_ = mean - mean[0];
  present_ = has & has[0];
}

// The contribution of one style's outputs, one per source, to the figures; their sum is divided
// afterwards.
void Monitor::AddStyle(int64_t style, const Tensor& outputs, Kind& kind) const {
  const Tensor kept = present_[style].index_select(0, content_).nonzero().squeeze(1);
  if (kept.size(0) == 0) {
    kind.style_of.push_back(std::nan(""));
    return;
  }
  const Tensor content = content_.index_select(0, kept);
  const Tensor output = outputs.index_select(0, kept.to(device_)), judged = output.cpu();
  kind.style_of.push_back(Share(style_judge_.Judge(judged) == style));
  kind.style += kind.style_of.back();
  kind.content += Share(content_judge_.Judge(judged) == content);
  const Tensor after = kinematics_.Positions_m(output);
  const Tensor before = kinematics_.Positions_m(source_.index_select(0, kept.to(device_)));
  kind.jerk += MeanJerk(after) / MeanJerk(before);
  const Tensor change = (after - before).mean(1).cpu().flatten();
  const Tensor real = shift_m_[style].index_select(0, content).flatten();
  const double along = torch::dot(change, real).item<double>();
  const double length = real.norm().item<double>();
  kind.expression += along / (length * length);
  kind.cosine += along / (length * change.norm().item<double>() + kTiny_m2);
}

// `outputs`: of each style but neutral.
Monitor::Kind Monitor::Measure(const std::string& name, const std::vector<Tensor>& outputs) const {
  Kind kind;
  kind.name = name;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    AddStyle(static_cast<int64_t>(i) + 1, outputs[i], kind);
  }
  const auto missing = std::count_if(kind.style_of.begin(), kind.style_of.end(),
                                     [](double one) { return std::isnan(one); });
  const auto styles = static_cast<double>(outputs.size()) - static_cast<double>(missing);
  for (double* figure : {&kind.style, &kind.content, &kind.expression, &kind.cosine, &kind.jerk}) {
    *figure /= std::max(styles, 1.0);
  }
  return kind;
}

// Text and columns of one kind of code.
void Monitor::Report(const Kind& kind, MonitorReport& report) const {
  std::ostringstream text;
  text << " | " << kind.name;
  for (const auto& [figure, value] : {std::pair<const char*, double>{"style", kind.style},
                                      {"content", kind.content},
                                      {"expression", kind.expression},
                                      {"cosine", kind.cosine},
                                      {"jerk_ratio", kind.jerk}}) {
    report.figures.emplace_back(std::string(figure) + '_' + kind.name, value);
    text << ' ' << figure << ' ' << std::round(value * 100) / 100;
  }
  for (std::size_t i = 0; i < kind.style_of.size(); ++i) {
    report.figures.emplace_back("style_" + kind.name + '_' + names_[i + 1], kind.style_of[i]);
  }
  report.summary += text.str();
}

MonitorReport Monitor::Evaluate(const Networks& networks, const Graph& graph) const {
  const torch::NoGradGuard no_grad;
  const Generator& generator = networks.generator;
  const Encoder& encoder = networks.encoder;
  const int64_t count = source_.size(0), styles = static_cast<int64_t>(names_.size());
  const Tensor content = generator.Encode(graph, source_);
  const Tensor own =
      encoder.Code(encoder.Features(graph, source_), torch::zeros_like(content_).to(device_));
  const auto decode = [&](const Tensor& code) {
    return kinematics_.Published(generator.Decode(graph, content, code));
  };
  const Tensor reference_code =
      encoder.Code(encoder.Features(graph, reference_), torch::arange(styles).to(device_));
  const at::Generator random = at::detail::createCPUGenerator(kNoiseSeed);
  std::vector<Tensor> by_noise, by_reference;
  double apart_m = 0;
  for (int64_t style = 1; style < styles; ++style) {
    const Tensor label = torch::full({count}, style, torch::kInt64).to(device_);
    const auto noise = [&] {
      return torch::randn({count, generator.shape.noise}, random).to(device_);
    };
    by_noise.push_back(decode(networks.mapping(noise(), label)));
    const Tensor other = decode(networks.mapping(noise(), label));
    apart_m +=
        MeanDistance(kinematics_.Positions_m(by_noise.back()), kinematics_.Positions_m(other))
            .item<double>();
    by_reference.push_back(decode(reference_code[style].expand({count, -1}).contiguous()));
  }
  const double identity_m =
      MeanDistance(kinematics_.Positions_m(decode(own)), kinematics_.Positions_m(source_))
          .item<double>();
  MonitorReport report;
  std::ostringstream text;
  report.figures = {{"identity_cm", kInCm * identity_m},
                    {"apart_cm", kInCm * apart_m / static_cast<double>(styles - 1)}};
  text << "identity " << kInCm * identity_m << " cm, apart " << report.figures[1].second << " cm";
  report.summary = text.str();
  Judge("noise", by_noise, report);
  Judge("reference", by_reference, report);
  return report;
}

}  // namespace styled::train::st_gcn
