#include "model/train/judge/details.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr std::array kGaits{"walk", "run"};

nlohmann::json ToJson(const Gait& gait) {
  nlohmann::json json;
  for (const GaitColumn& column : kGaitColumns)
    json[column.key] = Value(Measured(gait.*column.figure));
  json["clips"] = gait.mean_knee_deg.count;
  return json;
}

double Worst(const JerkRatios& jerk) { return jerk.worst_clip < 0 ? kNotMeasured : jerk.worst; }

nlohmann::json ToJson(const JerkRatios& jerk) {
  return {
      {"mean_of_clips", Value(Measured(jerk.clip))},
      {"largest", Value(Measured(jerk.largest))},
      {"worst_clip", jerk.worst_clip < 0 ? nlohmann::json(nullptr) : nlohmann::json(jerk.worst)},
      {"first_quarter_second", Value(Measured(jerk.first_quarter_second))},
      {"after_first_second", Value(Measured(jerk.after_first_second))},
      {"clips", jerk.clip.count}};
}

std::string Title(const GaitColumn& column) {
  char text[32];
  std::snprintf(text, sizeof text, " %14s", std::string(column.title).c_str());
  return text;
}

void PrintGaitRow(const std::string& name, const char* of, const Gait& gait) {
  std::printf("%-14.14s %-7s", name.c_str(), of);
  for (const GaitColumn& column : kGaitColumns) {
    std::printf(" %s", Padded(Measured(gait.*column.figure), 14, column.decimals).c_str());
  }
  std::printf("  %.0f\n", gait.mean_knee_deg.count);
}

void PrintGaits(const clip::Manifest& manifest, const Details& details) {
  for (std::size_t gait = 0; gait < details.gaits.size(); ++gait) {
    std::printf("\n%s, content %s\n%-14s %-7s", details.title.c_str(), details.gaits[gait].c_str(),
                "style", "");
    for (const GaitColumn& column : kGaitColumns) std::printf("%s", Title(column).c_str());
    std::printf("  clips\n");
    PrintGaitRow("neutral", "input", details.gait_input[gait]);
    for (std::size_t style = 1; style < details.styles.size(); ++style) {
      PrintGaitRow(manifest.styles[style].name, "real", details.styles[style].gait_real[gait]);
      PrintGaitRow("", "output", details.styles[style].gait_output[gait]);
    }
  }
}

void PrintRow(const std::string& name, const JerkRatios& jerk, const ActsKept& acts) {
  std::printf("%-14.14s %s %s %s %s %s %s %6.0f  %s %s %6.0f %s %6.0f\n", name.c_str(),
              Padded(Measured(jerk.clip), 8, 2).c_str(), Padded(Worst(jerk), 8, 2).c_str(),
              Padded(Measured(jerk.largest), 8, 2).c_str(),
              Padded(jerk.largest.count > 0 ? jerk.worst_largest : kNotMeasured, 8, 2).c_str(),
              Padded(Measured(jerk.first_quarter_second), 12, 2).c_str(),
              Padded(Measured(jerk.after_first_second), 10, 2).c_str(), jerk.clip.count,
              Padded(Measured(acts.reach), 8, 2).c_str(),
              Padded(Measured(acts.direction_deg), 8, 1).c_str(), acts.reach.count,
              Padded(Measured(acts.kick_height), 8, 2).c_str(), acts.kick_height.count);
}

}  // namespace

