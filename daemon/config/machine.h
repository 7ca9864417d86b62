#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace styled::config {

// Checks that depend on the machine, for --check-config. Warnings concern resources that may appear
// later (a missing network interface), the error concerns failures at start-up (a recording folder
// that cannot be created). Reads the machine's interfaces and folders, changes nothing. Pinned by
// tests/unit/daemon/config/config_test.cpp.
std::vector<std::string> MissingInterfaces(const Config& config);
Status CheckRecordFolder(const std::string& file);

// The memory of the daemon and of each performer at most, in bytes. Measured with the shipped
// weights: 80 MB and 1.8 MB, of which the network's state has 1.6. Pinned, as the functions below,
// by tests/unit/daemon/perform/performer/performer_memory_test.cpp.
inline constexpr std::uint64_t kDaemonBytes = std::uint64_t{160} << 20;
inline constexpr std::uint64_t kPerformerBytes = std::uint64_t{2} << 20;

// The smallest memory limit of the process's control groups (systemd's MemoryMax=), in bytes;
// nullopt if there is none, or if the groups cannot be read. `cgroups`: the file that lists them;
// `root`: the folder at which they are mounted.
std::optional<std::uint64_t> MemoryLimit(const std::string& cgroups = "/proc/self/cgroup",
                                         const std::string& root = "/sys/fs/cgroup");
// A warning for the log if this many performers do not fit into the limit; "" if they do.
std::string MemoryWarning(int max_performers, std::optional<std::uint64_t> limit_bytes);

}  // namespace styled::config
