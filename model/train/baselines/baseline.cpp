#include "model/train/baselines/baseline.h"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace styled::train::baselines {
namespace {

using stgcn::Features;
using stgcn::kFeatureCount;
using torch::Tensor;

constexpr int kCodesPerStyle = 60;  // clips that make a style's mean code
constexpr double kSayEvery_s = 15;
constexpr char kMeanKey[] = "features.mean";  // in the file of a trained network

st_gcn::Statistics StatisticsOf(const std::vector<TrainingClip>& clips,
                                stgcn::FeatureParameters& parameters) {
  const st_gcn::Statistics statistics = st_gcn::ComputeStatistics(clips, parameters);
  stgcn::SetHemisphere(statistics.mean, parameters);
  return statistics;
}

Tensor ToTensor(std::span<const float> values) {
  return torch::tensor(std::vector<float>(values.begin(), values.end()));
}

}  // namespace

// Collects the clip, and styles it at its end.
class BaselineStream final : public net::ClipStream {
 public:
  BaselineStream(const Baseline& baseline, const Features& mean, const Features& deviation,
                 const net::StyleCode& code)
      : baseline_(baseline), mean_(mean), deviation_(deviation), code_(ToTensor(code)) {}

  void Add(const body::Pose& pose) override { poses_.push_back(pose); }
  void End() override {
    if (poses_.empty()) return;
    const torch::NoGradGuard no_grad;
    const Tensor clip = baseline_.Read(poses_, &headings_rad_);
    own_ = baseline_.Own(clip).t().contiguous();
    styled_ = baseline_.Styled(clip, code_).t().contiguous();
  }
  bool Pop(net::Prediction& out) override {
    if (!styled_.defined() || taken_ == poses_.size()) return false;
    Decode(own_, out.reconstruction);
    Decode(styled_, out.styled);
    out.heading_rad = headings_rad_[taken_++];
    return true;
  }

 private:
  void Decode(const Tensor& clip, net::Decoded& out) const {
    const float* const frame =
        clip.data_ptr<float>() + static_cast<std::ptrdiff_t>(taken_) * kFeatureCount;
    Features features;
    for (std::size_t i = 0; i < features.size(); ++i) {
      features[i] = frame[i] * deviation_[i] + mean_[i];
    }
    body::Pose pose;
    stgcn::PoseOf(features, 0, pose);  // the hips stay relative to the heading
    out.rotations = pose.rotations;
    out.velocities_m_s.fill(0);
    out.hips_height_m = pose.hips_position_m.y();
  }

  const Baseline& baseline_;
  const Features& mean_;
  const Features& deviation_;
  const Tensor code_;
  std::vector<body::Pose> poses_;
  std::vector<float> headings_rad_;
  Tensor own_, styled_;  // [T, 147]
  std::size_t taken_ = 0;
};

Material::Material(const clip::Manifest& manifest, const std::vector<TrainingClip>& clips)
    : contents(static_cast<int>(manifest.contents.size())),
      statistics(StatisticsOf(clips, parameters)),
      store(clips, statistics, parameters, 8) {
  for (const clip::ManifestStyle& style : manifest.styles) {
    model.styles.push_back({style.name, style.aliases});
  }
}

Tensor Baseline::Read(std::span<const body::Pose> poses, std::vector<float>* headings_rad) const {
  const long frames = std::max<long>(kLeastFrames, (static_cast<long>(poses.size()) + 3) / 4 * 4);
  Tensor clip = torch::empty({frames, kFeatureCount});
  float* out = clip.data_ptr<float>();
  stgcn::HeadingState state;
  Features features;
  for (long t = 0; t < frames; ++t) {
    if (t < static_cast<long>(poses.size())) {
      const float heading_rad = stgcn::ComputeFeatures(poses[static_cast<std::size_t>(t)],
                                                       material_.parameters, state, features);
      if (headings_rad != nullptr) headings_rad->push_back(heading_rad);
    }
    for (std::size_t i = 0; i < features.size(); ++i) {
      *out++ = (features[i] - material_.statistics.mean[i]) / material_.statistics.deviation[i];
    }
  }
  return clip.t();
}

Baseline::Baseline(const Material& material, std::uint64_t seed)
    : material_(material), seed_(seed) {
  torch::manual_seed(seed);
}

