#pragma once

#include <string>
#include <utility>

#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Why a request was refused, as in its reply. CODE_OK: it was accepted.
struct [[nodiscard]] Refusal {
  v1::Code code = v1::CODE_OK;
  std::string reason;

  bool ok() const { return code == v1::CODE_OK; }
  // Returns ok(). Otherwise fills the reply; `command` begins the reason.
  bool Accept(const std::string& command, v1::Reply& reply) const {
    if (ok()) return true;
    reply.set_code(code);
    reply.set_reason(command + ": " + reason);
    return false;
  }
};

inline Refusal Malformed(std::string reason) { return {v1::CODE_MALFORMED, std::move(reason)}; }

}  // namespace styled::pipeline
