#pragma once

#include <string>

#include "model/base/status.h"

// Paths of ipc:// addresses. libzmq removes whatever is at the path it binds, an ordinary file or a
// socket in use as readily as one that a dead daemon left; these are asked before. Start-up only.
namespace styled::ipc {

// Refuses a path where something is that is no socket. Errors say what is there.
Status CheckKind(const std::string& path);

// CheckKind, and refuses a socket at which a program listens. It is left alone, but for a
// connection that is closed at once.
Status CheckFree(const std::string& path);

}  // namespace styled::ipc