void Baseline::TrainOrLoad(const Budget& budget, const std::filesystem::path& file) {
  if (std::filesystem::exists(file)) {
    Load(file);
  } else {
    networks().train();
    {
      const torch::AutoGradMode with_gradients(true);  // whatever the caller's is
      Train(budget);
    }
    for (const Tensor& parameter : networks().parameters()) {
      TORCH_CHECK(parameter.isfinite().all().item<bool>(), "the training diverged");
    }
    torch::serialize::OutputArchive archive;
    networks().save(archive);
    archive.write(kMeanKey, ToTensor(material_.statistics.mean), /*is_buffer=*/true);
    archive.save_to(file.string());
  }
  networks().eval();
  Prepare();
  ComputeMeanCodes();
}

// libtorch replaces a tensor by one of any shape.
void Baseline::Load(const std::filesystem::path& file) {
  torch::serialize::InputArchive archive;
  archive.load_from(file.string());
  std::vector<std::vector<int64_t>> shapes;
  for (const Tensor& parameter : networks().parameters()) shapes.push_back(parameter.sizes().vec());
  networks().load(archive);
  std::size_t i = 0;
  for (const Tensor& parameter : networks().parameters()) {
    TORCH_CHECK(parameter.sizes() == shapes[i++], file.string(), ": a network of other sizes");
  }
  Tensor mean;
  archive.read(kMeanKey, mean, /*is_buffer=*/true);
  TORCH_CHECK(mean.equal(ToTensor(material_.statistics.mean)), file.string(),
              ": trained on other clips");
}

void Baseline::ComputeMeanCodes() {
  const torch::NoGradGuard no_grad;
  std::vector<int> counts(model().styles.size(), 0);
  mean_codes_.assign(counts.size(), Tensor());
  for (int clip = 0; clip < material_.store.clips(); ++clip) {
    const auto style = static_cast<std::size_t>(material_.store.StyleOf(clip));
    if (counts[style] == kCodesPerStyle) continue;
    const std::vector<int>& starts = material_.store.Starts(clip);
    const Tensor window = material_.store.Read({{clip, starts[starts.size() / 2], false}});
    const Tensor code = CodeOf(window.view({st_gcn::kWindowFrames, kFeatureCount}).t()).flatten();
    mean_codes_[style] = counts[style]++ == 0 ? code : mean_codes_[style] + code;
  }
  for (std::size_t style = 0; style < counts.size(); ++style) {
    TORCH_CHECK(counts[style] > 0, "no training clip of style ", model().styles[style].name);
    mean_codes_[style] = mean_codes_[style] / counts[style];
  }
}

net::StyleCode Baseline::MakeCode(const net::StyleRequest& request) const {
  const torch::NoGradGuard no_grad;
  Tensor code = mean_codes_[0].clone();
  for (const net::StyleSource& source : request.sources) {
    const Tensor wanted = source.reference.empty()
                              ? mean_codes_[static_cast<std::size_t>(source.style)]
                              : CodeOf(Read(source.reference, nullptr)).flatten();
    code += request.strength * source.weight * (wanted - mean_codes_[0]);
  }
  code = code.contiguous();
  return {code.data_ptr<float>(), code.data_ptr<float>() + code.numel()};
}

net::NearestStyle Baseline::Nearest(const net::StyleCode& code) const {
  net::NearestStyle nearest{0, std::numeric_limits<float>::infinity()};
  const Tensor wanted = ToTensor(code);
  double between = 0;
  double pairs = 0;
  for (std::size_t style = 0; style < mean_codes_.size(); ++style) {
    const auto distance = (wanted - mean_codes_[style]).norm().item<float>();
    if (distance < nearest.distance) nearest = {static_cast<int>(style), distance};
    for (std::size_t other = 0; other < style; ++other, ++pairs) {
      between += (mean_codes_[style] - mean_codes_[other]).norm().item<double>();
    }
  }
  if (between > 0) nearest.distance /= static_cast<float>(between / pairs);
  return nearest;
}

std::unique_ptr<net::ClipStream> Baseline::MakeStream(const net::StyleCode& code, int,
                                                      net::Extent) const {
  return std::make_unique<BaselineStream>(*this, material_.statistics.mean,
                                          material_.statistics.deviation, code);
}

void Iterate(const Budget& budget, const std::function<void(double progress)>& step,
             const std::function<std::string()>& state) {
  const std::clock_t begin = std::clock();
  double reported_s = 0;
  for (long i = 0; i < budget.iterations; ++i) {
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const double by_time = seconds / (60 * budget.minutes);
    if (by_time >= 1) break;
    step(std::max(by_time, static_cast<double>(i) / static_cast<double>(budget.iterations)));
    if (seconds - reported_s < kSayEvery_s) continue;
    reported_s = seconds;
    std::fprintf(stderr, "%6ld iterations, %4.0f s: %s\n", i + 1, seconds, state().c_str());
  }
}

}  // namespace styled::train::baselines
