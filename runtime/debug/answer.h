// What a session of the debugger answers, as data; the same on any number of processes, but for what snapshots take.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "runtime/sim/simulation.h"

namespace meld::debug {

// Of step, back, to and run.
struct Moved {
    std::int64_t from = 0, tick = 0;
    std::optional<sim::Ending> ended = {};
};

struct FactsFound {
    std::int64_t tick = 0;
    std::uint64_t count = 0;
    std::vector<std::string> lines = {};  // As `--facts-out` writes them, in its order; the first of them where there are many.
};

struct Standing {
    std::int64_t tick = 0, first_tick = 0;
    std::uint64_t catoms = 0;
    std::optional<sim::Ending> ended = {};
    std::string digest = {};
    std::uint64_t history_bytes = 0;  // Of all processes.
    std::uint64_t snapshots = 0;
    std::optional<std::int64_t> oldest_snapshot = {};
};

// Of predicates whose facts differ.
struct Changes {
    struct Predicate {
        std::string name;
        std::uint64_t come = 0, gone = 0;
    };
    std::int64_t since = 0, tick = 0;
    std::vector<Predicate> predicates = {};
};

struct Explained {
    std::string text;
};

using Answer = std::variant<Moved, FactsFound, Standing, Changes, Explained>;

// For people: lines, each with its end.
std::string to_text(const Answer& answer);
// For programs: one object on one line.
std::string to_json(const Answer& answer);
std::string to_json(const Error& error);

}  // namespace meld::debug
