#include "model/train/judge/judge_response.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "model/train/judge/judge_metrics.h"

namespace styled::judge {
namespace {

// Seconds from `switch_s` until the first trailing window judged `style`; -1 if none before
// `until_s`. Window i of `verdicts` (stride 1) ends at frame i + window of the thinned stream.
double SeenAfter_s(const Verdicts& verdicts, int window, int style, double switch_s,
                   double until_s) {
  for (std::size_t i = 0; i < verdicts.style.size(); ++i) {
    const double end_s = (verdicts.starts[i] + window) / kJudgeRate_hz;
    if (end_s <= switch_s || end_s > until_s) continue;
    if (verdicts.style[i] == style) return end_s - switch_s;
  }
  return -1;
}

Verdicts JudgeAll(const Judges& judges, std::span<const body::Pose> stream, int content) {
  return judges.Judge(MakeSequence(Thin(stream), 0, content, false, judges.parameters()), 1);
}

}  // namespace

Response MeasureResponse(const Judges& judges, std::span<const int> styles,
                         std::span<const int> network_styles,
                         const std::shared_ptr<const erd::Network>& network,
                         const std::shared_ptr<const rig::Binding>& binding,
                         const stylist::Options& options, float transition_s, double every_s,
                         std::span<const ResponseInput> inputs) {
  Response response;
  std::vector<double> seen;
  std::vector<double> cut;
  std::vector<double> accelerations;
  std::vector<double> steady;
  double missed = 0;
  std::mt19937 random(7);
  const auto every = static_cast<std::size_t>(std::lround(every_s * kStreamRate_hz));
  const int window = judges.settings().window;
  for (const ResponseInput& of : inputs) {
    // The plan: style index (into `styles`) in force from each multiple of `every`.
    std::vector<int> plan;
    std::vector<Switch> switches;
    for (std::size_t frame = 0; frame + every <= of.input.size(); frame += every) {
      int next = static_cast<int>(random() % styles.size());
      if (!plan.empty() && next == plan.back()) next = (next + 1) % static_cast<int>(styles.size());
      plan.push_back(next);
      stylist::Settings settings = OneStyle(network_styles[next], false);
      settings.transition_s = frame == 0 ? 0 : transition_s;
      switches.push_back({frame, settings});
    }
    const auto input = of.input.first(plan.size() * every);
    const Poses live = StyleStream(network, binding, options, switches, input);
    Poses cut_stream;
    for (std::size_t i = 0; i < input.size(); ++i) {
      cut_stream.push_back(of.steady[plan[i / every]][i]);
    }
    const Verdicts live_verdicts = JudgeAll(judges, live, of.content);
    const Verdicts cut_verdicts = JudgeAll(judges, cut_stream, of.content);
    const double usual = Quantile(LargestAccelerations(input, kStreamRate_hz), 0.999);
    const std::vector<double> live_accelerations = LargestAccelerations(live, kStreamRate_hz);
    std::vector<double> calm;
    for (std::size_t i = 1; i < plan.size(); ++i) {
      const double at_s = every_s * static_cast<double>(i);
      const double live_s =
          SeenAfter_s(live_verdicts, window, styles[plan[i]], at_s, at_s + every_s);
      const double cut_s = SeenAfter_s(cut_verdicts, window, styles[plan[i]], at_s, at_s + every_s);
      if (live_s >= 0) seen.push_back(live_s);
      if (live_s < 0) missed += 1;
      if (cut_s >= 0) cut.push_back(cut_s);
      const auto second = static_cast<std::size_t>(kStreamRate_hz);
      const auto begin = live_accelerations.begin() + static_cast<long>(i * every - 2);
      const auto after = begin + static_cast<long>(std::min(second, every - 4));
      accelerations.push_back(*std::max_element(begin, after) / usual);
      calm.insert(calm.end(), after, begin + static_cast<long>(every - 4));
      ++response.switches;
    }
    steady.push_back(Quantile(calm, 0.999) / usual);
  }
  response.median_s = Quantile(seen, 0.5);
  response.p90_s = Quantile(seen, 0.9);
  response.cut_median_s = Quantile(cut, 0.5);
  response.cut_p90_s = Quantile(cut, 0.9);
  response.never = missed / std::max(1, response.switches);
  response.acceleration_median = Quantile(accelerations, 0.5);
  response.acceleration_max = Quantile(accelerations, 1.0);
  response.steady = Quantile(steady, 0.5);
  return response;
}

}  // namespace styled::judge
