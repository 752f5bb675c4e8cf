// The reports of a run to its user: the live line, and the summary as a table or as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/process/stage_clock.h"
#include "runtime/driver/run/fork.h"
#include "runtime/driver/setup/memory_need.h"
#include "runtime/driver/setup/options.h"
#include "runtime/sim/simulation.h"

namespace meld::driver {

// How fast a run goes since this object was made: the totals of one that goes on from a snapshot are older. If it is put back to an earlier
// tick, counting begins again there.
class Pace {
  public:
    explicit Pace(const sim::Summary& now, double seconds = seconds_now()) : since_(now, seconds) {}

    struct Rates {
        double ticks = 0, derivations = 0, messages = 0;  // A second.
    };
    Rates rates(const sim::Summary& now, double seconds = seconds_now());

  private:
    struct Counts {
        Counts(const sim::Summary& summary, double at_seconds);
        std::int64_t ticks;
        std::uint64_t derivations, messages;
        double seconds;
    };
    Counts since_;
};

// "tick 120  2,304 awake  1.2 M derivations/s  3.4 M messages/s  74 bytes/catom  ..."
std::string progress_line(const sim::Simulation& simulation, Pace& pace, std::int64_t last_tick);
// The memory of the process that has had most.
struct MemoryReport {
    ByteRange expected = {};  // Before the run.
    std::uint64_t peak = 0;   // 0: not known.
};

// What a summary says of the run besides what was counted.
struct About {
    const std::string& world;  // The path of its file, or a text if there is none.
    bool default_world;
    bool raw = false;                             // The network loses messages.
    std::uint64_t world_catoms;                   // When it was made.
    const std::vector<std::string>& never_given;  // Predicates.
    int processes, threads;
    const std::vector<Restart>& restarts;
    const std::optional<Forked>& forked;
    MemoryReport memory;
    std::string moves = {};  // What [motion] calls the moves of the world, as `the moves "pivoting"`; empty: it has none.
};
std::string summary_table(const sim::Summary& summary, const About& about);
// What no option hides, since facts are missing: linear facts that were dropped, actions of which nothing in this world carries any out,
// views that were undefined at the end, and, where nothing moves, routes that lead nowhere.
std::vector<std::string> warnings(const sim::Summary& summary, const world::World& world);
// What a profile says of the run as a whole.
nlohmann::ordered_json run_json(const sim::Summary& summary, const std::string& world, int processes, int threads,
                                const std::string& program);
// What was counted, by name: the same on any machine, and for any number of processes and threads.
nlohmann::ordered_json counts_json(const sim::Summary& summary);
// With what --stats adds, as JSON; empty: nothing.
std::string summary_json(const sim::Summary& summary, const About& about, const nlohmann::ordered_json& stats);

}  // namespace meld::driver
