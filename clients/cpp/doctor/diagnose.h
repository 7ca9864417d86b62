#pragma once

#include <string>
#include <vector>

#include "clients/cpp/doctor/facts.h"

namespace styled::doctor {

// The way of a frame, in its order. A finding says where it ends.
enum class Step { kDaemon, kPort, kArrival, kFormat, kVersion, kSkeleton, kFrames, kSubscribers };
const char* Name(Step step);

enum class Severity {
  kProblem,  // nothing comes out because of it
  kWarning,  // something is lost because of it, or will be
  kNote
};
const char* Name(Severity severity);

struct Finding {
  Severity severity = Severity::kProblem;
  Step step = Step::kDaemon;
  std::string code;    // for programs: "wrong_format", ...
  std::string source;  // "": of none alone
  std::string what;    // one sentence, what and where
  std::string why;     // what it was seen by; may be ""
  std::string change;  // what to do
};

// From facts to findings, in the order in which they are best put right. No problem among them: all
// is well. Pure. Each code is pinned by tests/unit/doctor/diagnose_test.cpp, the commonest on real
// programs by tests/e2e/doctor.
std::vector<Finding> Diagnose(const Facts& facts);

std::string PlaceOf(const Endpoint& endpoint, bool stream);  // "0.0.0.0:9763/udp"
std::string Seconds(double seconds);                         // "3 s"

}  // namespace styled::doctor
