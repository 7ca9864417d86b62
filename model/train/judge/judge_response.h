#pragma once

#include <span>
#include <vector>

#include "model/train/judge/judge_nets.h"
#include "model/train/judge/judge_stream.h"

namespace styled::judge {

// How soon the style judge sees a new style, looking at the last `window` frames at a time.
struct Seen {
  int window = 0;                  // frames at kJudgeRate_hz
  double right_on_real = 0;        // share of such windows of real clips that it judges rightly
  double median_s = 0, p90_s = 0;  // from the command until such a window is the new style
  double cut_median_s = 0, cut_p90_s = 0;  // the same for an instant cut: the judge's own delay
  double never = 0;                        // share of switches not seen before the next one
};

// A judge of a second sees nothing sooner than half a second: switches are also judged by windows
// as short as the paper's, 24 frames at 60 Hz.
inline constexpr int kShortWindow = 12;

// How soon a change of style is seen, and how hard it hits the joints.
struct Response {
  int switches = 0;
  Seen soon, sure;  // by kShortWindow and by the judges' own window
  // Largest joint acceleration within a second of the switch, over the input's p99.9: median and
  // maximum over switches; `steady` is the styled p99.9 away from switches, over the same.
  double acceleration_median = 0, acceleration_max = 0, steady = 0;
  // Share of switches that accelerate a joint by more than 1.5 times the input's p99.9 and 1.5
  // times what both styles, in force throughout, do in that second.
  double to_blame = 0;
};

// One long input at kStreamRate_hz, and what each style makes of it when it is in force throughout;
// steady[i] belongs to styles[i] (judges' index); network_styles[i] is the network's.
struct ResponseInput {
  int content = 0;
  std::span<const body::Pose> input;
  std::vector<std::span<const body::Pose>> steady;
};

// Switches between styles every `every_s` seconds in a seeded order, with `transition_s` each.
// `real`: clips that show how far the judge can be trusted.
Response MeasureResponse(const Judges& judges, std::span<const train::TrainingClip> real,
                         std::span<const int> styles, std::span<const int> network_styles,
                         const std::shared_ptr<const net::Stylizer>& network,
                         const std::shared_ptr<const rig::Binding>& binding,
                         const stylist::Options& options, float transition_s, double every_s,
                         std::span<const ResponseInput> inputs);

}  // namespace styled::judge
