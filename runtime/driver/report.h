// The reports of a run to its user: the live line, and the summary as a table or as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/driver/fork.h"
#include "runtime/driver/memory_need.h"
#include "runtime/driver/options.h"
#include "runtime/sim/simulation.h"

namespace meld::driver {

// "tick 120  2,304 awake  1.2 M derivations/s  3.4 M messages/s  74 bytes/catom  ..."; seconds: since the run began.
std::string progress_line(const sim::Simulation& simulation, double seconds, std::int64_t last_tick);
// The memory of the process that has had most.
struct MemoryReport {
    ByteRange expected = {};  // Before the run.
    std::uint64_t peak = 0;   // 0: not known.
};

// What a summary says of the run besides what was counted.
struct About {
    const std::string& world;  // The path of its file, or a text if there is none.
    int processes, threads;
    const std::vector<Restart>& restarts;
    const std::optional<Forked>& forked;
    MemoryReport memory;
};
std::string summary_table(const sim::Summary& summary, const About& about);
// The message that linear facts were dropped; empty: none were.
std::string warning_of_dropped(const sim::Summary& summary);
std::string summary_json(const sim::Summary& summary, const About& about);

}  // namespace meld::driver
