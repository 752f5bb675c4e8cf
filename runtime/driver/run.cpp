#include "runtime/driver/run.h"

#include <fmt/format.h>

#include <unistd.h>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "runtime/base/bytes.h"
#include "runtime/base/log.h"
#include "runtime/base/progress.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/visible.h"
#include "runtime/comm/communicator.h"
#include "runtime/comm/launch.h"
#include "runtime/comm/outcome.h"
#include "runtime/driver/extension_file.h"
#include "runtime/driver/memory_check.h"
#include "runtime/driver/outputs.h"
#include "runtime/driver/report.h"
#include "runtime/module/module.h"
#include "runtime/record/digest_file.h"
#include "runtime/record/facts_file.h"
#include "runtime/record/recorder.h"
#include "runtime/sim/simulation.h"
#include "runtime/sim/watchers/printer.h"
#include "runtime/sim/watchers/watcher.h"

namespace meld::driver {

namespace {

volatile std::sig_atomic_t interrupts = 0;

// The first asks for the end at a tick boundary, the second ends at once.
void on_interrupt(int) {
    interrupts = interrupts + 1;
    if (interrupts > 1) _exit(static_cast<int>(ExitCode::Interrupted));
}

void handle_interrupts() {
    struct sigaction action{};
    action.sa_handler = on_interrupt;
    for (const int signal : {SIGINT, SIGTERM, comm::kEndWellSignal}) sigaction(signal, &action, nullptr);
}

int tell(const Error& error) {
    clear_progress();
    if (!error.problem.empty()) static_cast<void>(print(stderr, fmt::format("meldsim: {}\n", visible(error.message()))));
    return static_cast<int>(error.code);
}

// Empty if there is none.
std::string world_path(const RunOptions& options) {
    if (!options.world.empty()) return options.world;
    const std::string beside = std::filesystem::path(options.program).replace_extension(".toml").string();
    std::error_code error;
    return std::filesystem::exists(beside, error) ? beside : "";
}

Result<world::World> choose_world(const RunOptions& options) {
    const std::string path = world_path(options);
    Result<world::World> world = path.empty() ? world::parse_world("lattice = \"cubic\"\n[[body]]\nshape = \"box(10, 10, 10)\"\n",
                                                                   "the default, a cube of 1,000 catoms")
                                              : world::read_world(path);
    if (!world) return world;
    if (options.seed >= 0) world->seed = static_cast<std::uint64_t>(options.seed);
    if (options.given.size() > 9)
        return fail(fmt::format("there are {} --arg, and a program has no more than nine: @arg1 to @arg9", options.given.size()));
    for (std::size_t i = 0; i < options.given.size(); ++i) world->set[fmt::format("arg{}", i + 1)] = options.given[i];
    for (const std::string& setting : options.set) {
        const std::size_t equals = setting.find('=');
        if (equals == std::string::npos || equals == 0) return fail("--set " + setting + " sets nothing", "Write --set name=value");
        world->set[setting.substr(0, equals)] = setting.substr(equals + 1);
    }
    return world;
}


// All processes must run the same module on the same world.
bool same_everywhere(comm::Communicator& comm, std::uint64_t hash) {
    ByteWriter bytes;
    bytes.write(hash);
    const std::vector<std::byte> all = comm.allgather(bytes.view());
    ByteReader in(all, "the hashes of all processes");
    for (int p = 0; p < comm.processes(); ++p)
        if (in.read<std::uint64_t>() != hash) return false;
    return true;
}

int processes_on_this_machine(const comm::Communicator& comm) {
    const char* local = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
    return local != nullptr ? std::max(1, std::atoi(local)) : comm.processes();
}

OutputFile* pointer_to(std::optional<OutputFile>& file) { return file ? &*file : nullptr; }

// The facts of the last tick that went well, if they are still there, and what there is to say. On every process.
Error after_failure(sim::Subdomain& subdomain, const RunOptions& options, Outputs& outputs, Error error) {
    if (options.facts_out.empty()) return error;
    if (subdomain.status().half_way()) {
        error.suggestion += fmt::format("{}No facts are written, since tick {} ended in the middle of changing them",
                                        error.suggestion.empty() ? "" : ".\n", subdomain.status().last_tick() + 1);
    } else if (const auto written = record::write_facts(subdomain, pointer_to(outputs.facts)); !written) {
        error.suggestion +=
            fmt::format("{}The facts are not written: {}", error.suggestion.empty() ? "" : ".\n", written.error().message());
    }
    return error;
}

// Everything after the processes stand. Errors every process meets alike are told by process 0 alone.
Result<int> simulate(const RunOptions& options, comm::Communicator& comm, const std::string& module_path) {
    const Result<Module> module = load_module(module_path, kAbiVersion);
    if (!module) return tl::unexpected<Error>(module.error());
    const ModuleInfo& info = *static_cast<const ModuleInfo*>(module->table());
    if (info.schema_hash != module->note().schema_hash)
        return fail(module_path + " says of itself what is not so", "Compile it again", ExitCode::ModuleRefused);
    if (!same_everywhere(comm, info.schema_hash))
        return fail("the processes have different modules", "Use a cache that all of them see", ExitCode::ModuleRefused);
    const Result<world::World> world = choose_world(options);
    if (!world) return tl::unexpected<Error>(world.error());
    if (const auto fits = check_memory(*world, info, comm.processes(), processes_on_this_machine(comm)); !fits)
        return tl::unexpected<Error>(fits.error());
    const Result<world::Target> target = world::Target::make(*world, world::Lattice(world->lattice));
    if (!target) return tl::unexpected<Error>(target.error());
    Outputs outputs;
    const Result<void> opened = comm.process() == 0 ? open_outputs(options, outputs) : Result<void>{};
    if (const auto all = comm::outcome_of_first(comm, opened); !all) return tl::unexpected<Error>(all.error());

    sim::Simulation simulation(info, *world, *target, comm, options.threads);
    const bool speaks = comm.process() == 0;
    if (!options.record.empty()) {
        const record::RecordingInfo about{.program = info.program_text,
                                          .world = world->text,
                                          .seed = world->seed,
                                          .arguments = options.arguments,
                                          .lattice = std::string(world::Lattice(world->lattice).name()),
                                          .radius = world->radius,
                                          .durability = options.sync ? Durability::Machine : Durability::Process};
        simulation.add(std::make_unique<record::Recorder>(options.record, world->record.every, world->record.predicates, about));
    }
    // What catoms print and the table go to standard output, unless results are written there.
    std::FILE* const talk = results_at_standard_output(options) ? stderr : stdout;
    simulation.add(std::make_unique<sim::Printer>(talk));
    simulation.add(std::make_unique<sim::Watcher>(talk));
    if (!options.digest.empty()) simulation.add(std::make_unique<record::DigestFile>(std::move(outputs.digest)));
    sim::Registry registry = sim::Registry::standard();
    if (auto done = add_extensions(options.extensions, registry); !done) return tl::unexpected<Error>(done.error());
    if (auto done = simulation.start(registry); !done) return tl::unexpected<Error>(done.error());

    std::optional<Progress> progress;
    if (speaks && !options.quiet) progress.emplace();
    const auto begin = std::chrono::steady_clock::now();
    const auto each = [&] {
        if (interrupts > 0) simulation.subdomain().request_stop();
        if (!progress) return;
        progress->update([&] {
            return progress_line(simulation, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
                                 options.ticks);
        });
    };
    const Result<void> ran = simulation.run({options.ticks, options.strict}, each);
    progress.reset();
    if (!ran) return tl::unexpected<Error>(after_failure(simulation.subdomain(), options, outputs, ran.error()));
    if (!options.facts_out.empty())
        if (auto written = record::write_facts(simulation.subdomain(), pointer_to(outputs.facts)); !written)
            return tl::unexpected<Error>(written.error());
    // Also with --quiet: facts are missing.
    if (const std::string dropped = warning_of_dropped(simulation.summary()); speaks && !dropped.empty()) log::warning("{}", dropped);
    if (speaks && !simulation.summary().undefined.empty())
        log::warning("the run ended before the facts settled, and {}", simulation.summary().undefined);
    if (speaks && options.json)
    Result<void> printed;
    if (speaks && options.json)
        printed = print(stdout, summary_json(simulation.summary(), world->path, comm.processes(), options.threads));
    else if (speaks && !options.quiet)
        printed = print(talk, summary_table(simulation.summary(), world->path, comm.processes(), options.threads));
    if (!printed) return tl::unexpected<Error>(printed.error());
    return simulation.summary().ending == sim::Ending::Interrupted ? static_cast<int>(ExitCode::Interrupted) : 0;
}

// Process 0 compiles and tells the others where the module is.
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
    if (done) return *done;
    return comm.process() == 0 ? tell(done.error()) : static_cast<int>(done.error().code);
}

}  // namespace

