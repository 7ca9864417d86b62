#include "model/train/judge/response.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "model/train/judge/metrics.h"
#include "model/train/judge/text.h"

namespace styled::judge {
namespace {

constexpr double kHard = 1.5;  // times the input's p99.9: a visibly hard acceleration

// Seconds from `switch_s` until the end of the first window judged as `style`; -1 if there is none
// before `until_s`. Window i of `verdicts` ends at frame i + window of the thinned stream.
double SeenAfter_s(std::span<const int> verdicts, int window, int style, double switch_s,
                   double until_s) {
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const double end_s = static_cast<double>(i + static_cast<std::size_t>(window)) / kJudgeRate_hz;
    if (end_s <= switch_s || end_s > until_s) continue;
    if (verdicts[i] == style) return end_s - switch_s;
  }
  return -1;
}

// Accumulates the data of one Seen.
class Watch {
 public:
  Watch(const Judges& judges, int window)
      : judges_(judges),
        window_(window),
        seen_(static_cast<std::size_t>(judges.settings().count)),
        cut_(seen_.size()) {}

  // Evaluates a stream: switch i of `plan` is at i * every_s and goes to plan[i], a style of the
  // judges.
  void Look(const Sequence& live, const Sequence& cut, std::span<const int> plan, double every_s) {
    const std::vector<std::vector<int>> of_live = judges_.JudgeStyle(live, window_);
    const std::vector<std::vector<int>> of_cut = judges_.JudgeStyle(cut, window_);
    for (std::size_t i = 1; i < plan.size(); ++i) {
      const double at_s = every_s * static_cast<double>(i);
      for (std::size_t judge = 0; judge < seen_.size(); ++judge) {
        const double live_s = SeenAfter_s(of_live[judge], window_, plan[i], at_s, at_s + every_s);
        const double cut_s = SeenAfter_s(of_cut[judge], window_, plan[i], at_s, at_s + every_s);
        if (live_s >= 0) seen_[judge].push_back(live_s);
        if (cut_s >= 0) cut_[judge].push_back(cut_s);
      }
      ++switches_;
    }
  }

  Seen Result(std::span<const train::TrainingClip> real) const {
    Seen seen{.window = window_};
    seen.right_on_real = RightOn(real);
    const auto of_judges = [](const auto& figure, const auto& times) {
      std::vector<double> values;
      for (const std::vector<double>& of_judge : times) values.push_back(figure(of_judge));
      Mean mean;
      mean.AddJudged(values, 1);
      return mean;
    };
    const auto quantile = [&](double share, const auto& times) {
      return of_judges([=](const auto& of_judge) { return Quantile(of_judge, share); }, times);
    };
    seen.median_s = quantile(0.5, seen_);
    seen.p90_s = quantile(0.9, seen_);
    seen.cut_median_s = quantile(0.5, cut_);
    seen.cut_p90_s = quantile(0.9, cut_);
    seen.never = of_judges(
        [this](const auto& of_judge) {
          return (switches_ - static_cast<double>(of_judge.size())) / std::max(1, switches_);
        },
        seen_);
    return seen;
  }

 private:
  Mean RightOn(std::span<const train::TrainingClip> real) const {
    Mean right;
    for (const train::TrainingClip& clip : real) {
      const Sequence sequence =
          MakeSequence(clip.poses, clip.style, clip.content, false, judges_.parameters());
      std::vector<double> hits;
      std::size_t windows = 0;
      for (const std::vector<int>& styles : judges_.JudgeStyle(sequence, window_)) {
        hits.push_back(static_cast<double>(std::count(styles.begin(), styles.end(), clip.style)));
        windows = styles.size();
      }
      right.AddJudged(hits, static_cast<double>(windows));
    }
    return right;
  }

  const Judges& judges_;
  int window_;
  int switches_ = 0;
  std::vector<std::vector<double>> seen_, cut_;  // by judge
};

}  // namespace

