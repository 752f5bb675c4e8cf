// Scratch memory, traps, and arithmetic without silent errors, for emitted code. No standard library.
#pragma once

#include "runtime/module/abi/module_abi.h"

namespace meld {

using ListRef = const List*;

// Rare calls, out of line, so that the common path stays short. They keep all registers of the caller, floating-point ones too, so that a
// sum in a loop does not go through memory because of a call that is never made.
#if defined(__clang__) && defined(__x86_64__)
#define MELD_ASIDE [[gnu::noinline, gnu::cold, clang::preserve_all]]
#else
#define MELD_ASIDE [[gnu::noinline, gnu::cold]]
#endif

MELD_ASIDE inline void more_arena(Eval& e, u64 bytes) { e.host->more_arena(&e, bytes); }
inline void* scratch(Eval& e, u64 bytes) {
    bytes = (bytes + 15) & ~u64{15};
    if (static_cast<u64>(e.arena_end - e.arena) < bytes) more_arena(e, bytes);
    void* result = e.arena;
    e.arena += bytes;
    return result;
}

// Whether a trap of this kind replaces the one that is set: the first one stays, except that a limit replaces it, since only a limit always
// ends the run.
inline bool outranks(Trap kind, Trap set) { return set == Trap::None || (is_limit(kind) && !is_limit(set)); }

MELD_ASIDE inline void trap(Eval& e, Trap kind, u32 rule, i64 left = 0, i64 right = 0) {
    if (!outranks(kind, e.trap)) return;
    e.trap = kind;
    e.trap_rule = rule;
    e.trap_left.integer = left;
    e.trap_right.integer = right;
    e.trap_real = false;
}
MELD_ASIDE inline void trap(Eval& e, Trap kind, u32 rule, double left, double right = 0) {
    if (!outranks(kind, e.trap)) return;
    e.trap = kind;
    e.trap_rule = rule;
    e.trap_left.real = left;
    e.trap_right.real = right;
    e.trap_real = true;
}
MELD_ASIDE inline void trap_text(Eval& e, Trap kind, u32 rule, const char* text, u64 count) {
    if (!outranks(kind, e.trap)) return;
    trap(e, kind, rule, static_cast<i64>(count));
    for (u64 i = 0; i < count && i < kMaxTrapText_bytes; ++i) e.trap_text[i] = text[i];
}

// ---- derivations without a value (docs/design.md, "Undefined derivations")

MELD_ASIDE inline void leave_out(Eval& e) {
    if (!e.subdomain->strict && !is_limit(e.trap)) e.host->note_undefined(&e);
}
// Host::fired.
MELD_ASIDE inline void tell_fired(Eval& e, u32 rule, u32 count, const BoundVariable* variables, const Value* values) {
    e.host->fired(&e, rule, count, variables, values);
}
// Whether a derivation of a view has succeeded so far. If not it is left out, and the next one starts again.
inline bool defined(Eval& e) {
    if (e.trap == Trap::None) [[likely]]
        return true;
    leave_out(e);
    return false;
}
// The same, and whether the condition that was just computed is true.
inline bool defined(Eval& e, bool condition) {
    const bool went_well = defined(e);
    return went_well && condition;
}
// Called before all rules of the stratum under evaluation are evaluated, and again in each round of a recursion.
inline void derive_anew(Eval& e) {
    if (e.undefined & undefined_bit(e.stratum)) [[unlikely]]
        e.host->forget_undefined(&e);
}

// ---- arithmetic without silent errors

inline i64 checked_add(Eval& e, u32 rule, i64 a, i64 b) {
    i64 r;
    if (__builtin_add_overflow(a, b, &r)) trap(e, Trap::Overflow, rule, a, b);
    return r;
}
inline i64 checked_subtract(Eval& e, u32 rule, i64 a, i64 b) {
    i64 r;
    if (__builtin_sub_overflow(a, b, &r)) trap(e, Trap::Overflow, rule, a, b);
    return r;
}
inline i64 checked_multiply(Eval& e, u32 rule, i64 a, i64 b) {
    i64 r;
    if (__builtin_mul_overflow(a, b, &r)) trap(e, Trap::Overflow, rule, a, b);
    return r;
}
inline bool divisible(Eval& e, u32 rule, i64 a, i64 b) {
    if (b == 0) {
        trap(e, Trap::DivisionByZero, rule, a, i64{0});
        return false;
    }
    if (b == -1 && a == (-__INT64_MAX__ - 1)) {
        trap(e, Trap::Overflow, rule, a, i64{-1});
        return false;
    }
    return true;
}
// Division truncates, and the remainder has the sign of the dividend, as in C and in all earlier Melds. -1 divides every int without a
// remainder, also where the quotient does not fit.
inline i64 checked_divide(Eval& e, u32 rule, i64 a, i64 b) { return divisible(e, rule, a, b) ? a / b : 0; }
inline i64 checked_modulo(Eval& e, u32 rule, i64 a, i64 b) { return b == -1 || !divisible(e, rule, a, b) ? 0 : a % b; }
inline double checked_divide(Eval& e, u32 rule, double a, double b) {
    if (b == 0) trap(e, Trap::DivisionByZero, rule, a, b);
    return a / b;
}
inline double checked_modulo(Eval& e, u32 rule, double a, double b) {
    if (b == 0) trap(e, Trap::DivisionByZero, rule, a, b);
    return b == 0 ? 0 : __builtin_fmod(a, b);
}
inline i64 checked_power(Eval& e, u32 rule, i64 a, i64 b) {
    if (b < 0) trap(e, Trap::NegativePower, rule, a, b);
    i64 result = 1;
    for (i64 i = 0; i < b && e.trap == Trap::None; ++i) {
        if (a == 0 || a == 1) return a;
        if (a == -1) return b % 2 ? -1 : 1;
        result = checked_multiply(e, rule, result, a);
    }
    return result;
}
inline i64 checked_truncate(Eval& e, u32 rule, double a) {
    if (!(a >= -9223372036854775808.0 && a < 9223372036854775808.0)) {
        trap(e, Trap::BadConversion, rule, a);
        return 0;
    }
    return static_cast<i64>(a);
}
inline i64 checked_abs(Eval& e, u32 rule, i64 a) { return a < 0 ? checked_subtract(e, rule, 0, a) : a; }
template <class V>
V least_of(V a, V b) {
    return b < a ? b : a;
}
template <class V>
V greatest_of(V a, V b) {
    return a < b ? b : a;
}
// A NaN has no place in an order and infinity is an overflow, so neither ever enters a fact; and zero has only one sign there, so that
// equal facts have equal bytes.
inline double checked_real(Eval& e, u32 rule, double a) {
    if (!(__builtin_fabs(a) <= __DBL_MAX__)) trap(e, a != a ? Trap::NotANumber : Trap::Overflow, rule, a);
    return a + 0.0;
}

// The same of what is never -0.0.
inline double checked_sum(Eval& e, u32 rule, double a) {
    if (!(__builtin_fabs(a) <= __DBL_MAX__)) trap(e, a != a ? Trap::NotANumber : Trap::Overflow, rule, a);
    return a;
}

// ---- random values, the same on any number of processes

// A number from 0 to below `bound`, each as likely as a 64-bit draw allows.
inline u64 draw_below(Eval& e, u64 bound) { return e.host->random(&e) % bound; }
// Unique values, except with a probability of 2^-63 for any two: a positive int, and an id of no catom.
inline i64 fresh_int(Eval& e) { return static_cast<i64>(e.host->random(&e) >> 1); }
inline u64 fresh_node(Eval& e) { return e.host->random(&e) | (u64{1} << 63); }

// ---- time

// The number of ticks nearest to this many seconds, at least one.
inline i64 ticks_of(Eval& e, double seconds) {
    const double ticks = seconds / e.subdomain->tick_seconds + 0.5;
    return ticks < 1 ? 1 : ticks < 9e18 ? static_cast<i64>(ticks) : __INT64_MAX__ / 2;
}

// ---- calls of functions of the program

// The maximum number of open calls, and of bytes of stack they may use together; a thread's stack has at least eight times as much.
inline constexpr u32 kMaxOpenCalls = 10'000;
inline constexpr i64 kMaxStack_bytes = 1 << 20;
// A call takes some nanoseconds, a derivation a hundred times as long: so many calls count as one for the limit.
inline constexpr u64 kCallsPerDerivation = 100;

class OpenCall {
  public:
    Eval& e;
    bool refused;

