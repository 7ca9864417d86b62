#include "daemon/security/ipc.h"

#include <pwd.h>
#include <unistd.h>

#include <charconv>
#include <optional>
#include <vector>

namespace styled::security {
namespace {

std::optional<uid_t> FindUser(const std::string& name) {
  uid_t number = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data(), end, number);
  if (!name.empty() && error == std::errc() && stop == end) return number;
  passwd entry{};
  passwd* found = nullptr;
  std::vector<char> buffer(16384);
  getpwnam_r(name.c_str(), &entry, buffer.data(), buffer.size(), &found);
  return found == nullptr ? std::nullopt : std::optional(found->pw_uid);
}

}  // namespace

Result<runtime::IpcAccess> ResolveIpc(const config::Ipc& config, const std::string& section) {
  runtime::IpcAccess access;
  access.mode = static_cast<mode_t>(config.mode);
  if (config.users.empty()) return access;
  access.users = {0, geteuid()};
  for (const std::string& name : config.users) {
    const auto user = FindUser(name);
    if (!user) {
      return Status::Error(section + ".ipc_users: \"" + name + "\" is not a user of this machine");
    }
    access.users.push_back(*user);
  }
  return access;
}

}  // namespace styled::security
