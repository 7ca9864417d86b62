#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/tools/stylize/report.h"

namespace styled::stylize {

// A motion as the humanoid, not empty.
struct SheetMotion {
  std::vector<body::Pose> poses;
  double rate_hz = 30;
};

// A page of all outputs of a run, one self-contained HTML file: a row for each clip, a column for
// each style, in each cell the styled figure in front of the input's, moving, and its numbers. Of
// each motion its first kShown_s are kept, kRate_hz times a second, in millimetres: 2.5 kB a
// second. Pinned by tests/e2e/stylize_sheet_test.cpp. One thread; allocates.
class Sheet {
 public:
  static constexpr double kShown_s = 10, kRate_hz = 15;

  // Adds an output, or its error, to the row of its input; outputs of one input come one after the
  // other. `input` and `output` are read unless the outcome has an error.
  void Add(const Outcome& outcome, const SheetMotion& input, const SheetMotion& output);
  std::size_t outputs() const { return outputs_; }  // without errors
  Status Write(const std::string& file) const;

 private:
  std::size_t outputs_ = 0;
  std::string last_;
  nlohmann::json rows_ = nlohmann::json::array();
};

}  // namespace styled::stylize
