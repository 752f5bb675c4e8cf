// What two results of runs differ in, as data: `meldsim diff` prints it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace meld::compare {

// Something that differs, with what it is in the one and in the other; empty lists: it is not there.
struct Difference {
    std::string what;  // "the seed", "position", "dist".
    std::vector<std::string> a = {}, b = {};
};

// Ticks that only one of them has.
struct LoneTicks {
    std::uint64_t count = 0;
    std::int64_t first = 0, last = 0;

    void add(std::int64_t tick) {
        first = count == 0 ? tick : first;
        last = tick;
        ++count;
    }
};

// The facts of one predicate.
struct PredicateFacts {
    std::string name;
    std::uint64_t both = 0, only_a = 0, only_b = 0;
    std::vector<std::string> a = {}, b = {};  // The first of those that only one has.

    bool same() const { return only_a == 0 && only_b == 0; }
};

struct Report {
    std::string kind;                         // "recordings"
    std::vector<Difference> runs = {};        // Of the runs themselves: program, seed, what is recorded.
    LoneTicks lone_a = {}, lone_b = {};       // In one alone.
    std::uint64_t same_ticks = 0;             // Before the first that differs.
    std::optional<std::int64_t> tick = {};    // The first that differs.
    std::optional<std::uint64_t> catom = {};  // The least one that differs in it.
    std::uint64_t catoms = 0;                 // How many differ in it.
    std::vector<Difference> here = {};        // In that tick, and at that catom if there is one.
    std::vector<PredicateFacts> facts = {};   // By name; also of predicates that are the same.
    std::string remark = {};                  // What could not be compared, and why; mostly empty.

    bool same() const {
        if (!runs.empty() || lone_a.count > 0 || lone_b.count > 0 || tick) return false;
        for (const PredicateFacts& each : facts)
            if (!each.same()) return false;
        return true;
    }
};

}  // namespace meld::compare
