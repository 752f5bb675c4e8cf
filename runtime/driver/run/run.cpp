#include "runtime/driver/run/run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

#include "runtime/base/bytes.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/liveness.h"
#include "runtime/base/units.h"
#include "runtime/comm/launch/launch.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/checkpoints.h"
#include "runtime/driver/run/simulate.h"
#include "runtime/driver/run/supervise.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/outputs.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/world/description/measure.h"

namespace meld::driver {

namespace {

// In the table of the supervisor; returns whether that has started this process itself.
bool take_place(bool under_mpi) {
    const auto number = [&](const char* variable, int otherwise) {
        const char* const text = under_mpi ? std::getenv(variable) : nullptr;
        return text != nullptr ? std::atoi(text) : otherwise;
    };
    return liveness::attach(static_cast<std::size_t>(number("OMPI_COMM_WORLD_RANK", 0)), number("OMPI_COMM_WORLD_LOCAL_SIZE", 1));
}

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

// Processes that are far more than processors or catoms only wait for each other, and take the machine with them.
Result<void> check_processes(int processes, const world::World& world) {
    constexpr int kAlways = 64, kForEachProcessor = 16;
    const int processors = static_cast<int>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
    if (processes <= kAlways) return {};
    const Result<world::WorldSize> size = world.is_graph() ? world::WorldSize{} : world::measure(world);
    if (!size) return tl::unexpected<Error>(size.error());
    const double catoms =
        world.is_graph() ? static_cast<double>(world.graph->nodes()) : size->cells_estimate + static_cast<double>(world.placed.size());
    if (processes > catoms)
        return fail(fmt::format("-n: {} processes are more than the {} catoms of this world, and would only wait for each other", processes,
                                format_count(catoms)),
                    fmt::format("Write -n {}, or less", std::max(1, std::min(static_cast<int>(catoms), processors))));
    if (processes > std::max(kAlways, kForEachProcessor * processors))
        return fail(fmt::format("-n: {} processes are too many for this machine, which has {} processor{}", processes, processors,
                                processors == 1 ? "" : "s"),
                    fmt::format("Write -n {}, or start meldsim with mpirun on several machines", processors));
    return {};
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
    const int code = done ? *done : comm.process() == 0 ? print_error(done.error()) : static_cast<int>(done.error().code);
    if (!done) comm.barrier();
    return code == static_cast<int>(ExitCode::Interrupted) ? interrupt::exit_code() : code;
}

}  // namespace

int run_command(RunOptions options) {
    if (const auto distinct = check_outputs(options, world_path(options)); !distinct) return print_error(distinct.error());
    if (const auto every = parse_interval(options.checkpoint_every); !every) return print_error(every.error());
    if (const auto seconds = parse_heartbeat(options.heartbeat); !seconds) return print_error(seconds.error());
    const bool under_mpi = comm::under_mpi();
    const bool supervised = take_place(under_mpi) && !under_mpi;
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
    if (!module) return print_error(module.error());
    // Where there is one process, it is soon told by that; the world may be large.
    if (options.processes > 1) {
        const auto world = choose_world(options);
        if (!world) return print_error(world.error());
        if (const auto few = check_processes(options.processes, *world); !few) return print_error(few.error());
    }
    return supervise(std::move(options), *module);
}

int resume_command(const ResumeOptions& resume, const ParseRun& parse) {
    std::error_code error;
    const std::string folder = std::filesystem::absolute(resume.folder, error).lexically_normal().string();
    const Result<sim::Manifest> manifest = sim::newest_manifest(folder);
    if (!manifest) return print_error(manifest.error());
    std::optional<RunOptions> options = parse(manifest->run.command);
    if (!options)
        return print_error({fmt::format("the command of the run in {} is not one of this version of meldsim", resume.folder),
                            "Go on with it by the version that started it", ExitCode::RecordingRefused});
    // Paths in the command are as of then.
    std::filesystem::current_path(manifest->run.folder, error);
    if (error)
        return print_error({fmt::format("the run in {} was started in the folder {}, which cannot be entered: {}", resume.folder,
                                        manifest->run.folder, error.message()),
                            "", ExitCode::RecordingRefused});
    options->checkpoint = options->resume = folder;
    options->fork.clear();
    options->command = manifest->run.command;
    if (resume.processes) options->processes = *resume.processes;
    if (resume.threads) options->threads = *resume.threads;
    if (resume.ticks) options->ticks = *resume.ticks;
    if (resume.retries) options->retries = *resume.retries;
    if (resume.heartbeat) options->heartbeat = *resume.heartbeat;
    options->json = resume.json;
    options->quiet = resume.quiet;
    options->module = resume.module;
    options->arguments = resume_arguments(folder, *options);
    return run_command(std::move(*options));
}

}  // namespace meld::driver
