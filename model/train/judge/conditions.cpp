#include "model/train/judge/conditions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "model/clip/clip.h"
#include "model/rig/dialects.h"
#include "model/train/judge/acts.h"
#include "model/train/judge/details.h"
#include "model/train/judge/metrics.h"
#include "model/train/judge/perturb.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

// Means over styles.
struct ConditionRow {
  Share sra, cra;
  double expression = 0, cosine = 0, jerk = 0;
};

ConditionRow Summary(const Figures& figures) {
  Mean expression;
  Mean cosine;
  Mean jerk;
  for (const StyleFigures& of : figures.styles) {
    if (of.sra.windows <= 0 || !std::isfinite(of.expression.fraction)) continue;
    expression.Add(of.expression.fraction);
    cosine.Add(of.expression.cosine);
    jerk.Add(of.jitter_stream);
  }
  return {figures.sra, figures.cra, expression.value(), cosine.value(), jerk.value()};
}

std::string Cells(const ConditionRow& row) {
  return Padded(row.sra, 5, 3) + Padded(row.expression, 7, 2) + Padded(row.cosine, 7, 2) +
         Padded(row.jerk, 7, 2);
}

nlohmann::json RowToJson(const ConditionRow& row) {
  return {{"sra", Value(Measured(row.sra))},
          {"sra_spread", Value(row.sra.spread())},
          {"cra", Value(Measured(row.cra))},
          {"cra_spread", Value(row.cra.spread())},
          {"expression", row.expression},
          {"expression_cosine", row.cosine},
          {"jitter", row.jerk}};
}

// Adds a share as one value, with its judges' where there are several.
void AddOnce(const Share& share, Mean& mean) {
  if (share.windows <= 0) return;
  if (share.by_judge.empty()) return mean.Add(share.value);
  mean.AddJudged(share.by_judge, 1);
}

// Every `step`-th input of each content: enough for a mean, in a fraction of the time.
Data Some(const Data& data, int step) {
  Data some = data;
  some.inputs.clear();
  some.contents.clear();
  std::vector<int> seen(data.manifest.contents.size(), 0);
  for (std::size_t i = 0; i < data.inputs.size(); ++i) {
    if (seen[static_cast<std::size_t>(data.contents[i])]++ % step != 0) continue;
    some.inputs.push_back(data.inputs[i]);
    some.contents.push_back(data.contents[i]);
  }
  return some;
}

// Real clips of the target styles, perturbed like the inputs.
std::vector<Transferred> RealPerturbed(const Data& data, const Styler& styler, Perturbation kind,
                                       const std::vector<Poses>& inputs) {
  std::vector<Transferred> out;
  for (std::size_t i = 0; i < data.validation.size(); ++i) {
    const train::TrainingClip& c = data.validation[i];
    if (c.style == 0 || styler.style_of[static_cast<std::size_t>(c.style)] == kAbsent) continue;
    out.push_back({static_cast<int>(i), c.style, c.content, inputs[i],
                   Perturb(kind, inputs[i], kStreamRate_hz, i + 1)});
  }
  return out;
}

float LargestTurn_deg(std::span<const body::Pose> poses) {
  float most = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    most = std::max(most, Turn_deg(poses[i - 1], poses[i]));
  }
  return most;
}

Poses Beginning(std::span<const body::Pose> poses) {
  return Thin(poses.first(std::min(poses.size(), static_cast<std::size_t>(6 * kStreamRate_hz))));
}

}  // namespace

nlohmann::json JudgePerturbed(const Data& data, const Styler& styler, const Evaluator& evaluator,
                              const stylist::Options& options) {
  std::printf(
      "\nspoilt inputs: SRA of real clips spoilt alike; of the constant offset; SRA, expression, "
      "cosine, jerk over the spoilt input's; absolute\n");
  std::vector<Poses> real;
  for (const train::TrainingClip& c : data.validation) {
    real.push_back(clip::ResamplePoses(c.poses, kJudgeRate_hz, kStreamRate_hz));
  }
  nlohmann::json json;
  for (std::size_t kind = 0; kind < kPerturbations.size(); ++kind) {
    const auto& [key, text] = kPerturbations[kind];
    const auto perturbation = static_cast<Perturbation>(kind);
    Data spoilt = data;
    for (std::size_t i = 0; i < data.inputs.size(); ++i) {
      spoilt.inputs[i] = Perturb(perturbation, data.inputs[i], kStreamRate_hz, i + 1);
    }
    const Share known = evaluator.Measure("", RealPerturbed(data, styler, perturbation, real)).sra;
    const Share offset = evaluator.Measure("", ApplyBaseline(spoilt)).sra;
    const ConditionRow detail =
        Summary(evaluator.Measure("", Style(spoilt, styler, options, false)));
    const ConditionRow absolute =
        Summary(evaluator.Measure("", Style(spoilt, styler, options, true)));
    std::printf("  %-42.*s %s  %s   %s\n", static_cast<int>(text.size()), text.data(),
                Padded(known, 5, 3).c_str(), Padded(offset, 5, 3).c_str(),
                (Cells(detail) + "   " + Cells(absolute)).c_str());
    json[std::string(key)] = {{"text", text},
                              {"real_sra", Value(Measured(known))},
                              {"real_sra_spread", Value(known.spread())},
                              {"offset_sra", Value(Measured(offset))},
                              {"offset_sra_spread", Value(offset.spread())},
                              {"detail_preserving", RowToJson(detail)},
                              {"absolute", RowToJson(absolute)}};
  }
  return json;
}