Details MeasureDetails(const Data& data, std::string title, std::span<const Transferred> clips) {
  Details details{.title = std::move(title),
                  .gaits = {},
                  .gait_input = {},
                  .styles = {},
                  .jerk = {},
                  .acts = {}};
  const std::vector<std::string>& contents = data.manifest.contents;
  for (const char* name : kGaits) {
    if (std::find(contents.begin(), contents.end(), name) != contents.end()) {
      details.gaits.emplace_back(name);
    }
  }
  const auto gait_of = [&](int content) {
    return static_cast<std::size_t>(std::find(details.gaits.begin(), details.gaits.end(),
                                              contents[static_cast<std::size_t>(content)]) -
                                    details.gaits.begin());
  };
  const std::size_t gaits = details.gaits.size();
  details.gait_input.resize(gaits);
  details.styles.resize(data.manifest.styles.size());
  for (StyleDetails& style : details.styles) {
    style.gait_output.resize(gaits);
    style.gait_real.resize(gaits);
  }
  for (std::size_t i = 0; i < data.inputs.size(); ++i) {
    const std::size_t gait = gait_of(data.contents[i]);
    if (gait < gaits) details.gait_input[gait].Add(MeasureGait(data.inputs[i], kStreamRate_hz));
  }
  for (const auto* split : {&data.train, &data.judge, &data.validation}) {
    for (const train::TrainingClip& clip : *split) {
      const std::size_t gait = gait_of(clip.content);
      if (clip.style == 0 || gait >= gaits) continue;
      details.styles[static_cast<std::size_t>(clip.style)].gait_real[gait].Add(
          MeasureGait(clip.poses, kJudgeRate_hz));
    }
  }
  for (const Transferred& clip : clips) {
    StyleDetails& style = details.styles[static_cast<std::size_t>(clip.style)];
    const std::size_t gait = gait_of(clip.content);
    if (gait < gaits) style.gait_output[gait].Add(MeasureGait(clip.output, kStreamRate_hz));
    style.jerk.Add(MeasureJerkRatios(clip.input, clip.output, kStreamRate_hz, clip.clip));
    style.acts.Add(MeasureActs(clip.input, clip.output, kStreamRate_hz));
  }
  for (const StyleDetails& style : details.styles) {
    details.jerk.Add(style.jerk);
    details.acts.Add(style.acts);
  }
  return details;
}

void Print(const clip::Manifest& manifest, const Details& details) {
  PrintGaits(manifest, details);
  std::printf(
      "\n%s, jerk of each clip over its input's; acts kept\n"
      "%-14s %8s %8s %8s %8s %12s %10s %6s  %8s %8s %6s %8s %6s\n",
      details.title.c_str(), "style", "mean", "worst", "largest", "worst", "first 0.25 s",
      "after 1 s", "clips", "reach", "off, deg", "hands", "kick", "kicks");
  for (std::size_t style = 1; style < details.styles.size(); ++style) {
    PrintRow(manifest.styles[style].name, details.styles[style].jerk, details.styles[style].acts);
  }
  PrintRow("all", details.jerk, details.acts);
}

nlohmann::json ToJson(const ActsKept& acts) {
  return {{"reach", Value(Measured(acts.reach))},
          {"direction_deg", Value(Measured(acts.direction_deg))},
          {"hands", acts.reach.count},
          {"kick_height", Value(Measured(acts.kick_height))},
          {"kicks", acts.kick_height.count}};
}

nlohmann::json ToJson(const clip::Manifest& manifest, const Details& details) {
  nlohmann::json json = {
      {"title", details.title}, {"jerk", ToJson(details.jerk)}, {"acts", ToJson(details.acts)}};
  for (std::size_t gait = 0; gait < details.gaits.size(); ++gait) {
    nlohmann::json& rows = json["gait"][details.gaits[gait]];
    rows["input"] = ToJson(details.gait_input[gait]);
    for (std::size_t style = 1; style < details.styles.size(); ++style) {
      rows["styles"][manifest.styles[style].name] = {
          {"real", ToJson(details.styles[style].gait_real[gait])},
          {"output", ToJson(details.styles[style].gait_output[gait])}};
    }
  }
  for (std::size_t style = 1; style < details.styles.size(); ++style) {
    json["styles"][manifest.styles[style].name] = {{"jerk", ToJson(details.styles[style].jerk)},
                                                   {"acts", ToJson(details.styles[style].acts)}};
  }
  return json;
}

}  // namespace styled::judge
