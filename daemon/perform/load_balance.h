#pragma once

#include <cstdint>

#include "daemon/perform/performance.h"

namespace styled::pipeline {

// Fades styles out while the machine cannot keep up, and back in (decide/overload.h). Performers
// who show least of their style lose it first, before those who are pinned; of equals the one who
// came last. In the opposite order they get it back. Call after each turn that did something.
// Pipeline thread; allocates where something changes.
void BalanceLoad(Performance& performance, std::int64_t now_ns);

}  // namespace styled::pipeline