nlohmann::json JudgeRates(const Data& data, const Styler& styler, const Evaluator& evaluator,
                          const stylist::Options& options) {
  constexpr std::array kRates_hz{24.0, 25.0,  30.0,   48.0,  50.0,  59.94, 60.0,
                                 90.0, 100.0, 119.88, 120.0, 144.0, 240.0};
  std::printf("\nrates: SRA, expression, cosine, jerk at that rate, CRA\n");
  const Data some = Some(data, 3);
  // No rate changes these two: they are computed frame by frame.
  std::printf("  constant offset, any rate %s; real clips %s\n",
              Padded(evaluator.Measure("", ApplyBaseline(some)).sra, 5, 3).c_str(),
              Padded(evaluator.real_style(), 5, 3).c_str());
  nlohmann::json json;
  for (const double rate_hz : kRates_hz) {
    std::vector<Transferred> transferred;
    Mean jerk_in;
    Mean jerk_out;
    for (std::size_t i = 0; i < some.inputs.size(); ++i) {
      const Poses at_rate = clip::ResamplePoses(some.inputs[i], kStreamRate_hz, rate_hz);
      for (std::size_t style = 1; style < styler.style_of.size(); ++style) {
        if (styler.style_of[style] == kAbsent) continue;
        Switch start{0, OneStyle(styler.style_of[style], false)};
        start.settings.input_content = styler.ContentOf(some.contents[i]);
        const Poses styled =
            StyleStream(styler.network, styler.binding, options, {&start, 1}, at_rate, rate_hz);
        jerk_in.Add(MeanJerk(at_rate, rate_hz));
        jerk_out.Add(MeanJerk(styled, rate_hz));
        Poses output = clip::ResamplePoses(styled, rate_hz, kStreamRate_hz);
        output.resize(some.inputs[i].size(), output.back());  // the last period may be missing
        transferred.push_back({static_cast<int>(i), static_cast<int>(style), some.contents[i],
                               some.inputs[i], std::move(output)});
      }
    }
    ConditionRow row = Summary(evaluator.Measure("", transferred));
    row.jerk = jerk_out.value() / std::max(1e-9, jerk_in.value());
    std::printf("  %6.2f Hz  %s  %s\n", rate_hz, Cells(row).c_str(), Padded(row.cra, 5, 3).c_str());
    json.push_back(RowToJson(row));
    json.back()["rate_hz"] = rate_hz;
  }
  return json;
}

