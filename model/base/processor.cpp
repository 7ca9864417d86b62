#include "model/base/processor.h"

namespace styled {
namespace {

constexpr Instructions kAll[] = {
    {kSsse3, "SSSE3", "x86-64"},       {kSse42, "SSE4.2", "x86-64"}, {kPopcnt, "POPCNT", "x86-64"},
    {kAvx2, "AVX2", "x86-64-v2"},      {kFma, "FMA", "x86-64-v2"},   {kBmi2, "BMI2", "x86-64-v2"},
    {kAvx512, "AVX-512", "x86-64-v3"},
};

// Of the processor, where the system lets programs use it.
unsigned Present() noexcept {
#ifdef __x86_64__
  __builtin_cpu_init();
  const auto bit = [](int supported, unsigned one) { return supported != 0 ? one : 0; };
  return bit(__builtin_cpu_supports("ssse3"), kSsse3) |
         bit(__builtin_cpu_supports("sse4.2"), kSse42) |
         bit(__builtin_cpu_supports("popcnt"), kPopcnt) |
         bit(__builtin_cpu_supports("avx2"), kAvx2) | bit(__builtin_cpu_supports("fma"), kFma) |
         bit(__builtin_cpu_supports("bmi2"), kBmi2) |
         bit(__builtin_cpu_supports("avx512f"), kAvx512);
#else
  return ~0U;
#endif
}

}  // namespace

const Instructions* MissingInstructions() noexcept {
  const unsigned missing = processor_needs & ~Present();
  for (const Instructions& one : kAll) {
    if ((missing & one.bit) != 0) return &one;
  }
  return nullptr;
}

unsigned long ExplainMissing(const Instructions& missing, char* text, unsigned long size) noexcept {
  const char* const parts[] = {"this processor has no ", missing.name,
                               ", which this build needs; expected " STYLED_ARCH_NAME
                               ", or a build with -DSTYLED_ARCH=",
                               missing.build};
  unsigned long length = 0;
  for (const char* part : parts) {
    for (; *part != 0 && length + 1 < size; ++part) text[length++] = *part;
  }
  text[length] = 0;
  return length;
}

}  // namespace styled
