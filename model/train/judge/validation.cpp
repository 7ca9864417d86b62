#include "model/train/judge/validation.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "model/base/write_file.h"
#include "model/net/safetensors.h"
#include "model/net/sha256.h"
#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/data.h"
#include "model/train/judge/sha256.h"

namespace styled::judge {
namespace {

// Inputs in turn by noise and by an example.
std::function<Target(int, int)> BothTargets(const Data& data) {
  return [noise = TargetsOf(data, CodeFrom::kNoise),
          example = TargetsOf(data, CodeFrom::kReference)](int input, int style) {
    return input % 2 == 0 ? noise(input, style) : example(input, style);
  };
}

}  // namespace

struct Validator::Impl {
  Data data;
  Judges judges;
  Evaluator evaluator;

  Impl(Data data_, Judges judges_)
      : data(std::move(data_)),
        judges(std::move(judges_)),
        evaluator(data.manifest, judges, data.train, data.judge, data.validation) {}
};

Validator::Validator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Validator::~Validator() = default;
Validator::Validator(Validator&&) noexcept = default;

Result<Validator> Validator::Make(const std::filesystem::path& manifest,
                                  const std::filesystem::path& folder,
                                  const std::filesystem::path& cache,
                                  const JudgeSettings& settings) {
  Result<Data> data = LoadData(manifest, {}, folder);
  if (!data.ok()) return data.status();
  Result<Judges> judges = TrainJudges(data.value(), settings, cache);
  if (!judges.ok()) return judges.status();
  return Validator(std::make_unique<Impl>(std::move(data.value()), std::move(judges.value())));
}

Status Validator::Claim(const std::filesystem::path& run, bool resumed) const {
  const std::vector<net::NamedTensor> tensors = impl_->judges.Tensors();
  const std::string hash = net::Sha256(net::SerializeSafetensors(tensors, {}));
  const std::filesystem::path file = run / "judges.sha256";
  std::string before;
  std::ifstream(file) >> before;
  if (resumed && !before.empty() && before != hash) {
    return Status::Error(file.string() + ": the run's validation.csv is of judges of SHA-256 " +
                         Shown(before) + ", expected " + Shown(hash) +
                         ", those of this session: resume with the folder of judges that the run "
                         "began with, or without --validate");
  }
  std::error_code error;
  std::filesystem::create_directories(run, error);
  return WriteFileAtomically(file.string(), hash + "\n", 0644);
}

Result<std::vector<std::pair<std::string, double>>> Validator::Measure(
    const std::filesystem::path& weights) const {
  const Data& data = impl_->data;
  const auto styler = LoadAnyStyler(weights, data.manifest, {}, {});
  if (!styler.ok()) return styler.status();
  // The gate withholds styles from a network that still reconstructs badly.
  stylist::Options options;
  options.limb_gate = false;
  const Figures figures = impl_->evaluator.Measure(
      "", styler.value().clips ? Restyle(data, *styler.value().clips, BothTargets(data))
                               : Style(data, *styler.value().frames, options, false));
  Mean sra;
  Mean cra;
  Mean expression;
  Mean cosine;
  Mean fmd;
  Mean jitter;
  for (const StyleFigures& of : figures.styles) {
    if (of.sra.windows <= 0 || !std::isfinite(of.expression.fraction)) continue;
    sra.Add(of.sra.value / std::max(1e-6, of.sra_real.value));
    cra.Add(of.cra.value / std::max(1e-6, of.cra_input.value));
    expression.Add(of.expression.fraction);
    cosine.Add(of.expression.cosine);
    const double neutral = of.Distance(&Distances::fmd_neutral);
    if (neutral > 0) fmd.Add(of.Distance(&Distances::fmd) / neutral);
    jitter.Add(of.jitter_stream);
  }
  const double score = sra.value() + cra.value() + cosine.value() - fmd.value() -
                       std::abs(1 - expression.value()) - std::max(0.0, jitter.value() - 1);
  return std::vector<std::pair<std::string, double>>{
      {"score", score},           {"sra", sra.value()},
      {"cra", cra.value()},       {"expression", expression.value()},
      {"cosine", cosine.value()}, {"fmd", fmd.value()},
      {"jitter", jitter.value()}};
}

}  // namespace styled::judge
