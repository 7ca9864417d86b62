#pragma once

#include <string>
#include <utility>

#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// The error of a request that is not executed, with the code of its reply.
inline Status Refused(v1::Code code, std::string reason) {
  return Status::Error(int{code}, std::move(reason));
}
inline Status Malformed(std::string reason) {
  return Refused(v1::CODE_MALFORMED, std::move(reason));
}
// The same error, its message behind "COMMAND: ".
inline Status Of(const std::string& command, const Status& status) {
  return status.ok() ? status : Status::Error(status.code(), command + ": " + status.message());
}

// Writes code and reason of an outcome into a reply. An error without a code is CODE_MALFORMED.
inline void FillReply(const Status& status, v1::Reply& reply) {
  reply.set_code(status.ok() ? v1::CODE_OK : v1::CODE_MALFORMED);
  if (status.code() != 0) reply.set_code(static_cast<v1::Code>(status.code()));
  reply.set_reason(status.message());
}

}  // namespace styled::pipeline
