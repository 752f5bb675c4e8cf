// The mean of doubles: their exact sum, divided and rounded once, so that the order of the values does not matter. No standard library.
#pragma once

#include "runtime/module/kernel/values.h"

namespace meld {

// A fixed-point number in two's complement that holds every finite double and the sum of 2^32 of them: bit 0 weighs 2^-1074, the
// weight of the smallest double, and the largest is below 2^1024.
class ExactMean {
  public:
    void add(double value) {
        const u64 bits = __builtin_bit_cast(u64, value), fraction = bits & kFraction;
        const u32 exponent = static_cast<u32>(bits >> 52) & 0x7ff;
        const u64 significand = exponent == 0 ? fraction : fraction | (kFraction + 1);
        const u32 shift = exponent == 0 ? 0 : exponent - 1, at = shift / 64, offset = shift % 64;
        const u64 low = significand << offset, high = offset == 0 ? 0 : significand >> (64 - offset);
        if (bits >> 63 == 0)
            add_words(at, low, high);
        else
            subtract_words(at, low, high);
    }

    // The sum divided by count, rounded to the nearest double, ties to even. A mean of zero is +0. count > 0.
    double of(u32 count) const {
        ExactMean magnitude = *this;
        const bool negative = words_[kWords - 1] >> 63 != 0;
        if (negative) magnitude.negate();
        const u64 bits = magnitude.divided(count);
        return __builtin_bit_cast(double, negative&& bits != 0 ? bits | u64{1} << 63 : bits);
    }

  private:
    static constexpr u32 kWords = 34;
    static constexpr u64 kFraction = (u64{1} << 52) - 1;

    void add_words(u32 at, u64 low, u64 high) {
        bool carry = __builtin_add_overflow(words_[at], low, &words_[at]);
        const bool first = __builtin_add_overflow(words_[at + 1], high, &words_[at + 1]);
        carry = __builtin_add_overflow(words_[at + 1], u64{carry}, &words_[at + 1]) || first;
        for (u32 i = at + 2; carry && i < kWords; ++i) carry = ++words_[i] == 0;
    }
    void subtract_words(u32 at, u64 low, u64 high) {
        bool borrow = __builtin_sub_overflow(words_[at], low, &words_[at]);
        const bool first = __builtin_sub_overflow(words_[at + 1], high, &words_[at + 1]);
        borrow = __builtin_sub_overflow(words_[at + 1], u64{borrow}, &words_[at + 1]) || first;
        for (u32 i = at + 2; borrow && i < kWords; ++i) borrow = words_[i]-- == 0;
    }
    void negate() {
        bool carry = true;
        for (u64& word : words_) {
            word = ~word + u64{carry};
            carry = carry && word == 0;
        }
    }

    // A digit of 32 bits; below bit 0 there are zeros.
    u64 digit(i32 index) const { return index < 0 ? 0 : (words_[index / 2] >> (32 * (index % 2))) & 0xffffffffu; }

    // The bits of the double nearest to this number, which is not negative, divided by count: long division down to the first three
    // significant digits of the quotient, which have 65 bits or more, and a flag for a remainder.
    u64 divided(u32 count) const {
        i32 at = 2 * kWords - 1;
        while (at >= 0 && digit(at) == 0) --at;
        if (at < 0) return 0;
        u64 rest = 0, quotient[3] = {};
        // The first digit of the quotient is at that of the number or at the one after it.
        if (digit(at) < count) rest = digit(at--);
        for (u64& q : quotient) {
            const u64 part = rest << 32 | digit(at--);
            q = part / count;
            rest = part % count;
        }
        bool left = rest != 0;
        for (i32 i = at; i >= 0 && !left; --i) left = digit(i) != 0;
        // The top 64 bits of the quotient, and the weight of the lowest of them.
        const u64 top = quotient[0] << 32 | quotient[1];
        const i32 shift = __builtin_clzll(top);
        const u64 bits = shift == 0 ? top : top << shift | quotient[2] >> (32 - shift);
        left = left || (quotient[2] << shift & 0xffffffffu) != 0;
        return rounded(bits, 32 * (at + 2) - 1074 - shift, left);
    }

    // The bits of the double nearest to significand * 2^exponent, plus a little more if `left`. The highest bit is set.
    static u64 rounded(u64 significand, i32 exponent, bool left) {
        const i32 top = exponent + 63;  // The exponent of the highest bit.
        // A normal double keeps 53 bits, a smaller one only the bits that weigh 2^-1074 or more.
        const i32 dropped = top >= -1022 ? 11 : 11 - 1022 - top;
        if (dropped > 64) return 0;
        const u64 kept = dropped == 64 ? 0 : significand >> dropped;
        const u64 half = u64{1} << (dropped - 1), tail = significand & ((half - 1) | half);
        const bool up = tail > half || (tail == half && (left || (kept & 1) != 0));
        // A carry out of the fraction increments the exponent, as it should.
        const u64 biased = top >= -1022 ? static_cast<u64>(top + 1022) << 52 : 0;
        return biased + kept + u64{up};
    }

    u64 words_[kWords] = {};
};

}  // namespace meld
