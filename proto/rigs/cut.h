#pragma once

namespace styled::rigs {

// What is found at the front of the bytes that a rig's TCP stream has brought so far.
enum class [[nodiscard]] Cut {
  kRecord,    // one whole record
  kNeedMore,  // the beginning of one
  kBroken     // no record: nothing after this point can be trusted
};

}  // namespace styled::rigs
