#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "model/train/judge/metrics.h"
#include "model/train/judge/stream.h"

namespace styled::judge {

// The effect of the feet stage: every clip in every style, once with and once without it.
struct FeetStage {
  FeetFigures with, without;
  // Per clip and style, the largest acceleration of any joint over the input's 99.9 % quantile.
  std::vector<double> acceleration_with, acceleration_without;
  // The share of these for which the stage is to blame: more than 1.5 with it, and more than 10 %
  // above the value without it.
  double to_blame = 0;
  double jerk_with = 0, jerk_without = 0;  // over the input's
};

// `inputs` are at kStreamRate_hz; `styles` are the network's. Allocates; needs no libtorch.
FeetStage MeasureFeetStage(const std::shared_ptr<const net::Stylizer>& network,
                           const std::shared_ptr<const rig::Binding>& binding,
                           stylist::Options options, std::span<const int> styles,
                           std::span<const Poses> inputs);

void Print(const FeetStage& stage);
nlohmann::json ToJson(const FeetStage& stage);

}  // namespace styled::judge
