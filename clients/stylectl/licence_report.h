#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/styled/v1/control.pb.h"

namespace styled::stylectl {

// The styles that may be used commercially and those that may not, the licence of each file of
// weights, and the names to credit, as text for people. Lines end in a newline. Pure.
std::string LicencesText(const v1::ListReply& list);
nlohmann::json LicencesJson(const v1::ListReply& list);

// "yes", "no", and "-" where the licence is not a known one; for JSON true, false, null.
std::string CommercialText(v1::CommercialUse use);
nlohmann::json CommercialJson(v1::CommercialUse use);

}  // namespace styled::stylectl
