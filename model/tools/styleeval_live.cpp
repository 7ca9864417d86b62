#include <cstdio>

#include "model/tools/styleeval.h"
#include "model/train/judge/conditions.h"
#include "model/train/judge/feet.h"
#include "model/train/judge/foreign.h"
#include "model/train/judge/long.h"
#include "model/train/judge/response.h"

namespace styled {
namespace {

constexpr double kSwitchEvery_s = 4.0;
constexpr double kSwitching_s = 60;  // of each content

// Network styles, and the corresponding ones of the manifest.
struct Present {
  std::vector<int> of_manifest, of_network;
};

Present PresentStyles(const judge::Styler& styler) {
  Present present;
  for (std::size_t style = 1; style < styler.style_of.size(); ++style) {
    if (styler.style_of[style] == judge::kAbsent) continue;
    present.of_manifest.push_back(static_cast<int>(style));
    present.of_network.push_back(styler.style_of[style]);
  }
  return present;
}

void JudgeReconstruction(EvalSession& session, const judge::Styler& styler) {
  std::vector<judge::Poses> neutral;
  for (const judge::Poses& input : session.data.inputs) neutral.push_back(judge::Thin(input));
  const judge::Reconstruction reconstruction =
      judge::MeasureReconstruction(*styler.network, neutral);
  std::printf("\nreconstruction of neutral clips: %.2f degrees, %.2f cm (means over joints)\n",
              reconstruction.angle_deg.value(), reconstruction.position_cm.value());
  session.json["reconstruction"] = {{"angle_deg", reconstruction.angle_deg.value()},
                                    {"position_cm", reconstruction.position_cm.value()}};
}

void JudgeFeetStage(EvalSession& session, const judge::Styler& styler) {
  if (!session.arguments.stylist.feet) return;
  const judge::FeetStage stage =
      judge::MeasureFeetStage(styler.network, styler.binding, session.arguments.stylist,
                              PresentStyles(styler).of_network, session.data.inputs);
  judge::Print(stage);
  session.json["feet"] = judge::ToJson(stage);
}

// `runs`: a long run of each content.
void JudgeSwitches(EvalSession& session, const judge::Styler& styler,
                   std::span<const judge::LongRun> runs) {
  const Present present = PresentStyles(styler);
  if (present.of_manifest.size() < 2) return;
  std::vector<judge::ResponseInput> inputs;
  for (const judge::LongRun& run : runs) {
    const std::size_t frames = std::min<std::size_t>(
        run.chain.poses.size(), static_cast<std::size_t>(kSwitching_s * judge::kStreamRate_hz));
    judge::ResponseInput input{run.contents.front(), std::span(run.chain.poses).first(frames), {}};
    for (const int style : present.of_manifest) {
      input.steady.push_back(std::span(run.styled[static_cast<std::size_t>(style)]).first(frames));
    }
    inputs.push_back(std::move(input));
  }
  const judge::Response response = judge::MeasureResponse(
      session.judges, session.data.validation, present.of_manifest, present.of_network,
      styler.network, styler.binding, session.arguments.stylist, session.arguments.transition_s,
      kSwitchEvery_s, inputs);
  judge::Print(response);
  session.json["response"] = judge::ToJson(response);
}

// After a long time of continuous state, and at switches.
void JudgeLong(EvalSession& session, const judge::Styler& styler) {
  const double seconds = session.arguments.long_s;
  if (seconds <= 0) return;
  const std::vector<judge::LongRun> runs =
      judge::RunLong(session.data, styler, session.arguments.stylist, seconds);
  char title[96];
  std::snprintf(title, sizeof title, "styled, after %.0f s of continuous state", seconds);
  const std::span<const judge::LongRun> apart = std::span(runs).first(runs.size() - 1);
  Report(session, "long", title, judge::CutLate(apart, seconds));
  std::snprintf(title, sizeof title, "styled, contents mixed, after %.0f s", seconds);
  Report(session, "mixed", title, judge::CutLate(std::span(runs).last(1), seconds));
  JudgeSwitches(session, styler, apart);
}

}  // namespace

Status JudgeConditions(EvalSession& session, const judge::Styler& styler) {
  const EvalArguments& arguments = session.arguments;
  const judge::Data& data = session.data;
  const judge::Evaluator& evaluator = session.evaluator;
  const stylist::Options& options = arguments.stylist;
  nlohmann::json& json = session.json;
  if (arguments.absolute) {
    Report(session, "absolute", "absolute (the paper's output)",
           judge::Style(data, styler, options, true));
  }
  if (arguments.robust) json["spoilt"] = judge::JudgePerturbed(data, styler, evaluator, options);
  if (arguments.rates) json["rates"] = judge::JudgeRates(data, styler, evaluator, options);
  if (arguments.styled_inputs) {
    json["styled_inputs"] = judge::JudgeStyledInputs(data, styler, evaluator, options);
  }
  if (arguments.foreign) {
    json["foreign"] = judge::JudgeForeign(data, styler, options, session.scenes);
  }
  if (!arguments.clips.empty()) {
    auto others = judge::JudgeOtherClips(arguments.clips, styler, options, session.scenes);
    if (!others.ok()) return others.status();
    json["other_clips"] = std::move(others.value());
  }
  JudgeReconstruction(session, styler);
  JudgeFeetStage(session, styler);
  JudgeLong(session, styler);
  return Status::Ok();
}

}  // namespace styled
