// What a session of the debugger answers, as data; the same on any number of processes, but for what snapshots take.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "runtime/ask/debug/listing.h"
#include "runtime/ask/facts/catom.h"
#include "runtime/ask/messages/messages.h"
#include "runtime/ask/query/table.h"
#include "runtime/ask/why/explanation.h"
#include "runtime/ask/why/history.h"
#include "runtime/sim/simulation.h"

namespace meld::debug {

// A break or a watch that has ended a way forward, or what `until` has waited for.
struct Stop {
    std::optional<std::uint64_t> number = {};  // None: of `until`.
    std::string what = {};                     // The rule, or the body.
    std::vector<std::string> ways = {};        // A = @3, D = 7. Those that are new; of `until` the first. On process 0.
    std::vector<std::uint64_t> at = {};        // Of a linear rule: for each, the catom at which it fired.
};

// Of step, back, to, run and until.
struct Moved {
    std::int64_t from = 0, tick = 0;
    std::optional<sim::Ending> ended = {};
    std::vector<Stop> stops = {};  // On process 0.
    std::string branch = {};       // Of switch: where it is now.
};

// Of fork and branches.
struct BranchesFound {
    struct One {
        std::string name = {};
        std::int64_t tick = 0;     // Where it was left; of the present one, where it is.
        std::uint64_t events = 0;  // Done by hand in it.
        bool present = false;
    };
    std::vector<One> branches = {};
};

// Of break, watch, breaks and delete: all that there are then, but of break and watch the new one alone.
struct BreaksFound {
    struct One {
        std::uint64_t number = 0;
        bool rule = false;  // Otherwise a body.
        std::string what = {};
        std::vector<std::string> rules = {};  // "gradient.meld:10: dist(B, D + 1) :- ..."
    };
    std::vector<One> breaks = {};
};

// Of give, take, kill and events: what was done by hand.
struct EventsFound {
    struct One {
        std::int64_t tick = 0;  // In which it happens.
        std::string verb = {};  // The command.
        std::string fact = {};  // Of failures: what says which catoms.
        std::string predicate = {};
        std::uint64_t catom = 0;
        std::vector<std::string> arguments = {};  // After the catom; literals.
        std::vector<std::uint64_t> struck = {};   // Instead of these three: catoms that fail, or whose links do, by their numbers.
        bool links = false;                       // Links do.
        std::optional<std::int64_t> ticks = {};   // For so long.
    };
    std::int64_t tick = 0;
    std::uint64_t dropped = 0;  // Of later ticks, which are no more.
    std::vector<One> events = {};
};

// A file or folder that somebody has asked for.
struct Written {
    std::string path = {};
    std::string what = {};  // It holds so many of these.
    std::uint64_t count = 0;
};

// Of reload.
struct Reloaded {
    std::int64_t tick = 0;
    bool changed = true;  // Otherwise the program is the one that there was, and nothing has happened.
    sim::TakenOver facts = {};
    std::vector<BreaksFound::One> lost = {};  // Breaks and watches that the new program has no room for.
    std::vector<std::string> branches = {};   // They are gone, since their runs were those of the program as it was.
    std::string messages = {};                // What the compiler says.
};

// Of save: a checkpoint.
struct Saved {
    std::int64_t tick = 0;
    std::string folder = {};
    std::string digest = {};
    std::string events = {};  // The file with what was done by hand in the next tick; empty: nothing was.
};

struct FactsFound {
    std::int64_t tick = 0;
    std::uint64_t count = 0;
    std::vector<std::string> lines = {};            // As `--facts-out` writes them, in its order; the first of them where there are many.
    std::optional<inspect::CatomState> catom = {};  // Where everything about one was asked for.
};

struct RowsFound {
    std::int64_t tick = 0;
    std::string body = {};
    inspect::Table table = {};
    std::uint64_t most_rows = 0;  // So many of them are shown.
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

// Of depends: the run as it is, and the same without a fact.
struct Consequences {
    struct Run {
        std::int64_t tick = 0;  // Where it has come to.
        std::optional<sim::Ending> ended = {};
    };
    std::string fact = {};
    std::int64_t tick = 0;  // After which it is taken.
    Run with = {}, without = {};
    std::vector<Changes::Predicate> predicates = {};  // From the one to the other.
    std::vector<std::string> gone = {}, came = {};    // On process 0; the first of them where there are many.
};

// Of why and why-not. Without roots it is otherwise: the fact does not hold, or it does.
struct WhyFound {
    bool holds = true;
    inspect::Explanation explanation = {};
};

struct Explained {
    std::string text;
};

using Answer = std::variant<Moved, BreaksFound, EventsFound, BranchesFound, Written, Reloaded, Saved, FactsFound, RowsFound, WhyFound,
                            inspect::Comings, inspect::Messages, Consequences, RulesListed, PredicatesListed, Standing, Changes, Explained>;

// For people: lines, each with its end.
std::string to_text(const Answer& answer);
// For programs: one object on one line.
std::string to_json(const Answer& answer);
// For programs that also show it to people: the object has the text, too.
std::string to_json_with_text(const Answer& answer);
std::string to_json(const Error& error);

}  // namespace meld::debug
