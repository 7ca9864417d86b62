#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "clients/doctor/diagnose.h"
#include "clients/doctor/doctor.h"

namespace styled::stylectl {

// Runs `stylectl doctor`: examines, evaluates, and reports on `out`. Returns kExitOk if no problem
// was found, kExitRefused if one was found, kExitUsage (with the reason on `err`) for invalid
// options.
int RunDoctor(const doctor::Options& options, bool json, std::ostream& out, std::ostream& err);

// Formats the findings as text for people and as JSON for programs. Pure.
std::string DoctorText(const doctor::Facts& facts, const std::vector<doctor::Finding>& findings);
nlohmann::json DoctorJson(const doctor::Facts& facts, const std::vector<doctor::Finding>& findings);

}  // namespace styled::stylectl
