#pragma once

#include <cstdint>

#include "daemon/perform/performance.h"

namespace styled::pipeline {

// Fades styles out while the machine is overloaded, and back in (decide/overload.h). Performers
// with the least style lose it first, and pinned ones last; of equals, the one that came last.
// Styles return in the opposite order. Call after each turn that did something. Pipeline thread;
// allocates if something changes.
void BalanceLoad(Performance& performance, std::int64_t now_ns);

}  // namespace styled::pipeline
