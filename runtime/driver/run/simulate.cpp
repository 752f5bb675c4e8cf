#include "runtime/driver/run/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "runtime/base/byte_text.h"
#include "runtime/base/bytes.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/tick_log.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/checkpoints.h"
#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/run/fork.h"
#include "runtime/driver/run/junit.h"
#include "runtime/driver/run/replay.h"
#include "runtime/driver/run/report.h"
#include "runtime/driver/run/run_configuration.h"
#include "runtime/driver/session/debug.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/made_by.h"
#include "runtime/driver/setup/memory_check.h"
#include "runtime/driver/setup/memory_watch.h"
#include "runtime/driver/setup/outputs.h"
#include "runtime/driver/setup/watch_options.h"
#include "runtime/driver/study/run_counts.h"
#include "runtime/results/facts/facts_file.h"
#include "runtime/results/profile/file/profile_file.h"
#include "runtime/results/profile/report.h"
#include "runtime/results/profile/statistics.h"
#include "runtime/results/profile/times.h"
#include "runtime/results/record/digest_file.h"
#include "runtime/results/record/recorder.h"
#include "runtime/sim/core/setup/world_facts.h"
#include "runtime/sim/simulation.h"
#include "runtime/sim/watchers/printer.h"
#include "runtime/sim/watchers/watcher.h"
#include "runtime/world/lattice/move_table.h"

namespace meld::driver {

namespace {

// For people who ask what a recording was made by.
std::string made_by_json(const RunOptions& options) {
    nlohmann::ordered_json command = nlohmann::ordered_json::array();
    for (const std::string& word : options.command) command.push_back(text_of_bytes(word));
    std::error_code error;
    return nlohmann::ordered_json{
        {"versions", made_by()}, {"folder", text_of_bytes(std::filesystem::current_path(error).string())}, {"command", std::move(command)}}
        .dump();
}

// The steps of a run, in their order. Each returns the same on all processes.
class Run {
  public:
    Run(const RunOptions& options, comm::Communicator& comm, RunObserver* observer)
        : options_(options), comm_(comm), observer_(observer), speaks_(comm.process() == 0), again_(!options.replay.empty()) {}

    Result<void> read(const std::string& module_path);
    // Instead of all that follows: somebody walks through the run.
    Result<int> debug() { return debug_run(options_, *inputs_, claims_, comm_); }
    Result<void> open();
    Result<void> add_watchers();
    Result<void> set_up();
    Result<int> run();

  private:
    Result<void> add_recorder();
    Result<void> check_watches();
    void explain_watch();
    Result<void> write_junit(const Result<void>& ran);
    Result<void> open_checkpoints();
    Result<void> tick_to_the_end();
    Result<void> write_facts();
    // Where the time goes, if there is to be a profile; and the profile, also of a run that fails.
    void begin_measuring();
    void end_measuring();
    nlohmann::ordered_json statistics();
    Result<void> write_profile();
    Result<void> write_results();
    void warn();
    Result<void> report();
    Error after_failure(Error error);

