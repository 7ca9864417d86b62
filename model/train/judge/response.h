#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "model/train/judge/metrics.h"
#include "model/train/judge/nets.h"
#include "model/train/judge/stream.h"

namespace styled::judge {

// The time until a style judge recognizes a new style from the last `window` frames; each figure
// is a mean over judges, of one value each.
struct Seen {
  int window = 0;      // frames at kJudgeRate_hz
  Mean right_on_real;  // share of such windows of real clips that it judges correctly
  // from the command until such a window is judged as the new style
  Mean median_s, p90_s;
  Mean cut_median_s, cut_p90_s;  // the same for an instant cut: the judge's own delay
  Mean never;                    // share of switches that are not recognized before the next one
};

// A judge with windows of one second cannot recognize anything sooner than half a second. So
// switches are also judged with windows as short as the paper's, 24 frames at 60 Hz.
inline constexpr int kShortWindow = 12;

// The time until a change of style is recognized, and the joint accelerations that it causes.
struct Response {
  int switches = 0;
  Seen soon, sure;  // by kShortWindow and by the judges' own window
  // The largest joint acceleration within a second after a switch, over the input's p99.9: median
  // and maximum over switches. `steady`: the same ratio for the styled p99.9 away from switches.
  double acceleration_median = 0, acceleration_max = 0, steady = 0;
  // The share of switches that accelerate a joint by more than 1.5 times the input's p99.9 and more
  // than 1.5 times what either style, in effect all the time, does in that second.
  double to_blame = 0;
};

// One long input at kStreamRate_hz, and its output in each style when that is in effect all the
// time. steady[i] belongs to styles[i] (the judges' index); network_styles[i] is the network's.
struct ResponseInput {
  int content = 0;
  std::span<const body::Pose> input;
  std::vector<std::span<const body::Pose>> steady;
};

// Switches between styles every `every_s` seconds in a seeded order, each with a fade of
// `transition_s`. `real`: clips that measure how reliable the judge is.
Response MeasureResponse(const Judges& judges, std::span<const train::TrainingClip> real,
                         std::span<const int> styles, std::span<const int> network_styles,
                         const std::shared_ptr<const net::Stylizer>& network,
                         const std::shared_ptr<const rig::Binding>& binding,
                         const stylist::Options& options, float transition_s, double every_s,
                         std::span<const ResponseInput> inputs);

void Print(const Response& response);
nlohmann::json ToJson(const Response& response);

}  // namespace styled::judge
