#pragma once

#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "model/train/judge/metrics.h"

namespace styled::judge {

// A figure that was not measured is neither 0 nor 1: it is NaN here, "-" in tables, null in JSON.
inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

inline double Measured(const Mean& mean) { return mean.count > 0 ? mean.value() : kNotMeasured; }
inline double Measured(const Share& share) {
  return share.windows > 0 ? share.value : kNotMeasured;
}

// A table's cell, right-aligned.
inline std::string Padded(double value, int width, int decimals) {
  char text[64];
  if (std::isfinite(value)) {
    std::snprintf(text, sizeof text, "%*.*f", width, decimals, value);
  } else {
    std::snprintf(text, sizeof text, "%*s", width, "-");
  }
  return text;
}

// The same, followed by the spread over judges where there are several.
inline std::string Padded(double value, double spread, int width, int decimals) {
  char text[64] = "";
  if (std::isfinite(spread)) std::snprintf(text, sizeof text, " ±%.*f", decimals, spread);
  return Padded(value, width, decimals) + text;
}
inline std::string Padded(const Mean& mean, int width, int decimals) {
  return Padded(Measured(mean), mean.spread(), width, decimals);
}
inline std::string Padded(const Share& share, int width, int decimals) {
  return Padded(Measured(share), share.spread(), width, decimals);
}

inline nlohmann::json Value(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace styled::judge