nlohmann::json JudgeStyledInputs(const Data& data, const Styler& styler, const Evaluator& evaluator,
                                 const stylist::Options& options) {
  const std::vector<clip::ManifestStyle>& styles = data.manifest.styles;
  nlohmann::json json;
  for (const bool told : {false, true}) {
    std::printf("\nperformers in a style already, the network told %s, SRA per target\n  %-14s",
                told ? "so" : "neutral", "");
    for (const clip::ManifestStyle& style : styles) std::printf(" %.9s", style.name.c_str());
    std::printf("\n");
    Mean to_styles;
    Mean to_neutral;
    Mean of_offset;
    nlohmann::json& here = json[told ? "told" : "not_told"];
    for (std::size_t from = 1; from < styles.size(); ++from) {
      if (styler.style_of[from] == kAbsent) continue;
      Data own = data;
      own.inputs.clear();
      own.contents.clear();
      for (const train::TrainingClip& c : data.validation) {
        if (c.style != static_cast<int>(from)) continue;
        own.inputs.push_back(clip::ResamplePoses(c.poses, kJudgeRate_hz, kStreamRate_hz));
        own.contents.push_back(c.content);
      }
      if (own.inputs.empty()) continue;
      Styler others = styler;
      others.style_of[from] = kAbsent;
      others.input_style = told ? styler.style_of[from] : 0;
      if (told) others.style_of[0] = 0;
      const Data some = Some(own, 2);
      const Figures figures = evaluator.Measure("", Style(some, others, options, false));
      // A constant offset turns from neutral to the target, whatever style the performer is in.
      const Figures by_offset = evaluator.Measure("", ApplyBaseline(some));
      for (std::size_t to = 1; to < styles.size(); ++to) {
        if (others.style_of[to] != kAbsent) AddOnce(by_offset.styles[to].sra, of_offset);
      }
      std::printf("  %-14s", styles[from].name.c_str());
      for (std::size_t to = 0; to < styles.size(); ++to) {
        const int width = std::min<int>(9, static_cast<int>(styles[to].name.size()));
        if (others.style_of[to] == kAbsent) {
          std::printf(" %*s", width, "-");
          continue;
        }
        const Share& sra = figures.styles[to].sra;
        std::printf(" %*.2f", width, sra.value);
        here[styles[from].name][styles[to].name] = sra.value;
        AddOnce(sra, to == 0 ? to_neutral : to_styles);
      }
      std::printf("\n");
    }
    std::printf("  mean to other styles %s", Padded(to_styles, 5, 3).c_str());
    here["mean"] = to_styles.value();
    here["mean_spread"] = Value(to_styles.spread());
    if (told) {
      std::printf(", to neutral %s", Padded(to_neutral, 5, 3).c_str());
      here["mean_to_neutral"] = to_neutral.value();
      here["mean_to_neutral_spread"] = Value(to_neutral.spread());
    }
    std::printf("; constant offset %s; real clips %s\n", Padded(of_offset, 5, 3).c_str(),
                Padded(evaluator.real_style(), 5, 3).c_str());
    here["mean_of_offset"] = of_offset.value();
    here["mean_of_offset_spread"] = Value(of_offset.spread());
  }
  return json;
}

Result<nlohmann::json> JudgeOtherClips(std::span<const std::filesystem::path> files,
                                       const Styler& styler, const stylist::Options& options,
                                       std::vector<Scene>& scenes) {
  std::printf(
      "\nother rigs' clips: worst style's jerk over the input's at 120 Hz; largest turn of one "
      "joint between frames, input and worst style, degrees; acts kept, means over styles: reach, "
      "degrees off, height of a kick\n");
  nlohmann::json json;
  for (const std::filesystem::path& file : files) {
    Result<clip::Clip> read = clip::ReadBvh(file);
    if (!read.ok()) return read.status();
    Result<rig::Binding> bound = rig::BindDialect(read.value().skeleton, "auto");
    if (!bound.ok()) return Status::Error(file.string() + ": " + bound.status().message());
    Poses input = clip::ToCanonical(read.value(), bound.value());
    if (std::abs(read.value().rate_hz / kStreamRate_hz - 1) > 1e-3) {
      input = clip::ResamplePoses(input, read.value().rate_hz, kStreamRate_hz);
    }
    const double jerk_in = MeanJerk(input, kStreamRate_hz).value();
    const float turn_in_deg = LargestTurn_deg(input);
    double worst_jerk = 0;
    float worst_turn_deg = 0;
    ActsKept acts;
    std::string jerks_as;
    std::string turns_as;
    const std::string name = file.filename().string();
    for (int style = 1; style < static_cast<int>(styler.network->model().styles.size()); ++style) {
      const std::string& style_name =
          styler.network->model().styles[static_cast<std::size_t>(style)].name;
      const Switch start{0, OneStyle(style, false)};
      const Poses out = StyleStream(styler.network, styler.binding, options, {&start, 1}, input);
      scenes.push_back({name, style_name, Beginning(input), {}, Beginning(out)});
      const double jerk = MeanJerk(out, kStreamRate_hz).value() / std::max(1e-9, jerk_in);
      const float turn_deg = LargestTurn_deg(out);
      const ActsKept kept = MeasureActs(input, out, kStreamRate_hz);
      acts.Add(kept);
      json[name]["styles"][style_name] = {
          {"jitter_120", jerk}, {"largest_turn_deg", turn_deg}, {"acts", ToJson(kept)}};
      if (jerk > worst_jerk) worst_jerk = jerk, jerks_as = style_name;
      if (turn_deg > worst_turn_deg) worst_turn_deg = turn_deg, turns_as = style_name;
    }
    json[name]["input_largest_turn_deg"] = turn_in_deg;
    std::printf("  %-28s %5.2f (%s)   %5.1f  %5.1f (%s)  %s %s %s\n", name.c_str(), worst_jerk,
                jerks_as.c_str(), turn_in_deg, worst_turn_deg, turns_as.c_str(),
                Padded(Measured(acts.reach), 5, 2).c_str(),
                Padded(Measured(acts.direction_deg), 5, 1).c_str(),
                Padded(Measured(acts.kick_height), 5, 2).c_str());
  }
  return json;
}

}  // namespace styled::judge
