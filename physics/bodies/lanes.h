// Eight single-precision lanes, and functions that load eight records of eight floats into lanes and store them back.
//
// Every operation is one IEEE operation per lane, never fused or approximate, so a kernel gives the same bits whether the compiler uses
// 128-bit or 256-bit instructions. Kernels are written once as inline functions over Lanes and compiled for each instruction set by
// MELD_KERNEL_VARIANTS; `simd_level` says which variant runs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "physics/bodies/simd.h"
#include "physics/bodies/types.h"

#define MELD_INLINE inline __attribute__((always_inline))
// The same for a lambda, after its arguments.
#define MELD_INLINE_CALL __attribute__((always_inline))

namespace meld::physics {

inline constexpr int kLanes = 8;

using Lanes = float __attribute__((vector_size(32)));
using LaneMask = std::int32_t __attribute__((vector_size(32)));
// These two may also overlay records of plain numbers.
using Quad = float __attribute__((vector_size(16), may_alias));
using DoubleQuad = double __attribute__((vector_size(32), may_alias));

MELD_INLINE Lanes lanes(float value) { return Lanes{value, value, value, value, value, value, value, value}; }
MELD_INLINE Lanes select(LaneMask mask, Lanes yes, Lanes no) { return mask ? yes : no; }
// The value where the mask is set, 0 elsewhere.
MELD_INLINE Lanes keep(LaneMask mask, Lanes value) { return reinterpret_cast<Lanes>(mask & reinterpret_cast<LaneMask>(value)); }
// Like std::max and std::min: the first argument if either is not a number.
MELD_INLINE Lanes max_lanes(Lanes a, Lanes b) { return a < b ? b : a; }
MELD_INLINE Lanes min_lanes(Lanes a, Lanes b) { return b < a ? b : a; }

// The vector in one lane.
inline Vec3 vector_of_lane(const Lanes& x, const Lanes& y, const Lanes& z, int i) {
    return {static_cast<double>(x[i]), static_cast<double>(y[i]), static_cast<double>(z[i])};
}

MELD_INLINE bool any(LaneMask mask) {
    using Long = long long __attribute__((vector_size(32)));
    const Long bits = reinterpret_cast<Long>(mask);
    return (bits[0] | bits[1] | bits[2] | bits[3]) != 0;
}

MELD_INLINE Lanes join(Quad low, Quad high) { return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7); }
// Through bytes: g++ compiles this to an extraction, and a shuffle to a permutation.
MELD_INLINE Quad half_of(const Lanes& value, int half) {
    Quad result;
    __builtin_memcpy(&result, reinterpret_cast<const char*>(&value) + 16 * half, sizeof result);
    return result;
}

// The layer is compiled with -fno-math-errno, so this is one or two instructions.
MELD_INLINE Lanes sqrt_lanes(Lanes value) {
    Lanes result;
#pragma GCC unroll 8
    for (int i = 0; i < kLanes; ++i) result[i] = __builtin_sqrtf(value[i]);
    return result;
}

// Two 4x4 transpositions side by side: row i holds quads i and i + 4; column k of all eight goes to columns[k].
MELD_INLINE void transpose(const Lanes (&rows)[4], Lanes (&columns)[4]) {
    const Lanes a = __builtin_shufflevector(rows[0], rows[1], 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes b = __builtin_shufflevector(rows[2], rows[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes c = __builtin_shufflevector(rows[0], rows[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes d = __builtin_shufflevector(rows[2], rows[3], 2, 10, 3, 11, 6, 14, 7, 15);
    columns[0] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    columns[1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    columns[2] = __builtin_shufflevector(c, d, 0, 1, 8, 9, 4, 5, 12, 13);
    columns[3] = __builtin_shufflevector(c, d, 2, 3, 10, 11, 6, 7, 14, 15);
}

// Quad `half` of the eight records (each of `stride` quads) at the given indices, as four columns of lanes.
MELD_INLINE void gather(const Quad* records, int stride, int half, const std::uint32_t* index, Lanes (&columns)[4]) {
    const auto at = [&](int i) MELD_INLINE_CALL {
        return records[static_cast<std::size_t>(index[i]) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(half)];
    };
    const Lanes rows[4] = {join(at(0), at(4)), join(at(1), at(5)), join(at(2), at(6)), join(at(3), at(7))};
    transpose(rows, columns);
}

MELD_INLINE void scatter(Quad* records, int stride, int half, const std::uint32_t* index, const Lanes (&columns)[4]) {
    Lanes rows[4];
    transpose(columns, rows);
    const auto at = [&](int i) MELD_INLINE_CALL -> Quad& {
        return records[static_cast<std::size_t>(index[i]) * static_cast<std::size_t>(stride) + static_cast<std::size_t>(half)];
    };
    at(0) = half_of(rows[0], 0), at(4) = half_of(rows[0], 1);
    at(1) = half_of(rows[1], 0), at(5) = half_of(rows[1], 1);
    at(2) = half_of(rows[2], 0), at(6) = half_of(rows[2], 1);
    at(3) = half_of(rows[3], 0), at(7) = half_of(rows[3], 1);
}

}  // namespace meld::physics

// Defines `void name(parameters)` as the call of name_kernel(arguments), an always-inlined function, compiled once for the
// baseline processor and once for AVX2.
#if defined(__x86_64__)
#define MELD_KERNEL_VARIANTS(name, parameters, arguments)                                           \
    static void name##_baseline parameters { name##_kernel arguments; }                             \
    __attribute__((target("avx2"))) static void name##_avx2 parameters { name##_kernel arguments; } \
    void name parameters {                                                                          \
        if (simd_level() == SimdLevel::Avx2)                                                        \
            name##_avx2 arguments;                                                                  \
        else                                                                                        \
            name##_baseline arguments;                                                              \
    }
#else
#define MELD_KERNEL_VARIANTS(name, parameters, arguments) \
    void name parameters { name##_kernel arguments; }
#endif
