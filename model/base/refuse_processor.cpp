// Linked into every program: ends it with a sentence, and code 1, before an instruction runs that
// the processor does not have. Else it would end by SIGILL.
#include <errno.h>
#include <unistd.h>

#include "model/base/processor.h"

namespace {

void Print(const char* text, unsigned long size) {
  // A sentence that cannot be written is no reason to run on.
  if (write(STDERR_FILENO, text, size) < 0) return;
}

// 101 is the first priority that programs may use: before all other objects are made.
[[gnu::constructor(101)]] void RefuseProcessor() {
  const styled::Instructions* const missing = styled::MissingInstructions();
  if (missing == nullptr) return;
  const char* const name = program_invocation_short_name;
  Print(name, __builtin_strlen(name));
  char text[256] = ": ";
  const unsigned long length = 2 + styled::ExplainMissing(*missing, text + 2, sizeof text - 3);
  text[length] = '\n';
  Print(text, length + 1);
  _exit(1);
}

}  // namespace
