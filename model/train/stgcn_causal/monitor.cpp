#include "model/train/stgcn_causal/monitor.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "model/train/stgcn/losses.h"

namespace styled::train::st_gcn_causal {
namespace {

using torch::Tensor;

constexpr double kCmPerM = 100;

}  // namespace

Monitor::Monitor(const st_gcn::Monitor& windows, const st_gcn::Kinematics& kinematics,
                 std::vector<int64_t> styles, const Teacher& teacher)
    : windows_(windows), kinematics_(kinematics), styles_(std::move(styles)), teacher_(teacher) {
  const torch::NoGradGuard no_grad;
  for (std::size_t style = 0; style < styles_.size(); ++style) {
    wanted_.push_back(kinematics_.Published(teacher_(windows_.source(), CodeOf(style))));
  }
  MonitorReport report;
  windows_.Judge("teacher", {wanted_.begin() + 1, wanted_.end()}, report);
  teacher_report_ = report.summary;
}

Tensor Monitor::CodeOf(std::size_t style) const {
  return teacher_.codes()[styles_[style]].expand({windows_.source().size(0), -1}).contiguous();
}

MonitorReport Monitor::Evaluate(const Student& student, const Graph& graph) const {
  const torch::NoGradGuard no_grad;
  const auto apart_cm = [this](const Tensor& a, const Tensor& b, int64_t from, int64_t to) {
    const auto positions = [&](const Tensor& window) {
      return kinematics_.Positions_m(window).slice(1, from, to);
    };
    return kCmPerM * st_gcn::MeanDistance(positions(a), positions(b)).item<double>();
  };
  const Tensor content = student.Encode(graph, windows_.source());
  const int64_t frames = windows_.source().size(1);
  double reconstruction_cm = 0, identity_cm = 0, styled_cm = 0, start_cm = 0;
  std::vector<Tensor> outputs;
  for (std::size_t style = 0; style < styles_.size(); ++style) {
    const Tensor made = kinematics_.Published(student.Decode(graph, content, CodeOf(style)));
    const double off_cm = apart_cm(made, wanted_[style], kFirst, frames);
    if (style == 0) {
      reconstruction_cm = off_cm;
      identity_cm = apart_cm(made, windows_.source(), kFirst, frames);
      continue;
    }
    const auto others = static_cast<double>(styles_.size() - 1);
    styled_cm += off_cm / others;
    start_cm += apart_cm(made, wanted_[style], 0, kFirst) / others;
    outputs.push_back(made);
  }
  MonitorReport report;
  std::ostringstream text;
  for (const auto& [name, value] : {std::pair{"reconstruction_cm", reconstruction_cm},
                                    {"identity_cm", identity_cm},
                                    {"styled_cm", styled_cm},
                                    {"start_cm", start_cm}}) {
    report.figures.emplace_back(name, value);
    text << name << ' ' << std::round(value * 100) / 100 << ' ';
  }
  report.summary = text.str();
  windows_.Judge("student", outputs, report);
  return report;
}

}  // namespace styled::train::st_gcn_causal