Response MeasureResponse(const Judges& judges, std::span<const train::TrainingClip> real,
                         std::span<const int> styles, std::span<const int> network_styles,
                         const std::shared_ptr<const net::Stylizer>& network,
                         const std::shared_ptr<const rig::Binding>& binding,
                         const stylist::Options& options, float transition_s, double every_s,
                         std::span<const ResponseInput> inputs) {
  Response response;
  Watch soon(judges, kShortWindow);
  Watch sure(judges, judges.settings().window);
  std::vector<double> accelerations;
  std::vector<double> steady;
  std::mt19937 random(7);
  const auto every = static_cast<std::size_t>(std::lround(every_s * kStreamRate_hz));
  for (const ResponseInput& of : inputs) {
    // The plan: the style (index into `styles`) in effect from each multiple of `every`.
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
    const auto sequence = [&judges, &of](const Poses& stream) {
      return MakeSequence(Thin(stream), 0, of.content, false, judges.parameters());
    };
    std::vector<int> judged_plan;
    for (const int style : plan) judged_plan.push_back(styles[style]);
    const Sequence of_live = sequence(live);
    const Sequence of_cut = sequence(cut_stream);
    for (Watch* const watch : {&soon, &sure}) watch->Look(of_live, of_cut, judged_plan, every_s);

    const double usual = Quantile(LargestAccelerations(input, kStreamRate_hz), 0.999);
    const std::vector<double> live_accelerations = LargestAccelerations(live, kStreamRate_hz);
    std::vector<std::vector<double>> in_force;
    for (const auto& steady_stream : of.steady) {
      in_force.push_back(LargestAccelerations(steady_stream, kStreamRate_hz));
    }
    std::vector<double> calm;
    const auto after = static_cast<long>(
        // the second after a switch
        std::min(static_cast<std::size_t>(kStreamRate_hz), every - 4));
    for (std::size_t i = 1; i < plan.size(); ++i) {
      const long at = static_cast<long>(i * every) - 2;
      const auto largest = [at, after](const std::vector<double>& of_stream) {
        return *std::max_element(of_stream.begin() + at, of_stream.begin() + at + after);
      };
      const double hardest = largest(live_accelerations);
      accelerations.push_back(hardest / usual);
      // A switch is excused if the two styles are hard by themselves at that time.
      const double excused =
          std::max({usual, largest(in_force[plan[i - 1]]), largest(in_force[plan[i]])});
      if (hardest > kHard * excused) response.to_blame += 1;
      calm.insert(calm.end(), live_accelerations.begin() + at + after,
                  live_accelerations.begin() + at + static_cast<long>(every - 4));
      ++response.switches;
    }
    steady.push_back(Quantile(calm, 0.999) / usual);
  }
  response.soon = soon.Result(real);
  response.sure = sure.Result(real);
  response.to_blame /= std::max(1, response.switches);
  response.acceleration_median = Quantile(accelerations, 0.5);
  response.acceleration_max = Quantile(accelerations, 1.0);
  response.steady = Quantile(steady, 0.5);
  return response;
}

void Print(const Response& response) {
  std::printf("\nswitching (%d switches)\n", response.switches);
  const auto text = [](const Mean& mean, int decimals) { return Padded(mean, 0, decimals); };
  for (const Seen& seen : {response.soon, response.sure}) {
    std::printf(
        "  windows of %.2f s (of real clips %s are judged rightly): the new style is seen after "
        "%s s (median), %s s (p90); an instant cut after %s and %s s; never %s of switches\n",
        seen.window / kJudgeRate_hz, text(seen.right_on_real, 3).c_str(),
        text(seen.median_s, 2).c_str(), text(seen.p90_s, 2).c_str(),
        text(seen.cut_median_s, 2).c_str(), text(seen.cut_p90_s, 2).c_str(),
        text(seen.never, 3).c_str());
  }
  std::printf(
      "  largest joint acceleration in the second after a switch, over the input's p99.9: %.2f "
      "(median), %.2f (max); away from switches, p99.9: %.2f; above 1.5 times that and what both "
      "styles do then: %.1f %%\n",
      response.acceleration_median, response.acceleration_max, response.steady,
      100 * response.to_blame);
}

namespace {

nlohmann::json ToJson(const Seen& seen) {
  nlohmann::json json = {{"window_s", seen.window / kJudgeRate_hz}};
  for (const auto& [key, mean] : {std::pair{"right_on_real", &seen.right_on_real},
                                  {"median_s", &seen.median_s},
                                  {"p90_s", &seen.p90_s},
                                  {"instant_cut_median_s", &seen.cut_median_s},
                                  {"instant_cut_p90_s", &seen.cut_p90_s},
                                  {"never", &seen.never}}) {
    json[key] = Value(Measured(*mean));
    json[std::string(key) + "_spread"] = Value(mean->spread());
  }
  return json;
}

}  // namespace

nlohmann::json ToJson(const Response& response) {
  return {{"switches", response.switches},
          {"soon", ToJson(response.soon)},
          {"sure", ToJson(response.sure)},
          {"acceleration_median", response.acceleration_median},
          {"acceleration_max", response.acceleration_max},
          {"acceleration_steady", response.steady},
          {"to_blame", response.to_blame}};
}

}  // namespace styled::judge
