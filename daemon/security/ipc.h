#pragma once

#include <string>

#include "daemon/config/config.h"
#include "daemon/runtime/zmq_socket.h"
#include "model/base/status.h"

namespace styled::security {

// What `config` means on this machine. Where it names users, root and our own are among them: they
// could get in anyway. The error names `section` and a user that there is not. Start-up only.
Result<runtime::IpcAccess> ResolveIpc(const config::Ipc& config, const std::string& section);

}  // namespace styled::security
