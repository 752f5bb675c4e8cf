#include "runtime/driver/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <span>

#include "runtime/base/available_memory.h"
#include "runtime/base/bytes.h"
#include "runtime/base/interrupt.h"
#include "runtime/base/log.h"
#include "runtime/base/progress.h"
#include "runtime/base/pulse.h"
#include "runtime/base/standard_streams.h"
#include "runtime/comm/communicator.h"
#include "runtime/comm/launch.h"
#include "runtime/comm/outcome.h"
#include "runtime/driver/agreement.h"
#include "runtime/driver/bisect.h"
#include "runtime/driver/checkpoints.h"
#include "runtime/driver/claims.h"
#include "runtime/driver/debug.h"
#include "runtime/driver/inputs.h"
#include "runtime/driver/memory_check.h"
#include "runtime/driver/outputs.h"
#include "runtime/driver/replay.h"
#include "runtime/driver/report.h"
#include "runtime/driver/supervise.h"
#include "runtime/driver/tell.h"
#include "runtime/record/digest_file.h"
#include "runtime/record/facts_file.h"
#include "runtime/record/recorder.h"
#include "runtime/sim/simulation.h"
#include "runtime/sim/watchers/printer.h"
#include "runtime/sim/watchers/watcher.h"

namespace meld::driver {

namespace {

// The process that reports for the run also reports when it is ended at once. One that is supervised gets every request twice, from the
// terminal and from its supervisor.
void handle_interrupts(bool speaks, bool supervised = false) {
    if (supervised)
        interrupt::handle({SIGINT, SIGTERM, SIGHUP, comm::kEndWellSignal, comm::kEndNowSignal},
                          {SIGINT, SIGTERM, SIGHUP, comm::kEndWellSignal});
    else
        interrupt::handle({SIGINT, SIGTERM, SIGHUP, comm::kEndWellSignal}, {comm::kEndWellSignal});
    if (speaks) interrupt::set_last_words("meldsim: interrupted before its end\n");
}

// The facts of the last tick that went well, if they are still there, and what there is to say. On every process.
Error after_failure(sim::Subdomain& subdomain, const RunOptions& options, Outputs& outputs, Error error) {
    if (options.facts_out.empty()) return error;
    if (subdomain.status().half_way()) {
        error.suggestion += fmt::format("{}No facts are written, since tick {} ended in the middle of changing them",
                                        error.suggestion.empty() ? "" : ".\n", subdomain.status().last_tick() + 1);
    } else if (const auto written = record::write_facts(subdomain, record::facts_form(options.facts_out), outputs.facts.get()); !written) {
        error.suggestion +=
            fmt::format("{}The facts are not written: {}", error.suggestion.empty() ? "" : ".\n", written.error().message());
    }
    return error;
}

// None without --checkpoint. On every process.
Result<std::optional<Checkpoints>> open_checkpoints(const RunOptions& options, sim::Simulation& simulation,
                                                    const std::vector<Claim>& claims) {
    if (options.checkpoint.empty()) return std::optional<Checkpoints>();
    const Result<Interval> every = parse_interval(options.checkpoint_every);
    if (!every) return tl::unexpected<Error>(every.error());
    using Run = sim::CheckpointFolder::Run;
    Result<sim::CheckpointFolder> folder =
        sim::CheckpointFolder::open(options.checkpoint, options.resume.empty() ? Run::Begins : Run::GoesOn, simulation.subdomain().comm);
    if (!folder) return tl::unexpected<Error>(folder.error());
    return std::optional<Checkpoints>(std::in_place, simulation, std::move(*folder), identity(options, claims), *every);
}

// Whether the time limit has passed on some process: clocks differ by a little, and all must end alike. Collective.
bool time_is_up(const RunOptions& options, comm::Communicator& comm) {
    if (options.timeout_seconds <= 0) return false;
    const std::byte mine{interrupt::time_is_up()};
    const std::vector<std::byte> all = comm.allgather({&mine, 1});
    return std::ranges::any_of(all, [](std::byte passed) { return passed != std::byte{0}; });
}

// The most memory that one of the processes has had. Collective.
std::uint64_t greatest_peak(comm::Communicator& comm) {
    const std::uint64_t mine = resident_memory().peak;
    std::uint64_t greatest = 0;
    for (const auto& bytes : comm.allgather_any(std::as_bytes(std::span(&mine, 1))))
        greatest = std::max(greatest, ByteReader(bytes, "the memory of a process").read<std::uint64_t>());
    return greatest;
}

// A tick that was cut short when the time was up was not interrupted by anybody.
Error with_time_limit(const RunOptions& options, Error error) {
    if (error.code != ExitCode::Interrupted) return error;
    return {fmt::format("the time limit of {} s has passed: {}", options.timeout_seconds, error.problem), "Raise --timeout",
            ExitCode::LimitHit};
}

// Everything after the processes have started. Errors that all processes share are reported only by process 0.
Result<int> simulate(const RunOptions& options, comm::Communicator& comm, const std::string& module_path) {
    std::optional<interrupt::TimeLimit> limit;
    if (options.timeout_seconds > 0) limit.emplace("meldsim", options.timeout_seconds);
    const Result<Inputs> inputs = read_inputs(options, comm, module_path);
    const Result<std::vector<Claim>> mine = inputs.map([&](const Inputs& in) { return claims(options, in.module, in.world); });
    if (const auto alike = agree(comm, mine); !alike) return tl::unexpected<Error>(alike.error());
    if (options.debug) return debug_run(options, *inputs, *mine, comm);
    const ModuleInfo& info = inputs->info();
    const world::World& world = inputs->world;
    Outputs outputs;
    const Result<void> opened = comm.process() == 0 ? open_outputs(options, info, outputs) : Result<void>{};
    if (const auto all = comm::outcome_of_first(comm, opened); !all) return tl::unexpected<Error>(all.error());

    std::optional<interrupt::Answering> patiently;
    sim::Simulation simulation(info, world, inputs->target, comm, options.threads);
    const bool speaks = comm.process() == 0;
    const bool again = !options.replay.empty();
    if (!options.record.empty()) {
        const Result<record::Provenance> how = again ? record::Provenance{} : provenance(options, info, world);
        if (const auto all = comm::outcome_of_all(comm, how.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        const record::RecordingInfo about{.program = info.sources[0].text,
                                          .world = world.text,
                                          .seed = world.seed,
                                          .arguments = options.command,
                                          .lattice = std::string(world::Lattice(world.lattice).name()),
                                          .radius = world.radius,
                                          .provenance = again ? "" : record::to_json(*how),
                                          .durability = options.sync ? Durability::Machine : Durability::Process};
        simulation.add(std::make_unique<record::Recorder>(options.record, world.record.every, world.record.predicates, about));
    }
    // The output of catoms and the summary go to standard output, unless results are written there.
    std::FILE* const talk = results_at_standard_output(options) ? stderr : stdout;
    if (again) {
        auto check = make_check(options.replay);
        if (const auto all = comm::outcome_of_all(comm, check.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        simulation.add((*check)());
    }
    if (!options.question && !again) {
        simulation.add(std::make_unique<sim::Printer>(talk));
        simulation.add(std::make_unique<sim::Watcher>(talk));
    }
    if (!options.digest.empty())
        simulation.add(std::make_unique<record::DigestFile>(options.digest, durability(options), std::move(outputs.digest)));
    Result<std::optional<Checkpoints>> opened_checkpoints = open_checkpoints(options, simulation, *mine);
    if (!opened_checkpoints) return tl::unexpected<Error>(opened_checkpoints.error());
    std::optional<Checkpoints>& checkpoints = *opened_checkpoints;
    const bool goes_on = !options.resume.empty();
    if (auto done = goes_on ? checkpoints->resume(inputs->registry) : simulation.start(inputs->registry); !done)
        return tl::unexpected<Error>(done.error());
    if (checkpoints)
        if (const auto can = simulation.saveable(); !can) return tl::unexpected<Error>(can.error());
    if (goes_on && speaks && !options.quiet) log::info("goes on after tick {}", simulation.subdomain().tick());

    if (options.question) return find_tick(options, simulation);

    if (speaks && !options.quiet)
        if (const std::string tight = warning_of_memory(world, inputs->memory, inputs->processes_here); !tight.empty())
            log::warning("{}", tight);
    // From here on there are results to lose.
    patiently.emplace(interrupt::Answer::Patiently);
    std::optional<Progress> progress;
    if (speaks && !options.quiet) progress.emplace();
    const auto begin = std::chrono::steady_clock::now();
    const auto each = [&] {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
        if (checkpoints) checkpoints->after_tick();
        if (!progress) return;
        progress->update([&] {
            std::string line =
                progress_line(simulation, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), options.ticks);
            const std::string last = checkpoints ? checkpoints->status() : "";
            return last.empty() ? line : line + ", " + last;
        });
    };
    const auto at_end = [&] {
        if (checkpoints) checkpoints->at_end();
    };
    const Result<void> ran = simulation.run({options.ticks, options.strict}, each, at_end);
    progress.reset();
    const bool too_long = time_is_up(options, comm);
    if (!ran && again) return end_replay(options, ran, simulation.subdomain().tick(), false, comm);
    if (!ran) {
        const Error why = too_long ? with_time_limit(options, ran.error()) : ran.error();
        return tl::unexpected<Error>(after_failure(simulation.subdomain(), options, outputs, why));
    }
    if (!options.facts_out.empty()) {
        const auto form = record::facts_form(options.facts_out);
        if (auto written = record::write_facts(simulation.subdomain(), form, outputs.facts.get()); !written)
            return tl::unexpected<Error>(written.error());
    }
    // Also with --quiet: facts are missing.
    if (const std::string dropped = warning_of_dropped(simulation.summary()); speaks && !dropped.empty()) log::warning("{}", dropped);
    if (speaks && !simulation.summary().undefined.empty())
        log::warning("the run ended before quiescence, and {}", simulation.summary().undefined);
    if (speaks && !simulation.summary().dead_link.empty())
        log::warning("{}: nothing is read or sent along it. Link catoms that touch, or declare the predicate without `route`",
                     simulation.summary().dead_link);
    if (again)
        return end_replay(options, ran, simulation.subdomain().tick(), simulation.summary().ending == sim::Ending::Interrupted, comm);
    const MemoryReport memory{inputs->memory.peak(), greatest_peak(comm)};
    Result<void> printed;
    if (speaks && options.json)
        printed =
            print(stdout, summary_json(simulation.summary(), memory, options.restarts, world.path, comm.processes(), options.threads));
    else if (speaks && !options.quiet)
        printed = print(talk, summary_table(simulation.summary(), memory, options.restarts, world.path, comm.processes(), options.threads));
    if (!printed) return tl::unexpected<Error>(printed.error());
    // All messages have been printed: a signal that ends the process now interrupts nothing.
    interrupt::set_last_words(nullptr);
    if (simulation.summary().ending == sim::Ending::Interrupted && too_long)
        return fail(fmt::format("the time limit of {} s has passed; the run ended after a tick, and what it wrote is whole",
                                options.timeout_seconds),
                    "Raise --timeout", ExitCode::LimitHit);
    return simulation.summary().ending == sim::Ending::Interrupted ? static_cast<int>(ExitCode::Interrupted) : 0;
}

// Process 0 compiles and sends the others the path of the module.
Result<std::string> module_for_all(const RunOptions& options, comm::Communicator& comm) {
    if (!options.module.empty()) return options.module;
    Result<std::string> mine = comm.process() == 0 ? compile_program(options) : Result<std::string>("");
    if (comm.processes() == 1) return mine;
    const int code = mine ? 0 : static_cast<int>(mine.error().code);
    const std::string text = mine ? *mine : mine.error().problem;
    ByteWriter bytes;
    bytes.write(code);
    bytes.write_string(text);
    const auto all = comm.allgather_any(bytes.view());
    ByteReader in(all[0], "what process 0 compiled");
    const int first = in.read<int>();
    const std::string module = in.read_string();
    if (first != 0) return fail(comm.process() == 0 ? text : "", "", static_cast<ExitCode>(first));
    return module;
}

int run_processes(const RunOptions& options, comm::Communicator& comm) {
    const auto attempt = [&]() -> Result<int> {
        const Result<std::string> module = module_for_all(options, comm);
        if (!module) return tl::unexpected<Error>(module.error());
        return simulate(options, comm, *module);
    };
    const Result<int> done = attempt();
    // From here on all messages have been printed. If one process has ended, mpirun ends the others, so they wait until the first has
    // reported why.
    interrupt::set_last_words(nullptr);
    const int code = done ? *done : comm.process() == 0 ? tell(done.error()) : static_cast<int>(done.error().code);
    if (!done) comm.barrier();
    return code == static_cast<int>(ExitCode::Interrupted) ? interrupt::exit_code() : code;
}

}  // namespace

int run_command(RunOptions options) {
    if (const auto distinct = check_outputs(options, world_path(options)); !distinct) return tell(distinct.error());
    if (const auto every = parse_interval(options.checkpoint_every); !every) return tell(every.error());
    if (const auto seconds = parse_heartbeat(options.heartbeat); !seconds) return tell(seconds.error());
    const bool under_mpi = comm::under_mpi();
    const char* const rank = under_mpi ? std::getenv("OMPI_COMM_WORLD_RANK") : nullptr;
    const bool supervised = pulse::attach(rank != nullptr ? static_cast<std::size_t>(std::atoi(rank)) : 0) && !under_mpi;
    options.restarts = restarts_so_far();
    if (under_mpi) {
        // Outlives the communicator, whose end waits for mpirun.
        std::optional<interrupt::Answering> soon;
        const auto comm = comm::make_mpi();
        // Before that, a signal is mpirun's to tell.
        handle_interrupts(comm->process() == 0);
        const int code = run_processes(options, *comm);
        soon.emplace(interrupt::Answer::Soon);
        return code;
    }
    handle_interrupts(true, supervised);
    if (options.processes == 1 && (supervised || !is_supervised(options))) {
        const auto comm = comm::make_single();
        return run_processes(options, *comm);
    }
    // Compiled before the processes start, so that a program's mistakes are reported once and soon.
    const Result<std::string> module = compile_program(options);
    if (!module) return tell(module.error());
    // Where there is one process, it is soon told by that; the world may be large.
    if (options.processes > 1)
        if (const auto world = choose_world(options); !world) return tell(world.error());
    return supervise(std::move(options), *module);
}

int bisect_command(RunOptions options) {
    if (!options.question || options.question->body.empty())
        return tell({"there is nothing to look for", "Give --until 'body' or --while 'body'"});
    return run_command(std::move(options));
}

int resume_command(const ResumeOptions& resume, const ParseRun& parse) {
    std::error_code error;
    const std::string folder = std::filesystem::absolute(resume.folder, error).lexically_normal().string();
    const Result<sim::Manifest> manifest = sim::newest_manifest(folder);
    if (!manifest) return tell(manifest.error());
    std::optional<RunOptions> options = parse(manifest->run.command);
    if (!options)
        return tell({fmt::format("the command of the run in {} is not one of this version of meldsim", resume.folder),
                     "Go on with it by the version that started it", ExitCode::RecordingRefused});
    // Paths in the command are as of then.
    std::filesystem::current_path(manifest->run.folder, error);
    if (error)
        return tell({fmt::format("the run in {} was started in the folder {}, which cannot be entered: {}", resume.folder,
                                 manifest->run.folder, error.message()),
                     "", ExitCode::RecordingRefused});
    options->checkpoint = options->resume = folder;
    options->command = manifest->run.command;
    if (resume.processes) options->processes = *resume.processes;
    if (resume.threads) options->threads = *resume.threads;
    if (resume.ticks) options->ticks = *resume.ticks;
    options->json = resume.json;
    options->quiet = resume.quiet;
    options->module = resume.module;
    options->arguments = resume_arguments(folder, *options);
    return run_command(std::move(*options));
}

}  // namespace meld::driver