    const RunOptions& options_;
    comm::Communicator& comm_;
    RunObserver* const observer_;  // Null: nobody.
    const bool speaks_;
    const bool again_;  // It is the run of a recording.
    std::optional<Inputs> inputs_;
    std::vector<Claim> claims_;
    Outputs outputs_;
    std::optional<interrupt::Answering> patiently_;  // As long as there are results to lose.
    std::optional<TickLog> log_;
    const eval::CpuSeconds* cpu_ = nullptr;
    std::optional<sim::Simulation> simulation_;
    profile::RunStatistics* statistics_ = nullptr;  // Of the simulation.
    std::optional<Checkpoints> checkpoints_;
    std::optional<Forked> forked_;
    std::unique_ptr<inspect::Watches> new_watches_;  // Until the run has them.
    inspect::Watches* watches_ = nullptr;            // If anything is watched.
};

// After how many ticks the ensemble is divided anew; 0: when it is worth it; none: never.
Result<std::optional<int>> parse_balance(std::string_view text) {
    if (text == "auto") return 0;
    if (text == "never") return std::nullopt;
    int ticks = 0;
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, ticks);
    const std::string_view unit(read.ptr, end);
    if (read.ec != std::errc{} || ticks < 1 || (unit != "ticks" && unit != "tick"))
        return fail(fmt::format("--balance: '{}' is no time", text), "Write auto, never, or a number of ticks such as 100ticks");
    return ticks;
}

// The output of catoms and the summary go to standard output, unless results are written there.
std::FILE* talk(const RunOptions& options) { return results_at_standard_output(options) ? stderr : stdout; }

Result<void> Run::read(const std::string& module_path) {
    Result<Inputs> inputs = read_inputs(options_, comm_, module_path);
    const Result<std::vector<Claim>> mine = inputs.map([&](const Inputs& in) { return claims(options_, in.module, in.world); });
    if (const auto alike = agree(comm_, mine); !alike) return alike;
    const auto need = [&](const MemoryNeed& memory) { return observer_ == nullptr ? Result<void>() : observer_->need(memory); };
    if (auto counted = count_catoms(options_, comm_, *inputs, need); !counted) return counted;
    if (options_.stats && !inputs->info().counts)
        return fail(fmt::format("{} does not count what its rules do", options_.program),
                    "Give the .meld file, or compile it with meldc compile --counters");
    if (!options_.profile.empty() && !inputs->info().places)
        return fail(fmt::format("{} does not say which rule runs", options_.program),
                    "Give the .meld file, or compile it with meldc compile --places");
    auto watches = make_watches(options_, inputs->info(), talk(options_));
    if (const auto all = comm::outcome_of_all(comm_, watches.map([](const auto&) {})); !all) return all;
    new_watches_ = std::move(*watches);
    inputs_.emplace(std::move(*inputs));
    claims_ = *mine;
    return {};
}

Result<void> Run::open() {
    const Result<std::optional<int>> balance = parse_balance(options_.balance);
    if (!balance) return tl::unexpected<Error>(balance.error());
    const Result<void> opened = speaks_ ? open_outputs(options_, inputs_->info(), outputs_) : Result<void>{};
    if (const auto all = comm::outcome_of_first(comm_, opened); !all) return all;
    simulation_.emplace(inputs_->info(), inputs_->world, inputs_->target, comm_, options_.threads);
    if (*balance && comm_.processes() > 1) simulation_->keep_balance(**balance);
    return {};
}

Result<void> Run::add_recorder() {
    const ModuleInfo& info = inputs_->info();
    const world::World& world = inputs_->world;
    const Result<record::Provenance> how = again_ ? record::Provenance{} : provenance(options_, info, world);
    if (const auto all = comm::outcome_of_all(comm_, how.map([](const auto&) {})); !all) return all;
    const record::RecordingInfo about{.program = info.sources[0].text,
                                      .world = world.text,
                                      .seed = world.seed,
                                      .arguments = options_.command,
                                      .lattice = std::string(world.lattice_name()),
                                      .radius = world.radius,
                                      .provenance = again_ ? "" : record::to_json(*how),
                                      .made_by = again_ ? "" : made_by_json(options_),
                                      .durability = durability(options_)};
    using Loaded = record::Recorder::Loaded;
    auto recorder = std::make_unique<record::Recorder>(options_.record, world.record.every, world.record.predicates, about,
                                                       options_.fork.empty() ? Loaded::Appends : Loaded::Begins);
    if (options_.stats) recorder->add_load();
    recorder->add_counts([this] {
        record::RunCounts counts;
        const auto all = counts_of(simulation_->summary());
        for (const auto& [name, value] : all.items()) {
            // A body that goes to another process is derived anew there: with other processes these two are others.
            if (inputs_->world.is_free() && (name == "evaluations" || name == "derivations")) continue;
            counts.emplace_back(name, value.get<std::int64_t>());
        }
        return counts;
    });
    simulation_->add(std::move(recorder), "recorder");
    return {};
}

Result<void> Run::add_watchers() {
    simulation_->add(std::make_unique<RoomToGrow>(inputs_->processes_here), "(room to grow)");
    if (!options_.record.empty())
        if (auto added = add_recorder(); !added) return added;
    if (again_) {
        auto check = make_check(options_.replay);
        if (const auto all = comm::outcome_of_all(comm_, check.map([](const auto&) {})); !all) return all;
        simulation_->add((*check)(), "check");
    }
    if (options_.measured()) {
        auto statistics = std::make_unique<profile::RunStatistics>(options_.stats ? profile::RunStatistics::Catoms::Counted
                                                                                  : profile::RunStatistics::Catoms::NotCounted);
        statistics_ = statistics.get();
        simulation_->add(std::move(statistics), "statistics");
    }
    if (!again_) {
        simulation_->add(std::make_unique<sim::Printer>(talk(options_)), "printer");
        simulation_->add(std::make_unique<sim::Watcher>(talk(options_)), "watcher");
    }
    watches_ = new_watches_.get();
    if (watches_ != nullptr) simulation_->add(std::move(new_watches_), "watches");
    if (observer_ != nullptr) observer_->begin(*simulation_);
    if (!options_.digest.empty())
        simulation_->add(
            std::make_unique<record::DigestFile>(options_.digest, durability(options_), std::move(outputs_.digest), options_.digest_check),
            "digests");
    return {};
}

Result<void> Run::open_checkpoints() {
    if (options_.checkpoint.empty()) return {};
    const Result<Interval> every = parse_interval(options_.checkpoint_every);
    if (!every) return tl::unexpected<Error>(every.error());
    using As = sim::CheckpointFolder::Run;
    using Stores = sim::CheckpointFolder::Stores;
    Result<sim::CheckpointFolder> folder =
        sim::CheckpointFolder::open(options_.checkpoint, options_.resume.empty() ? As::Begins : As::GoesOn, comm_,
                                    options_.checkpoint_changes ? Stores::Changes : Stores::Everything);
    if (!folder) return tl::unexpected<Error>(folder.error());
    checkpoints_.emplace(*simulation_, std::move(*folder), identity(options_, claims_, inputs_->world), *every);
    return {};
}

Result<void> Run::set_up() {
    if (auto opened = open_checkpoints(); !opened) return opened;
    const bool goes_on = !options_.resume.empty();
    if (goes_on) {
        if (auto done = checkpoints_->resume(inputs_->registry); !done) return done;
    } else if (!options_.fork.empty()) {
        auto forked = branch_off(options_.fork, identity(options_, claims_, inputs_->world), *simulation_, inputs_->registry);
        if (!forked) return tl::unexpected<Error>(forked.error());
        forked_ = std::move(*forked);
    } else if (auto done = simulation_->start(inputs_->registry, std::exchange(inputs_->counts, {})); !done) {
        return done;
    }
    if (checkpoints_)
        if (auto can = simulation_->saveable(); !can) return can;
    // From there it can go on by itself, whatever becomes of the run that it branches off from.
    if (forked_ && checkpoints_) checkpoints_->write();
    if (goes_on && speaks_ && !options_.quiet) log::info("goes on after tick {}", simulation_->subdomain().tick());
    if (forked_ && speaks_ && !options_.quiet) log::info("branches off from {}", describe(*forked_));
    // Also with --quiet: facts are missing.
    if (forked_ && speaks_ && !forked_->facts.dropped.empty())
        log::warning("{}: the program has no such facts any more, or derives them", describe_dropped(*forked_));
    return {};
}

// The facts of the last tick that went well, if they are still there, and what there is to say.
Error Run::after_failure(Error error) {
    sim::Subdomain& subdomain = simulation_->subdomain();
    const auto add = [&](const std::string& text) { error.suggestion += (error.suggestion.empty() ? "" : ".\n") + text; };
    if (const auto written = write_junit(tl::unexpected<Error>(error)); !written)
        add(fmt::format("How it went is not written: {}", written.error().message()));
    if (const auto written = write_profile(); !written) add(fmt::format("The profile is not written: {}", written.error().message()));
    if (options_.facts_out.empty()) return error;
    if (subdomain.status().half_way()) {
        error.suggestion += fmt::format("{}No facts are written, since tick {} ended in the middle of changing them",
                                        error.suggestion.empty() ? "" : ".\n", subdomain.status().last_tick() + 1);
    } else if (const auto written = write_facts(); !written && !written.error().problem.empty()) {
        error.suggestion +=
            fmt::format("{}The facts are not written: {}", error.suggestion.empty() ? "" : ".\n", written.error().message());
    }
    return error;
}

// Whether the time limit has passed on some process: clocks differ by a little, and all must end alike. Collective.
bool time_is_up(const RunOptions& options, comm::Communicator& comm) {
    if (options.timeout_seconds <= 0) return false;
    const std::byte mine{interrupt::time_is_up()};
    const std::vector<std::byte> all = comm.allgather({&mine, 1});
    return std::ranges::any_of(all, [](std::byte passed) { return passed != std::byte{0}; });
}

// A tick that was cut short when the time was up was not interrupted by anybody.
Error with_time_limit(const RunOptions& options, Error error) {
    if (error.code != ExitCode::Interrupted) return error;
    return {fmt::format("the time limit of {} s has passed: {}", options.timeout_seconds, error.problem), "Raise --timeout",
            ExitCode::LimitHit};
}

Result<void> Run::tick_to_the_end() {
    std::optional<Progress> progress;
    if (speaks_ && !options_.quiet) progress.emplace();
    Pace pace(simulation_->summary());
    const auto each = [&] {
        if (interrupt::received() != 0) simulation_->subdomain().request_stop();
        if (checkpoints_) checkpoints_->after_tick();
        if (watches_ != nullptr && watches_->caught_now()) explain_watch();
        if (!progress) return;
        progress->update([&] {
            const std::string line = progress_line(*simulation_, pace, options_.ticks);
            const std::string last = checkpoints_ ? checkpoints_->status() : "";
            return last.empty() ? line : line + ", " + last;
        });
    };
    const auto at_end = [&] {
        if (checkpoints_) checkpoints_->at_end();
    };
    const bool looks = checkpoints_ || watches_ != nullptr;
    return simulation_->run({options_.ticks, options_.strict, looks}, each, at_end);
}

Result<void> Run::write_facts() {
    if (options_.facts_out.empty()) return {};
    return record::write_facts(simulation_->subdomain(), record::facts_form(options_.facts_out), outputs_.facts.get());
}

void Run::begin_measuring() {
    if (options_.profile.empty()) return;
    log_.emplace(options_.threads);
    simulation_->subdomain().measure(*log_);
}

void Run::end_measuring() {
    if (!log_) return;
    log_->end();
    cpu_ = simulation_->subdomain().end_measuring();
}

// Collective; of all processes on the one that speaks.
nlohmann::ordered_json Run::statistics() {
    const profile::Gathered all = statistics_->gather(simulation_->subdomain());
    return speaks_ ? profile::to_json(inputs_->info(), all) : nlohmann::ordered_json();
}

Result<void> Run::write_profile() {
    if (!log_) return {};
    nlohmann::ordered_json stats = statistics();
    profile::add_times(simulation_->subdomain(), *log_, *cpu_, stats);
    Result<void> written;
    if (speaks_) {
        outputs_.profile->write(profile::file_text(
            run_json(simulation_->summary(), inputs_->world.path, comm_.processes(), options_.threads, options_.program), stats));
        written = outputs_.profile->commit();
    }
    return comm::outcome_of_first(comm_, written);
}

void Run::warn() {
    if (!speaks_) return;
    for (const std::string& each : warnings(simulation_->summary(), inputs_->world)) log::warning("{}", each);
}

// The most memory that one of the processes has had. Collective.
std::uint64_t greatest_peak(comm::Communicator& comm) {
    const std::uint64_t mine = resident_memory().peak;
    std::uint64_t greatest = 0;
    for (const auto& bytes : comm.allgather_any(std::as_bytes(std::span(&mine, 1))))
        greatest = std::max(greatest, ByteReader(bytes, "the memory of a process").read<std::uint64_t>());
    return greatest;
}

Result<void> Run::report() {
    const MemoryReport memory{inputs_->memory.peak(), greatest_peak(comm_)};
    const world::MoveTable* const moves = inputs_->world.motion.moves.get();
    std::vector<std::string> never_given;
    if (!inputs_->registry.may_give(inputs_->world)) never_given = sim::never_given(inputs_->info(), inputs_->world);
    // The run that this one has branched off from may have been given some.
    if (forked_) std::erase_if(never_given, [&](const std::string& name) { return forked_->facts.taken_over.contains(name); });
    const About about{.world = inputs_->world.path,
                      .default_world = world_path(options_).empty(),
                      .raw = inputs_->world.network.kind == world::NetworkKind::Raw,
                      .world_catoms = static_cast<std::uint64_t>(simulation_->subdomain().world_catoms()),
                      .never_given = never_given,
                      .processes = comm_.processes(),
                      .threads = options_.threads,
                      .restarts = options_.restarts,
                      .forked = forked_,
                      .memory = memory,
                      .moves = moves != nullptr ? moves->name() : std::string()};
    const nlohmann::ordered_json stats = options_.stats ? statistics() : nlohmann::ordered_json();
    if (speaks_ && options_.json) return print(stdout, summary_json(simulation_->summary(), about, stats));
    if (speaks_ && !options_.quiet)
        return print(talk(options_), summary_table(simulation_->summary(), about) + (stats.empty() ? "" : profile::tables(stats)));
    return {};
}

// What must hold at the end is looked for there, unless somebody has ended the run before.
Result<void> Run::check_watches() {
    if (watches_ == nullptr || simulation_->summary().ending == sim::Ending::Interrupted) return {};
    return watches_->at_end(simulation_->subdomain());
}

// What was found counts, also if nobody can say why.
void Run::explain_watch() {
    const Result<void> said = explain_caught(*watches_, *simulation_, options_, *inputs_, comm_);
    if (!said && speaks_ && said.error().code != ExitCode::Interrupted)
        log::warning("why this holds cannot be said: {}", said.error().message());
}

Result<void> Run::write_junit(const Result<void>& ran) {
    if (options_.junit.empty()) return {};
    Result<void> written;
    if (speaks_) {
        const bool interrupted = ran && simulation_->summary().ending == sim::Ending::Interrupted;
        const std::vector<inspect::Watches::Outcome> none;
        outputs_.junit->write(junit(options_.program, interrupted ? Result<void>(fail("interrupted", "", ExitCode::Interrupted)) : ran,
                                    simulation_->summary().run_seconds, watches_ == nullptr ? none : watches_->outcomes()));
        written = outputs_.junit->commit();
    }
    return comm::outcome_of_first(comm_, written);
}

// Each of them, whatever becomes of the others: the first error tells of all.
Result<void> Run::write_results() {
    Result<void> all;
    const auto note = [&](const Result<void>& done) {
        if (done) return;
        if (all)
            all = done;
        else
            all.error().suggestion += (all.error().suggestion.empty() ? "" : ".\n") + done.error().message();
    };
    note(write_facts());
    note(write_profile());
    const Result<void> checked = check_watches();
    note(checked);
    note(write_junit(checked));
    if (observer_ != nullptr && all) note(observer_->end(*simulation_, watches_, false));
    return all;
}

Result<int> Run::run() {
    if (speaks_ && !options_.quiet)
        if (const std::string tight = warning_of_memory(inputs_->world, inputs_->memory, inputs_->processes_here); !tight.empty())
            log::warning("{}", tight);
    if (speaks_) {
        const log::FewWarnings few;
        for (const std::string& each : inputs_->world.warnings) log::warning("{}", each);
    }
    patiently_.emplace(interrupt::Answer::Patiently);
    begin_measuring();
    const Result<void> ran = tick_to_the_end();
    end_measuring();
    const bool too_long = time_is_up(options_, comm_);
    const std::int64_t tick = simulation_->subdomain().tick();
    if (!ran && again_) return end_replay(options_, ran, tick, false, comm_);
    if (!ran && observer_ != nullptr) static_cast<void>(observer_->end(*simulation_, watches_, true));
    if (!ran) return tl::unexpected<Error>(after_failure(too_long ? with_time_limit(options_, ran.error()) : ran.error()));
    if (auto written = write_results(); !written) return tl::unexpected<Error>(written.error());
    warn();
    const bool interrupted = simulation_->summary().ending == sim::Ending::Interrupted;
    if (again_) return end_replay(options_, ran, tick, interrupted, comm_);
    if (auto printed = report(); !printed) return tl::unexpected<Error>(printed.error());
    // All messages have been printed: a signal that ends the process now interrupts nothing.
    interrupt::set_last_words(nullptr);
    if (interrupted && too_long)
        return fail(fmt::format("the time limit of {} s has passed; the run ended after a tick, and what it wrote is whole",
                                options_.timeout_seconds),
                    "Raise --timeout", ExitCode::LimitHit);
    if (interrupted) return static_cast<int>(ExitCode::Interrupted);
    return watches_ != nullptr && watches_->any_wrong() ? static_cast<int>(ExitCode::PropertyFailed) : 0;
}

}  // namespace

Result<int> simulate(const RunOptions& options, comm::Communicator& comm, const std::string& module_path, RunObserver* observer) {
    std::optional<interrupt::TimeLimit> limit;
    if (options.timeout_seconds > 0) limit.emplace("meldsim", options.timeout_seconds);
    Run run(options, comm, observer);
    Result<void> ready = run.read(module_path);
    if (ready && options.debug) return run.debug();
    if (ready) ready = run.open();
    if (ready) ready = run.add_watchers();
    if (ready) ready = run.set_up();
    if (!ready) return tl::unexpected<Error>(ready.error());
    return run.run();
}

}  // namespace meld::driver