    // `base` is an address on the stack where the evaluation began; `calls` counts those of one catom in one tick.
    OpenCall(Eval& eval, u32 rule, const void* base, u64& calls) : e(eval), calls_(calls) {
        const i64 used = reinterpret_cast<i64>(base) - reinterpret_cast<i64>(__builtin_frame_address(0));
        if (++e.depth > kMaxOpenCalls || used > kMaxStack_bytes || used < -kMaxStack_bytes) trap(e, Trap::TooDeep, rule, i64{e.depth - 1});
        const u64 most = e.subdomain->max_growing_derivations;
        const u64 most_calls = most > ~u64{0} / kCallsPerDerivation - 1 ? ~u64{0} : (most + 1) * kCallsPerDerivation - 1;
        if (++calls_ > most_calls) trap(e, Trap::TooManyDerivations, rule, static_cast<i64>(most));
        refused = e.trap != Trap::None;
        left_ = kMaxOpenCalls - e.depth;
        if (most_calls - calls_ < left_) left_ = static_cast<u32>(most_calls - calls_);
    }
    ~OpenCall() {
        e.depth -= 1 + repeats_;
        calls_ += repeats_;
    }

    // A function that ends by calling itself starts again instead, which counts as a call. False: there were too many.
    bool again(u32 rule) {
        ++e.depth;
        if (++repeats_ > left_) [[unlikely]] {
            if (e.depth > kMaxOpenCalls)
                trap(e, Trap::TooDeep, rule, i64{e.depth - 1});
            else
                trap(e, Trap::TooManyDerivations, rule, static_cast<i64>(e.subdomain->max_growing_derivations));
        }
        return e.trap == Trap::None;
    }

  private:
    u64& calls_;
    u32 repeats_ = 0, left_;
};

// A call that returns a single word: nothing can refer to what it made in scratch memory, which is free again when it ends.
class WordCall : public OpenCall {
  public:
    WordCall(Eval& eval, u32 rule, const void* base, u64& calls)
        : OpenCall(eval, rule, base, calls), arena_(eval.arena), chunk_(eval.arena_start) {}
    ~WordCall() {
        if (e.arena_start == chunk_) e.arena = arena_;
    }

  private:
    u8* const arena_;
    u8* const chunk_;
};

// ---- order of values: three-way, for keys and tie-breaks

template <class V>
inline int compare(V a, V b) {
    return a < b ? -1 : b < a ? 1 : 0;
}

inline u64 mix(u64 h, u64 v) {
    h ^= v + 0x9e3779b97f4a7c15ull + (h << 6) + (h >> 2);
    h *= 0xff51afd7ed558ccdull;
    return h ^ (h >> 33);
}
inline u64 bits_of(double v) { return __builtin_bit_cast(u64, v); }
inline u64 bits_of(i64 v) { return static_cast<u64>(v); }
inline u64 bits_of(u64 v) { return v; }
inline u64 bits_of(bool v) { return v; }

}  // namespace meld
