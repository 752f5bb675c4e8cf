// Hashes that are the same on every process, machine and run, and the digest of a set, which does not depend on the order of its members.
#pragma once

#include <xxhash.h>

#include <fmt/format.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace meld {

// A bijection of 64-bit words in which every input bit flips about half of the output bits (Stafford's variant 13 of the
// MurmurHash3 finalizer, as in SplitMix64).
constexpr std::uint64_t mix64(std::uint64_t x) {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9u;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebu;
    x ^= x >> 31;
    return x;
}

// The hash of a sequence of words, extended by one word; the order of words matters.
constexpr std::uint64_t hash_combine(std::uint64_t seed, std::uint64_t word) {
    return mix64(seed + 0x9e3779b97f4a7c15u + mix64(word ^ 0xd6e8feb86659fd93u));
}

inline std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed = 0) {
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

inline std::uint64_t hash_text(std::string_view text, std::uint64_t seed = 0) {
    return XXH3_64bits_withSeed(text.data(), text.size(), seed);
}

// The digest of a multiset: two wrapping sums of differently mixed members. Digests of disjoint parts add up to that of the whole, so any
// partition over threads and processes gives the same value, and a member can be removed again.
class Digest {
  public:
    constexpr Digest() = default;
    constexpr Digest(std::uint64_t low, std::uint64_t high) : low_(low), high_(high) {}

    constexpr void add(std::uint64_t member) {
        low_ += low_of(member);
        high_ += high_of(member);
    }
    constexpr void remove(std::uint64_t member) {
        low_ -= low_of(member);
        high_ -= high_of(member);
    }
    // Adds a member of any length.
    void add_bytes(std::span<const std::byte> bytes) {
        const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
        low_ += mix64(hash.low64);
        high_ += mix64(hash.high64);
    }
    void remove_bytes(std::span<const std::byte> bytes) {
        const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
        low_ -= mix64(hash.low64);
        high_ -= mix64(hash.high64);
    }
    constexpr void combine(const Digest& other) {
        low_ += other.low_;
        high_ += other.high_;
    }

    constexpr std::uint64_t low() const { return low_; }
    constexpr std::uint64_t high() const { return high_; }
    constexpr bool operator==(const Digest&) const = default;

    // 32 hexadecimal digits.
    std::string to_string() const { return fmt::format("{:016x}{:016x}", high_, low_); }

  private:
    static constexpr std::uint64_t low_of(std::uint64_t member) { return mix64(member + 0x9e3779b97f4a7c15u); }
    static constexpr std::uint64_t high_of(std::uint64_t member) {
        return mix64(mix64(member ^ 0xa0761d6478bd642fu) + 0xe7037ed1a0b428dbu);
    }

    std::uint64_t low_ = 0;
    std::uint64_t high_ = 0;
};

static_assert(std::is_trivially_copyable_v<Digest> && sizeof(Digest) == 16, "digests travel between processes as bytes");

}  // namespace meld