int run_command(RunOptions options) {
    if (const auto distinct = check_outputs(options, world_path(options)); !distinct) return tell(distinct.error());
    if (comm::under_mpi()) {
        handle_interrupts();
        const auto comm = comm::make_mpi();
        return run_processes(options, *comm);
    }
    if (options.processes == 1) {
        handle_interrupts();
        const auto comm = comm::make_single();
        return run_processes(options, *comm);
    }
    // Compiled before the processes start, so that a program's mistakes are told once and soon.
    const Result<std::string> module = compile_program(options);
    if (!module) return tell(module.error());
    if (const auto world = choose_world(options); !world) return tell(world.error());
    std::vector<std::string> command{std::filesystem::read_symlink("/proc/self/exe").string()};
    command.insert(command.end(), options.arguments.begin() + 1, options.arguments.end());
    command.insert(command.end(), {"--module", *module});
    const comm::LaunchOutcome outcome = comm::launch_mpi(options.processes, command);
    // Whatever else came of the run, its results have not reached their reader.
    if (outcome.output_error != 0) return tell(cannot_write("standard output", outcome.output_error));
    if (const std::string why = comm::describe_launch_failure(outcome.exit_code); !why.empty())
        return tell({why, "", static_cast<ExitCode>(outcome.exit_code)});
    return outcome.exit_code;
}

}  // namespace meld::driver
