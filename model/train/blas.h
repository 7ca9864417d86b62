#pragma once

namespace styled::train {

// OpenBLAS 0.3.21 (Debian 12) does not know CPUs younger than itself and multiplies with SSE3 on
// them: training then takes nearly twice as long. Where that is so and the user chose nothing in
// OPENBLAS_CORETYPE, starts this program anew with the kernels of the nearest CPU that it knows;
// else returns. Call first in main, before libtorch does anything.
void UseFastKernels(char** argv);

}  // namespace styled::train
