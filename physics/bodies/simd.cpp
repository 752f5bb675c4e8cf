// Which variant of the kernels runs.
#include "physics/bodies/simd.h"

namespace meld::physics {

namespace {

SimdLevel best_level() {
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") ? SimdLevel::Avx2 : SimdLevel::Baseline;
#else
    return SimdLevel::Baseline;
#endif
}

SimdLevel current_level = best_level();

}  // namespace

SimdLevel simd_level() { return current_level; }

void set_simd_level(SimdLevel level) { current_level = level == SimdLevel::Avx2 ? best_level() : level; }

}  // namespace meld::physics
