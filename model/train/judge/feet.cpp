#include "model/train/judge/feet.h"

#include <algorithm>
#include <cstdio>

namespace styled::judge {

FeetStage MeasureFeetStage(const std::shared_ptr<const net::Stylizer>& network,
                           const std::shared_ptr<const rig::Binding>& binding,
                           stylist::Options options, std::span<const int> styles,
                           std::span<const Poses> inputs) {
  FeetStage stage;
  Mean jerk_in;
  Mean jerk_with;
  Mean jerk_without;
  for (const Poses& input : inputs) {
    const double usual = Quantile(LargestAccelerations(input, kStreamRate_hz), 0.999);
    for (const int style : styles) {
      const Switch start{0, OneStyle(style, false)};
      const auto run = [&](bool feet, FeetFigures& figures, std::vector<double>& accelerations,
                           Mean& jerk) {
        options.feet = feet;
        const Poses out = StyleStream(network, binding, options, {&start, 1}, input);
        figures.Add(MeasureFeet(input, out, kStreamRate_hz));
        jerk.Add(MeanJerk(out, kStreamRate_hz));
        const double largest = Quantile(LargestAccelerations(out, kStreamRate_hz), 1);
        accelerations.push_back(usual > 0 ? largest / usual : 0);
      };
      run(true, stage.with, stage.acceleration_with, jerk_with);
      run(false, stage.without, stage.acceleration_without, jerk_without);
      jerk_in.Add(MeanJerk(input, kStreamRate_hz));
      const double with = stage.acceleration_with.back();
      stage.to_blame += with > 1.5 && with > 1.1 * stage.acceleration_without.back();
    }
  }
  stage.to_blame /= std::max<double>(1, static_cast<double>(stage.acceleration_with.size()));
  const double usual_jerk = std::max(1e-9, jerk_in.value());
  stage.jerk_with = jerk_with.value() / usual_jerk;
  stage.jerk_without = jerk_without.value() / usual_jerk;
  return stage;
}

void Print(const FeetStage& stage) {
  std::printf("\nfeet stage, all clips in all styles; input skates %.2f cm/s\n",
              stage.with.skate_in_cm_s.value());
  const auto row = [](const char* name, const FeetFigures& feet, double jerk,
                      const std::vector<double>& accelerations) {
    std::printf(
        "  %-8s skate %5.2f cm/s; floor %.3f cm (mean), %.1f cm (deepest); jerk %.3f; largest "
        "acceleration over the input's p99.9: %.2f (median), %.2f (p90), %.2f (max)\n",
        name, feet.skate_out_cm_s.value(), feet.penetration_cm.value(), feet.deepest_cm, jerk,
        Quantile(accelerations, 0.5), Quantile(accelerations, 0.9), Quantile(accelerations, 1));
  };
  row("without", stage.without, stage.jerk_without, stage.acceleration_without);
  row("with", stage.with, stage.jerk_with, stage.acceleration_with);
  std::printf("  the stage is to blame for more than 1.5 in %.1f %%\n", 100 * stage.to_blame);
}

nlohmann::json ToJson(const FeetStage& stage) {
  const auto of = [](const FeetFigures& feet, double jerk,
                     const std::vector<double>& accelerations) -> nlohmann::json {
    return {{"skate_cm_s", feet.skate_out_cm_s.value()},
            {"penetration_cm", feet.penetration_cm.value()},
            {"deepest_cm", feet.deepest_cm},
            {"jerk", jerk},
            {"acceleration_median", Quantile(accelerations, 0.5)},
            {"acceleration_p90", Quantile(accelerations, 0.9)},
            {"acceleration_max", Quantile(accelerations, 1)}};
  };
  return {{"skate_in_cm_s", stage.with.skate_in_cm_s.value()},
          {"with", of(stage.with, stage.jerk_with, stage.acceleration_with)},
          {"without", of(stage.without, stage.jerk_without, stage.acceleration_without)},
          {"to_blame", stage.to_blame}};
}

}  // namespace styled::judge
