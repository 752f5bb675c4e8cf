// What crosses the links of a run in one tick: changed facts that neighbours read, and linear facts that rules send. A message is what
// `meldsim run --stats` counts as one (docs/profiling.md).
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/module/abi/module_abi.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

struct Messages {
    struct One {
        u64 from = 0, to = 0;
        // A fact that neighbours read came, went, has another value or another rank; or a linear fact is sent, by a rule or by a module.
        enum class Is : u8 { Came, Went, Changed, Ranked, Sent, Module } is = Is::Came;
        u32 predicate = 0;  // Its number in the module.
        std::string fact = {};
        std::string was = {};                  // Of Changed: the fact before.
        u32 rank = kAbsent;                    // Of a fact that has one.
        std::optional<std::int64_t> due = {};  // Of a delayed fact: the tick in which rules see it, after it has waited at its catom.
    };
    // A delayed fact at its catom, whose time has not come.
    struct Waiting {
        u64 catom = 0;
        std::string fact = {};
        std::int64_t tick = 0;  // In which its rules see it.
    };
    struct Predicate {
        std::string name = {};
        u32 number = 0;  // In the module.
        bool auxiliary = false;
        u64 count = 0;
    };
    std::int64_t tick = 0;                      // In which they are sent; rules read them in the next.
    std::optional<u64> catom = {};              // Only over its links.
    u64 count = 0, incoming = 0, outgoing = 0;  // All; of a catom to and from it.
    u64 modules = 0;                            // Of all, those that modules send, which no rule counts.
    std::vector<Predicate> predicates = {};     // The others.
    std::vector<One> shown = {};                // The first of them, by sender, fact and receiver.
    u64 waiting_count = 0;
    std::vector<Waiting> waiting = {};  // The first of them, by catom, tick and fact.

    // A line for each.
    std::string to_text() const;
    nlohmann::ordered_json to_json() const;
    // A table with a line for each message, and none for facts that wait.
    std::string to_csv() const;
    // For Graphviz: the links that carry something, with what they carry.
    std::string to_dot() const;
};

struct MessagesAsked {
    std::optional<u64> catom = {};  // Otherwise all.
    u64 most = ~u64{0};             // Beyond these, messages are only counted, and so are facts that wait.
};

// Those of the timeline's tick, on process 0; every process calls it. Errors: there is no such catom; the tick is that of a checkpoint, and
// what was sent in it is not known; those of groups_of() and the timeline. Cost: the tick once more, from the nearest snapshot, and twice a
// look at all facts that neighbours read; the messages that are shown pass through process 0.
Result<Messages> messages(timeline::Timeline& timeline, const MessagesAsked& asked);

}  // namespace meld::inspect
