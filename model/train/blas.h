#pragma once

namespace styled::train {

// OpenBLAS 0.3.21 (Debian 12) does not know CPUs younger than itself and multiplies with SSE3 on
// them: training then takes nearly twice as long. In that case, unless the user set
// OPENBLAS_CORETYPE, restarts this program with the kernels of the nearest CPU that it knows;
// otherwise returns. Call first in main, before libtorch does anything.
void UseFastKernels(char** argv);

}  // namespace styled::train
