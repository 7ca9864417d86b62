#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/looks/profile.h"
#include "model/base/status.h"

namespace styled::pipeline {

// The largest accepted file. 4096 performers, each with the calibration of a rig of 64 joints, take
// half of it.
inline constexpr std::size_t kMaxStateBytes = std::size_t{64} << 20;

// The file in [state] dir that keeps settings over a restart of the daemon: TOML, one table per
// performer id, replaced as a whole and atomically. Supervisor thread; blocks on the disk.
Status WriteProfiles(const std::string& file, const std::vector<Profile>& profiles);
// The text of such a file.
std::string FormatProfiles(const std::vector<Profile>& profiles);
// Reads the profiles; empty if there is no such file. Errors name file, line and problem. The call
// returns even if the path is a pipe or a device. Values that no request could have set become the
// defaults.
Result<std::vector<Profile>> ReadProfiles(const std::string& file);
// The same for the text of such a file. Errors call it `name`.
Result<std::vector<Profile>> ParseProfiles(const std::string& text, const std::string& name);

}  // namespace styled::pipeline
