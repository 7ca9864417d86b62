#pragma once

#include <string>
#include <vector>

#include "clients/vmc/target.h"

namespace styled::stylevmc {

// The targets of --find, "[PERFORMER=]NAME" each: applications that announce by OSCQuery that they
// receive OSC, by their name or its beginning. `vrchat`: they must take VRChat's trackers, else
// VMC; those that do not tell are believed. Blocks for some seconds. Errors name the option, the
// names that were found, or the cure. Pinned by tests/witness/oscquery.
Result<std::vector<TargetSpec>> FindTargets(const std::vector<std::string>& texts, bool vrchat);

}  // namespace styled::stylevmc
