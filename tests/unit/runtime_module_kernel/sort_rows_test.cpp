// Rows of any size are sorted as a stable sort does it, whatever runs they begin with.
#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "runtime/module/kernel/rows.h"
#include "tests/unit/runtime_module_kernel/scratch.h"

namespace meld {
namespace {

template <u32 Bytes>
struct Sized {
    u8 key;
    u8 rest[Bytes - 1];
    bool operator==(const Sized& other) const { return std::memcmp(this, &other, Bytes) == 0; }
};
struct ByKey {
    template <class Row>
    bool operator()(const Row& a, const Row& b) const {
        return a.key < b.key;
    }
};

struct SortRows : ScratchTest {
    std::mt19937 random{5};

    // As many runs of this length, upwards, of keys below `keys`; each row has a number of its own.
    template <u32 Bytes>
    std::vector<Sized<Bytes>> rows(u32 count, u32 run, u32 keys) {
        std::vector<Sized<Bytes>> out(count);
        for (u32 i = 0; i < count; ++i) {
            std::memset(&out[i], 0, Bytes);
            out[i].key = static_cast<u8>(random() % keys);
            std::memcpy(out[i].rest, &i, std::min<std::size_t>(sizeof i, Bytes - 1));
        }
        for (u32 begin = 0; begin < count; begin += run) std::stable_sort(&out[begin], &out[begin] + std::min(run, count - begin), ByKey());
        return out;
    }
    template <u32 Bytes>
    void expect_sorted(u32 count, u32 run, u32 keys) {
        std::vector<Sized<Bytes>> sorted = rows<Bytes>(count, run, keys), expected = sorted;
        std::ranges::stable_sort(expected, ByKey());
        sort_rows(e, sorted.data(), count, ByKey());
        EXPECT_TRUE(sorted == expected) << count << " rows of " << Bytes << " bytes in runs of " << run << ", keys below " << keys;
    }
};

TEST_F(SortRows, SortsAsAStableSortDoes) {
    for (const u32 count : {0u, 1u, 2u, 12u, 13u, 16u, 17u, 63u, 64u, 65u, 200u, 1000u})
        for (const u32 run : {1u, 2u, 7u, 8u, 9u, 31u, 100u, 333u, 1000u})
            for (const u32 keys : {1u, 2u, 17u, 256u}) {
                expect_sorted<3>(count, run, keys);
                expect_sorted<4>(count, run, keys);
                expect_sorted<8>(count, run, keys);
                expect_sorted<12>(count, run, keys);
                expect_sorted<16>(count, run, keys);
                expect_sorted<24>(count, run, keys);
                expect_sorted<40>(count, run, keys);
            }
}

u64 compared = 0;
struct Counting : ByKey {
    template <class Row>
    bool operator()(const Row& a, const Row& b) const {
        ++compared;
        return ByKey::operator()(a, b);
    }
};

TEST_F(SortRows, MergesTheRunsThatAreThere) {
    // What four neighbours offer in order: a look at each row, and two merges of it.
    std::vector<Sized<16>> sorted = rows<16>(4000, 1000, 256);
    sort_rows(e, sorted.data(), 4000, Counting());
    EXPECT_LE(compared, 3u * 4000 + 8);
    compared = 0;
    // Whatever they are, some twelve: the logarithm of their number, and two of them for the first eight.
    sorted = rows<16>(4000, 1, 256);
    sort_rows(e, sorted.data(), 4000, Counting());
    EXPECT_LE(compared, 14u * 4000);
}

}  // namespace
}  // namespace meld
