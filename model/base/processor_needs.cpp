// Compiled for the processors of the whole build, unlike processor.cpp: the compiler names them.
#include "model/base/processor.h"

static_assert(sizeof(void*) == 8, "Styled needs a processor of 64 bits");
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "Styled needs a little-endian processor: it copies numbers to and from the wire");

namespace styled {

const unsigned processor_needs = 0
#ifdef __SSSE3__
                                 | kSsse3
#endif
#ifdef __SSE4_2__
                                 | kSse42
#endif
#ifdef __POPCNT__
                                 | kPopcnt
#endif
#ifdef __AVX2__
                                 | kAvx2
#endif
#ifdef __FMA__
                                 | kFma
#endif
#ifdef __BMI2__
                                 | kBmi2
#endif
#ifdef __AVX512F__
                                 | kAvx512
#endif
    ;

}  // namespace styled
