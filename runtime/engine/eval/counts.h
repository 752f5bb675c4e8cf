// What a run counts of its rules, predicates and catoms, on one process. A module compiled with counters fills it in (counts_abi.h); of
// others only the evaluations of each catom are counted, if somebody asks. Nothing of it changes what runs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/module/abi/counts_abi.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// What a catom has told its neighbours over the run.
struct CatomTold {
    u32 each = 0;      // Changed facts, over each of its links,
    u32 messages = 0;  // and over all of them.
    u64 each_bits = 0;
    u64 bits = 0;
};

// All that is counted of a catom, over the time that it is on this process.
struct CatomLoad {
    u32 evaluations = 0;
    CatomTold told = {};
    std::array<LinkCounts, kMaxPorts> sent = {};  // Linear facts, by port; those over further ports with the last.

    // Over all links.
    LinkCounts messages() const;
    // What the busiest port has carried out of it: of messages and bits the greatest each. Of a catom whose links have changed it is an
    // upper bound: what it tells all of them counts as if this one had been there the whole time.
    LinkCounts greatest_link() const;
};

// The sums of it.
struct CatomSums {
    u32 evaluations = 0;
    LinkCounts messages = {}, greatest_link = {};
};

class Counts {
  public:
    Counts(const ModuleInfo& module, std::size_t threads);
    Counts(const Counts&) = delete;
    Counts& operator=(const Counts&) = delete;

    // What thread number i counts with.
    Counters& of(std::size_t i) { return threads_[i].counters; }
    void resize(std::size_t catoms);
    // Before an evaluation: no catom has more ports.
    void room_for_ports(std::size_t ports);
    // Thread number i is going to evaluate a block of so many catoms, or has evaluated this one. Different threads have different catoms.
    void begin_block(std::size_t i, std::size_t catoms);
    void end_block(std::size_t i, std::span<const u32> catoms);
    // The catom leaves this process; its index may be given to another one.
    void forget(u32 catom, u64 id);

    // Over all threads.
    RuleCounts rule(u32 rule) const;
    PredicateCounts predicate(u32 predicate) const;
    LinkCounts greatest() const;
    CatomLoad catom(u32 catom) const;
    u32 evaluations(u32 catom) const { return evaluations_[catom]; }
    CatomSums sums(u32 catom) const;
    // Those that have left, by their ids; some may be here again.
    const std::unordered_map<u64, CatomLoad>& left() const { return left_; }
    std::size_t bytes() const {
        return evaluations_.capacity() * sizeof(u32) + told_.capacity() * sizeof(ToldSoFar) + links_.capacity() * sizeof(LinkCounts);
    }

  private:
    CatomTold told(u32 catom) const;

    struct Thread {
        std::vector<RuleCounts> rules;
        std::vector<PredicateCounts> predicates;
        std::vector<Told> told;
        std::vector<LinkCounts> sent;  // By port.
        Counters counters;
        std::unordered_map<u32, CatomTold> large;  // By catom: what does not fit there.
    };
    // CatomTold in the least memory, for it is what counting waits for.
    struct ToldSoFar {
        u32 each = 0, messages = 0, each_bits = 0, bits = 0;
    };
    const ModuleInfo& module_;
    std::vector<Thread> threads_;
    std::vector<u32> evaluations_;   // By catom.
    std::vector<ToldSoFar> told_;    // Only if the module counts.
    std::vector<LinkCounts> links_;  // By port; only if its rules send.
    std::unordered_map<u64, CatomLoad> left_;
};

void add(RuleCounts& sum, const RuleCounts& more);
void add(PredicateCounts& sum, const PredicateCounts& more);
void add(CatomLoad& sum, const CatomLoad& more);
// Of each the greater.
void raise(LinkCounts& greatest, const LinkCounts& other);

}  // namespace meld::eval
