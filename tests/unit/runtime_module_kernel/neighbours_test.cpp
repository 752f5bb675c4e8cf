#include "runtime/module/kernel/neighbours.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>

namespace meld {
namespace {

TEST(Neighbours, AreCountedAndThoseThatAreMissingNamed) {
    constexpr i32 kPorts = 6;
    for (u32 gone = 0; gone < 1U << kPorts; ++gone) {
        std::array<i32, kNeighbourRoom> neighbours = {};
        for (i32 port = 0; port < kPorts; ++port)
            neighbours[static_cast<std::size_t>(port)] = (gone >> port & 1) != 0 ? -1 : 0x7fffffff - port;
        EXPECT_EQ(missing(neighbours.data()), gone);
        EXPECT_EQ(count_neighbours(neighbours.data(), kPorts), kPorts - std::popcount(gone));
    }
}

}  // namespace
}  // namespace meld
