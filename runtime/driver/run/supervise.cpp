#include "runtime/driver/run/supervise.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/partial_outputs.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/units.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

namespace {

using comm::Heartbeat;
using comm::LaunchOutcome;

// By which a process that is started again learns why.
constexpr const char* kRestartsVariable = "CLAYMELD_RESTARTS";

constexpr int kInterrupted = static_cast<int>(ExitCode::Interrupted), kTerminated = 128 + SIGTERM;

bool is_interrupted(int exit_code) { return exit_code == kInterrupted || exit_code == kTerminated; }

// The processes report themselves that they were interrupted, unless they had not got that far.
int after_interrupt(const LaunchOutcome& outcome) {
    if (!outcome.told) print_error({"interrupted before its end"});
    return outcome.interrupted_by == SIGTERM ? kTerminated : kInterrupted;
}

constexpr const char* kLost = "a process was killed or crashed, which mpirun did not notice,";

// Where the run was, as far as its processes have told.
std::string place_of(const Heartbeat::Standing& at) {
    if (at.tick == 0) return "before the first tick";
    return at.process < 0 ? fmt::format("in tick {}", at.tick) : fmt::format("in tick {}, {}", at.tick, comm::describe(at.phase));
}

// Tells how the processes ended, and returns the code of the command.
int after_launch(const LaunchOutcome& outcome, bool alone) {
    // However the run ended, its results have not reached their reader.
    if (outcome.output_error != 0) return print_error(cannot_write(kStandardOutput, outcome.output_error));
    if (outcome.interrupted_by != 0 && outcome.exit_code >= 127) return after_interrupt(outcome);
    if (outcome.launcher_signal != 0)
        return print_error(
            {fmt::format("mpirun itself was ended by signal {}, so the outcome of the run is not known", outcome.launcher_signal),
             "Run it again; if mpirun crashes often, try another version of Open MPI", static_cast<ExitCode>(outcome.exit_code)});
    if (outcome.lost)
        return print_error({fmt::format("{} and the others were ended {}", kLost, place_of(outcome.standing)), "Start the run again",
                            static_cast<ExitCode>(outcome.exit_code)});
    // It was the process itself that somebody asked to end, and it has said so.
    if (outcome.told && is_interrupted(outcome.exit_code)) return outcome.exit_code;
    if (alone && outcome.exit_code == comm::kCannotStart)
        return print_error({"the process that computes cannot be started",
                            "There may be too many processes, or meldsim has been removed or replaced since this one began",
                            static_cast<ExitCode>(outcome.exit_code)});
    if (const std::string why = comm::describe_launch_failure(outcome.exit_code); !why.empty())
        return print_error({why, "", static_cast<ExitCode>(outcome.exit_code)});
    return outcome.exit_code;
}

// How often this machine has killed a process because memory ran out; 0 if it does not say.
std::uint64_t kills_for_memory() {
    std::ifstream in("/proc/vmstat");
    std::string name;
    for (std::uint64_t value = 0; in >> name >> value;)
        if (name == "oom_kill") return value;
    return 0;
}

// How a run ended that nobody had asked to end.
struct Accident {
    std::string what;
    std::int64_t tick = 0;
    // The signal that crashed it, or 0 if it hung; none of what the run does not do itself, and so need not do again.
    std::optional<int> cause;
};

Accident hang(const Heartbeat::Standing& at, const std::string& who, double heartbeat_s) {
    const std::string how = at.stopped     ? who + " was stopped by a signal or a debugger"
                            : at.busy == 0 ? "all processes waited for each other"
                                           : who + " hung";
    // Whoever stopped a process need not do it again.
    return {fmt::format("{}, without a sign of life for {},", how, format_duration(heartbeat_s)), at.tick,
            at.stopped ? std::nullopt : std::optional(0)};
}

std::optional<Accident> accident(const LaunchOutcome& outcome, int processes, double heartbeat_s, bool out_of_memory) {
    if (outcome.output_error != 0 || outcome.interrupted_by != 0) return std::nullopt;
    const Heartbeat::Standing& at = outcome.standing;
    const std::string who = processes == 1 ? "the run" : at.process >= 0 ? fmt::format("process {}", at.process) : "a process";
    if (outcome.hung) return hang(at, who, heartbeat_s);
    if (outcome.lost) return Accident{kLost, at.tick, std::nullopt};
    if (outcome.launcher_signal != 0)
        return Accident{fmt::format("mpirun was ended by signal {}", outcome.launcher_signal), at.tick, std::nullopt};
    const int signal = outcome.exit_code - 128;
    if (signal == SIGKILL)
        return out_of_memory ? Accident{who + " was killed (signal 9), because memory ran out,", at.tick, SIGKILL}
                             : Accident{who + " was killed (signal 9)", at.tick, std::nullopt};
    for (const int crash : {SIGSEGV, SIGBUS, SIGABRT, SIGILL, SIGFPE, SIGSYS})
        if (signal == crash) return Accident{fmt::format("{} crashed (signal {}: {})", who, signal, sigdescr_np(signal)), at.tick, signal};
    return std::nullopt;
}

nlohmann::json to_json(const std::vector<Restart>& restarts) {
    nlohmann::json out = nlohmann::json::array();
    for (const Restart& each : restarts) out.push_back({{"reason", each.reason}, {"in_tick", each.in_tick}, {"from_tick", each.from_tick}});
    return out;
}

// The run cannot go on by itself.
int give_up(const LaunchOutcome& outcome, const Accident& last, const std::string& why, const RunOptions& options) {
    const Result<sim::Manifest> newest = sim::newest_manifest(options.checkpoint);
    const std::string cure =
        newest ? fmt::format("The last checkpoint is of tick {}: `meldsim resume {}` goes on from there", newest->tick, options.checkpoint)
               : "There is no checkpoint yet";
    const std::string raise = outcome.hung && !outcome.standing.stopped ? ". If a tick may take that long, raise --heartbeat" : "";
    return print_error({fmt::format("{} {}; {}", last.what, place_of(outcome.standing), why), cure + raise,
                        outcome.hung ? ExitCode::LimitHit : static_cast<ExitCode>(outcome.exit_code)});
}

std::vector<std::string> command_of(const RunOptions& options, const std::string& module) {
    std::vector<std::string> command{std::filesystem::read_symlink("/proc/self/exe").string()};
    command.insert(command.end(), options.arguments.begin() + 1, options.arguments.end());
    command.insert(command.end(), {"--module", module});
    return command;
}

LaunchOutcome start(const RunOptions& options, const std::string& module, const std::vector<Restart>& before, Heartbeat& heartbeat) {
    const std::vector<std::string> command = command_of(options, module);
    if (is_supervised(options)) setenv(kRestartsVariable, to_json(before).dump().c_str(), 1);
    if (options.processes == 1 && is_supervised(options)) return comm::launch_alone(command, heartbeat);
    const auto input = options.debug && options.debug->typed ? comm::Relay::Input::Typed : comm::Relay::Input::Inherited;
    return comm::launch_mpi(options.processes, command, &heartbeat, input);
}

// What has been begun beside the results of a run.
std::set<std::string> begun(const RunOptions& options) {
    std::set<std::string> all;
    for (const OutputOption& output : kOutputs)
        if (const std::string& path = options.*output.path; !path.empty() && path != "-") all.merge(partial_outputs_of(path));
    return all;
}

}  // namespace

