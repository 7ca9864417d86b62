#pragma once

#include <string>

#include "daemon/perform/performance.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Executes an Explain request (control.proto): returns the fates of a performer's last frames, each
// with a sentence. Errors have a code. Pipeline thread; allocates.
Status Explain(const std::string& performer, const v1::Explain& which,
               const Performance& performance, v1::ExplainReply& reply);

}  // namespace styled::pipeline
