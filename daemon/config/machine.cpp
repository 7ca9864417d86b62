#include "daemon/config/machine.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace styled::config {
namespace {

// Whether `text` is the name of an interface, or an IPv4 address of one.
bool IsInterface(const std::string& text) {
  in_addr wanted{};
  if (inet_pton(AF_INET, text.c_str(), &wanted) != 1) return if_nametoindex(text.c_str()) != 0;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return true;  // unknown: no warning
  bool found = wanted.s_addr == INADDR_ANY;
  for (const ifaddrs* i = all; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, i->ifa_addr, sizeof address);
    found = found || address.sin_addr.s_addr == wanted.s_addr;
  }
  freeifaddrs(all);
  return found;
}

}  // namespace

std::vector<std::string> MissingInterfaces(const Config& config) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < config.sources.size(); ++i) {
    const std::string& interface = config.sources[i].interface;
    if (interface.empty() || IsInterface(interface)) continue;
    warnings.push_back("source." + std::to_string(i) + ".interface: \"" + interface +
                       "\" does not exist on this machine now; expected an interface's name or its "
                       "IPv4 address");
  }
  return warnings;
}

Status CheckRecordFolder(const std::string& file) {
  if (file.empty()) return Status::Ok();
  namespace fs = std::filesystem;
  std::error_code error;
  // The nearest existing folder. The recorder creates the missing folders at its start.
  fs::path folder = fs::absolute(file, error);
  if (!fs::is_directory(folder, error)) folder = folder.parent_path();
  while (!fs::exists(folder, error) && folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  const auto refuse = [&](const std::string& why) {
    return Status::Error("record.file: \"" + file + "\": " + folder.string() + ": " + why +
                         ", expected a folder that can be written to");
  };
  if (!fs::is_directory(folder, error)) return refuse("is not a folder");
  if (access(folder.c_str(), W_OK | X_OK) != 0) return refuse(std::strerror(errno));
  return Status::Ok();
}

std::optional<std::uint64_t> MemoryLimit(const std::string& cgroups, const std::string& root) {
  namespace fs = std::filesystem;
  constexpr std::string_view kUnified = "0::/";  // of version 2; others have no memory.max
  std::ifstream list(cgroups);
  std::string line;
  while (std::getline(list, line) && !line.starts_with(kUnified)) {
  }
  if (!line.starts_with(kUnified)) return std::nullopt;
  std::optional<std::uint64_t> least;
  fs::path group = fs::path(root) / line.substr(kUnified.size());
  while (true) {
    std::uint64_t bytes = 0;  // the file may also hold "max"
    if (std::ifstream(group / "memory.max") >> bytes)
      least = std::min(least.value_or(bytes), bytes);
    if (group == fs::path(root) || group == group.parent_path()) return least;
    group = group.parent_path();
  }
}

std::string MemoryWarning(int max_performers, std::optional<std::uint64_t> limit_bytes) {
  const auto wanted = static_cast<std::uint64_t>(max_performers);
  const std::uint64_t needed = kDaemonBytes + wanted * kPerformerBytes;
  if (!limit_bytes || needed <= *limit_bytes) return "";
  const auto mib = [](std::uint64_t bytes) { return std::to_string(bytes >> 20U) + "M"; };
  const std::uint64_t fit =
      *limit_bytes > kDaemonBytes ? (*limit_bytes - kDaemonBytes) / kPerformerBytes : 0;
  return "performers.max_performers: found " + std::to_string(max_performers) +
         ", which need about " + mib(needed) + " of memory, but the limit is " + mib(*limit_bytes) +
         ", enough for " + std::to_string(fit) + "; expected MemoryMax=" + mib(needed) +
         " in the unit, or fewer performers";
}

}  // namespace styled::config
