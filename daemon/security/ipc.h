#pragma once

#include <string>

#include "daemon/config/config.h"
#include "daemon/runtime/zmq_socket.h"
#include "model/base/status.h"

namespace styled::security {

// Resolves `config` to user ids of this machine. A list of users always includes root and the
// daemon's own user, who could get access anyway. The error names `section` and the unknown user.
// Start-up only.
Result<runtime::IpcAccess> ResolveIpc(const config::Ipc& config, const std::string& section);

}  // namespace styled::security
