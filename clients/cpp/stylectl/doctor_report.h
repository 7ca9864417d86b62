#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "clients/cpp/doctor/diagnose.h"
#include "clients/cpp/doctor/doctor.h"

namespace styled::stylectl {

// `stylectl doctor`: examines, judges, reports on `out`. kExitOk where all is well, kExitRefused
// where a problem was found, kExitUsage (and the reason on `err`) where the options are wrong.
int RunDoctor(const doctor::Options& options, bool json, std::ostream& out, std::ostream& err);

// What was found, for people and for programs. Pure.
std::string DoctorText(const doctor::Facts& facts, const std::vector<doctor::Finding>& findings);
nlohmann::json DoctorJson(const doctor::Facts& facts, const std::vector<doctor::Finding>& findings);

}  // namespace styled::stylectl
