#pragma once

#include <string>

#include "model/base/status.h"

// Paths of ipc:// addresses. libzmq removes whatever is at the path that it binds: an ordinary file
// and a socket in use as readily as a socket that a dead daemon left. Call these checks first.
// Start-up only.
namespace styled::ipc {

// Refuses a path that holds anything but a socket. Errors name the kind of file.
Status CheckKind(const std::string& path);

// CheckKind, and also refuses a socket at which a program listens. The check connects to that
// program and closes the connection at once; nothing else is touched.
Status CheckFree(const std::string& path);

}  // namespace styled::ipc
