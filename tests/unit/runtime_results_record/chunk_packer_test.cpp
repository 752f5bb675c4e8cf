#include "runtime/results/hdf5/chunk_packer.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace meld::record {
namespace {

using Bytes = std::vector<std::byte>;

// What a reader of the file makes of it.
Bytes unpacked(const Bytes& packed, std::size_t size, std::size_t element_bytes) {
    Bytes planes(size), out(size);
    uLongf length = size;
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(planes.data()), &length, reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
              Z_OK);
    EXPECT_EQ(length, size);
    const std::size_t elements = size / element_bytes;
    for (std::size_t i = 0; i < elements; ++i)
        for (std::size_t byte = 0; byte < element_bytes; ++byte) out[i * element_bytes + byte] = planes[byte * elements + i];
    return out;
}

template <class Number>
Bytes bytes_of(const std::vector<Number>& numbers) {
    const auto bytes = std::as_bytes(std::span(numbers));
    return {bytes.begin(), bytes.end()};
}

std::uint64_t next(std::uint64_t& state) { return state = state * 6364136223846793005u + 1442695040888963407u; }

template <class Number>
std::vector<Bytes> chunks() {
    std::vector<Bytes> all;
    std::uint64_t state = 7;
    for (const std::size_t rows : {std::size_t{1}, std::size_t{300}, std::size_t{65536}, std::size_t{196608}}) {
        std::vector<Number> same(rows, static_cast<Number>(42)), up, mixed, random;
        for (std::size_t i = 0; i < rows; ++i) {
            up.push_back(static_cast<Number>(i));
            mixed.push_back(static_cast<Number>(next(state) >> 33 & 15));
            random.push_back(static_cast<Number>(next(state) >> 8));
        }
        for (const auto* numbers : {&same, &up, &mixed, &random}) all.push_back(bytes_of(*numbers));
    }
    return all;
}

template <class Number>
void expect_to_come_back() {
    ChunkPacker one;
    for (const Bytes& chunk : chunks<Number>()) {
        const Bytes packed = one.pack(chunk, sizeof(Number));
        if (packed.empty()) continue;
        EXPECT_LT(packed.size(), chunk.size());
        EXPECT_EQ(unpacked(packed, chunk.size(), sizeof(Number)), chunk);
        // Whatever has been packed before.
        EXPECT_EQ(ChunkPacker().pack(chunk, sizeof(Number)), packed);
        EXPECT_EQ(one.pack(chunk, sizeof(Number)), packed);
    }
}

TEST(ChunkPacker, GivesBackNumbersOfAnyWidth) {
    expect_to_come_back<std::uint8_t>();
    expect_to_come_back<std::uint16_t>();
    expect_to_come_back<std::uint32_t>();
    expect_to_come_back<std::int64_t>();
    expect_to_come_back<float>();
    expect_to_come_back<double>();
}

TEST(ChunkPacker, TakesLittleForWhatIsAlikeAndNoMoreThanThereIs) {
    ChunkPacker packer;
    const std::vector<Bytes> all = chunks<std::int64_t>();
    // Of 65,536 rows: the same, counting up, a few values, random.
    EXPECT_LT(packer.pack(all[8], 8).size(), 3000U);
    EXPECT_LT(packer.pack(all[9], 8).size(), 5000U);
    EXPECT_LT(packer.pack(all[10], 8).size(), 40000U);
    // A byte of random numbers is empty.
    EXPECT_LT(packer.pack(all[11], 8).size(), all[11].size() * 15 / 16);
    Bytes random(1 << 18);
    std::uint64_t state = 3;
    for (std::byte& each : random) each = static_cast<std::byte>(next(state) >> 40);
    EXPECT_TRUE(packer.pack(random, 8).empty());
    EXPECT_TRUE(packer.pack(random, 1).empty());
}

// More planes than are kept.
TEST(ChunkPacker, ForgetsWhatItKnows) {
    ChunkPacker packer;
    std::uint64_t state = 5;
    const Bytes first = bytes_of(std::vector<std::uint32_t>(65536, 0x01020304));
    const Bytes wanted = packer.pack(first, 4);
    for (int i = 0; i < 60; ++i) {
        std::vector<std::uint32_t> numbers(65536);
        for (std::uint32_t& each : numbers) each = static_cast<std::uint32_t>(next(state) >> 40);
        const Bytes chunk = bytes_of(numbers);
        EXPECT_EQ(unpacked(packer.pack(chunk, 4), chunk.size(), 4), chunk);
    }
    EXPECT_EQ(packer.pack(first, 4), wanted);
}

}  // namespace
}  // namespace meld::record
