#pragma once

namespace styled::rigs {

// The content at the front of the bytes that a rig's TCP stream has delivered so far.
enum class [[nodiscard]] Cut {
  kRecord,    // one whole record
  kNeedMore,  // the beginning of one
  kBroken     // not a record: nothing after this point can be trusted
};

}  // namespace styled::rigs
