// Where the time of a run went, on all processes: CPU time by rules, wall-clock time by stages of the tick.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "runtime/base/process/tick_log.h"
#include "runtime/engine/eval/samples.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::profile {

// On every process at the same time, after the run: adds what was measured to the JSON of the statistics that process 0 has made; of
// others it is left alone.
void add_times(const sim::Subdomain& subdomain, const TickLog& log, const eval::CpuSeconds& cpu, nlohmann::ordered_json& statistics);

// Sections of lines for a terminal: the rules that took most CPU time, with their text, and the stages of each process.
std::string time_tables(const nlohmann::ordered_json& profile);

// The ticks and stages of every process and thread as trace events, for Perfetto, Chrome and speedscope.
std::string trace_events(const nlohmann::ordered_json& profile);

}  // namespace meld::profile
