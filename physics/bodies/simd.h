// Which instruction set the kernels use.
#pragma once

namespace meld::physics {

enum class SimdLevel { Baseline, Avx2 };

// The best level of this processor, unless set_simd_level has lowered it, for tests that compare the levels.
SimdLevel simd_level();
void set_simd_level(SimdLevel level);

}  // namespace meld::physics
