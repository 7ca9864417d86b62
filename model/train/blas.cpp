#include "model/train/blas.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace styled::train {

void UseFastKernels(char** argv) {
  constexpr const char* kChoice = "OPENBLAS_CORETYPE";  // read when the library is loaded
  if (std::getenv(kChoice) != nullptr) return;
  using Name = char* (*)();
  const auto core = reinterpret_cast<Name>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  if (core == nullptr || std::string_view(core()) != "Prescott") return;
#ifdef __x86_64__
  const char* known = nullptr;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) known = "Haswell";
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) {
    known = "SkylakeX";
  }
  if (known == nullptr || setenv(kChoice, known, 0) != 0) return;
  execv("/proc/self/exe", argv);  // on failure: slow, but right
#endif
}

}  // namespace styled::train
