#pragma once

#include <string>

#include "clients/stylectl/session.h"

namespace styled::stylectl {

// Sends a request that makes a style, and reports what was made. `performer`: who then shows it;
// "": no performer. Returns the exit code.
int MakeStyle(Session& session, const std::string& performer, const v1::Like& request);

}  // namespace styled::stylectl
