#pragma once

#include <string>
#include <vector>

#include "clients/doctor/facts.h"

namespace styled::doctor {

// The stages that a frame passes, in order. A finding names the stage at which frames stop.
enum class Step { kDaemon, kPort, kArrival, kFormat, kVersion, kSkeleton, kFrames, kSubscribers };
const char* Name(Step step);

enum class Severity {
  kProblem,  // because of it, no frames come out
  kWarning,  // because of it, some frames are lost, or will be
  kNote
};
const char* Name(Severity severity);

struct Finding {
  Severity severity = Severity::kProblem;
  Step step = Step::kDaemon;
  std::string code;    // machine-readable: "wrong_format", ...
  std::string source;  // name of the source; "" if it concerns no single source
  std::string what;    // one sentence: what is wrong, and where
  std::string why;     // the user's remedy
  // What the user should do. Lines after the first are to be copied as they are: TOML, which begins
  // with a table, or one command each.
  std::string change;
};

// Derives findings from facts, in the order in which the user should fix them. Without a finding of
// kProblem all is well. Pure. Each code is pinned by tests/unit/doctor/diagnose_test.cpp, the most
// common ones with real programs by tests/e2e/doctor.
std::vector<Finding> Diagnose(const Facts& facts);

std::string PlaceOf(const Endpoint& endpoint, bool stream);  // "0.0.0.0:9763/udp"
std::string Seconds(double seconds);                         // "3 s"

}  // namespace styled::doctor
