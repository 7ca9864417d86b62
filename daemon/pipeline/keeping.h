#pragma once

#include <string>
#include <vector>

#include "daemon/pipeline/profile.h"
#include "model/base/status.h"

namespace styled::pipeline {

// The file in [state] dir where settings survive a restart of the daemon: TOML, one table per
// performer id, replaced whole and atomically. Supervisor thread; blocks on the disk.
Status WriteProfiles(const std::string& file, const std::vector<Profile>& profiles);
// Empty where there is no such file. Errors name file, line and what is wrong.
Result<std::vector<Profile>> ReadProfiles(const std::string& file);
// The same of such a file's text; `name` is what complaints call it.
Result<std::vector<Profile>> ParseProfiles(const std::string& text, const std::string& name);

}  // namespace styled::pipeline