bool is_supervised(const RunOptions& options) { return !options.checkpoint.empty() && options.retries > 0; }

int supervise(RunOptions options, const std::string& module) {
    const bool again = is_supervised(options);
    const double heartbeat_s = again ? parse_heartbeat(options.heartbeat).value_or(0) : 0;
    Heartbeat heartbeat(options.processes, heartbeat_s);
    std::vector<Restart> restarts;
    std::vector<Accident> accidents;
    const std::set<std::string> before = again ? begun(options) : std::set<std::string>{};
    while (true) {
        const std::uint64_t kills_before = kills_for_memory();
        const LaunchOutcome outcome = start(options, module, restarts, heartbeat);
        const std::optional<Accident> now = accident(outcome, options.processes, heartbeat_s, kills_for_memory() > kills_before);
        if (!now || !again) return after_launch(outcome, again && options.processes == 1);
        for (const Accident& earlier : accidents)
            if (now->cause && earlier.cause == now->cause && earlier.tick == now->tick)
                return give_up(outcome, *now, "that is the second time, and it would come again", options);
        if (std::cmp_greater_equal(restarts.size(), options.retries))
            return give_up(outcome, *now, fmt::format("{} restart{} are used up", options.retries, options.retries == 1 ? "" : "s"),
                           options);
        accidents.push_back(*now);
        const Result<sim::Manifest> newest = sim::newest_manifest(options.checkpoint);
        restarts.push_back({.reason = now->what.substr(0, now->what.find_last_not_of(',') + 1),
                            .in_tick = now->tick,
                            .from_tick = newest ? newest->tick : 0});
        log::warning("{} {}; restart {} of {}, from {}", now->what, place_of(outcome.standing), restarts.size(), options.retries,
                     newest ? fmt::format("the checkpoint of tick {}", newest->tick) : "the start");
        // Nobody goes on with what a run has begun that starts over.
        if (!newest)
            for (const std::string& file : begun(options))
                if (!before.contains(file)) unlink(file.c_str());
        if (newest) options.arguments = resume_arguments(std::filesystem::absolute(options.checkpoint).string(), options);
    }
}

std::vector<Restart> restarts_so_far() {
    std::vector<Restart> out;
    const char* const text = std::getenv(kRestartsVariable);
    if (text == nullptr) return out;
    const nlohmann::json all = nlohmann::json::parse(text, nullptr, false);
    unsetenv(kRestartsVariable);
    if (!all.is_array()) return out;
    for (const auto& each : all)
        out.push_back({each.value("reason", ""), each.value("in_tick", std::int64_t{0}), each.value("from_tick", std::int64_t{0})});
    return out;
}

std::vector<std::string> resume_arguments(const std::string& folder, const RunOptions& options) {
    std::vector<std::string> out = {
        "meldsim", "resume", folder, "--processes", std::to_string(options.processes), "--threads", std::to_string(options.threads)};
    if (options.ticks >= 0) out.insert(out.end(), {"--ticks", std::to_string(options.ticks)});
    if (options.json) out.emplace_back("--json");
    if (options.quiet) out.emplace_back("--quiet");
    return out;
}

Result<double> parse_heartbeat(std::string_view text) {
    if (text == "off") return 0.0;
    const Result<double> seconds = parse_duration(text);
    if (!seconds || !(*seconds > 0))
        return fail(fmt::format("--heartbeat: '{}' is no time", text), "Write a time such as 60s or 10min, or off");
    return *seconds;
}

}  // namespace meld::driver
