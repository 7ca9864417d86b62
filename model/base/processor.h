#pragma once

// Whether this processor has the instructions that the build was compiled for (STYLED_ARCH). The
// sources are compiled for the oldest processor of the architecture, and include nothing of the
// standard library, whose inline functions the linker may take from a source compiled for a newer
// one. No allocation; any thread. Pinned by tests/unit/base/old_processor.sh.
namespace styled {

// An instruction set that -march may allow the compiler.
enum : unsigned {
  kSsse3 = 1,
  kSse42 = 2,
  kPopcnt = 4,
  kAvx2 = 8,
  kFma = 16,
  kBmi2 = 32,
  kAvx512 = 64,
};
struct Instructions {
  unsigned bit;
  const char* name;
  const char* build;  // the STYLED_ARCH that does without
};

// Those that this build uses, as a sum of these bits. Data, so that no instruction of the build
// runs before the check.
extern const unsigned processor_needs;

// The first that this build uses and the processor lacks; nullptr: none.
const Instructions* MissingInstructions() noexcept;

// The sentence for one that is missing, cut off at `size` bytes, with a 0 at its end. Returns its
// length. size >= 1.
unsigned long ExplainMissing(const Instructions& missing, char* text, unsigned long size) noexcept;

}  // namespace styled
