#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "proto/styled/v1/control.pb.h"

namespace styled::stylectl {

// Replies as text for people (aligned columns, each line ends in a newline) and as JSON for
// programs (snake_case keys of the .proto; weights as {"style", "weight"}). Pure.
std::string ListText(const v1::ListReply& list);
std::string StylesText(const v1::ListReply& list);  // the source of each style
std::string StatusText(const v1::StatusReply& status, bool all_counters);
std::string AppliedText(const std::vector<v1::Applied>& applied, const std::string& what);

nlohmann::json ListJson(const v1::ListReply& list);
nlohmann::json StatusJson(const v1::StatusReply& status);
nlohmann::json AppliedJson(const std::vector<v1::Applied>& applied);

// Columns padded to their widest cell (UTF-8 counted by code point), two spaces between; a column
// whose cells after the first row are all numbers is aligned right.
std::string Table(const std::vector<std::vector<std::string>>& rows);

}  // namespace styled::stylectl
