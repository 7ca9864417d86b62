#pragma once

#include "daemon/perform/performance.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// Executes an Explain request (control.proto): returns the fates of a performer's last frames, each
// with a sentence. Pipeline thread; allocates.
void Explain(const v1::Request& request, const Performance& performance, v1::Reply& reply);

}  // namespace styled::pipeline
