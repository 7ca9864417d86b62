#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/pipeline/profile.h"
#include "model/base/status.h"

namespace styled::pipeline {

// A file beyond this is none of ours: 4096 performers, each with the calibration of a rig of 64
// joints, take half of it.
inline constexpr std::size_t kMaxStateBytes = std::size_t{64} << 20;

// The file in [state] dir where settings survive a restart of the daemon: TOML, one table per
// performer id, replaced whole and atomically. Supervisor thread; blocks on the disk.
Status WriteProfiles(const std::string& file, const std::vector<Profile>& profiles);
// Empty where there is no such file. Errors name file, line and what is wrong. Whatever is in the
// file's place, the call ends; values that no request could have set become the defaults.
Result<std::vector<Profile>> ReadProfiles(const std::string& file);
// The same of such a file's text; `name` is what complaints call it.
Result<std::vector<Profile>> ParseProfiles(const std::string& text, const std::string& name);

}  // namespace styled::pipeline
