// Calls meldc, the only program that contains Clang.
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "runtime/driver/default_world.h"
#include "runtime/driver/inputs.h"
#include "runtime/driver/replay.h"
#include "runtime/driver/run.h"

namespace meld::driver {

namespace {

// meldc is beside meldsim, or else along PATH.
std::string meldc_path() {
    std::error_code error;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::filesystem::path beside = self.parent_path() / "meldc";
    return !error && std::filesystem::exists(beside, error) ? beside.string() : "meldc";
}

// Whether the program is to be compiled in the links form. Mistakes of the world are told when it is read as a whole.
bool asks_for_links(const RunOptions& options) {
    if (options.by_links) return true;
    if (!options.replay.empty()) {
        const Result<world::World> world = recorded_world(options.replay);
        return world && world->by_links;
    }
    const std::string path = world_path(options);
    return (!path.empty() && world::asks_for_links(path)) || std::ranges::any_of(options.events, world::asks_for_links);
}

// The other programs of the ensemble.
std::vector<std::string> other_programs(const RunOptions& options) {
    if (!options.replay.empty()) return options.programs;
    const std::string path = world_path(options);
    return path.empty() ? std::vector<std::string>() : world::programs_named(path);
}

// Whether no world is chosen, and the one of this program is a graph.
bool wants_graph(const RunOptions& options, const std::string& module_path) {
    if (!options.replay.empty() || !world_path(options).empty()) return false;
    const Result<Module> module = load_module(module_path, kAbiVersion);
    if (!module) return false;
    const Result<world::World> world = default_world(*static_cast<const ModuleInfo*>(module->table()));
    return world && world->by_links;
}

}  // namespace

Result<std::string> compile_program(const RunOptions& options, std::string* messages) {
    if (options.program.ends_with(".so")) return options.program;
    int ends[2];
    if (pipe(ends) != 0) return fail(std::string("cannot make a pipe: ") + std::strerror(errno));
    // A file, so that nobody waits for a reader of it.
    const int said = messages == nullptr ? -1 : memfd_create("messages", MFD_CLOEXEC);
    const std::string meldc = meldc_path();
    std::vector<const char*> arguments = {"meldc", "compile", options.program.c_str()};
    for (const std::string& file : options.link) arguments.insert(arguments.end(), {"--link", file.c_str()});
    for (const std::string& folder : options.library_paths) arguments.insert(arguments.end(), {"-I", folder.c_str()});
    const std::vector<std::string> others = other_programs(options);
    for (const std::string& file : others) arguments.insert(arguments.end(), {"--with", file.c_str()});
    const std::string level = std::to_string(options.optimisation.value_or(0));
    if (options.optimisation) arguments.insert(arguments.end(), {"-O", level.c_str()});
    const std::string seconds = fmt::format("{}", options.timeout_seconds);
    if (options.timeout_seconds > 0) arguments.insert(arguments.end(), {"--timeout", seconds.c_str()});
    if (asks_for_links(options)) arguments.push_back("--links");
    if (options.measured()) arguments.push_back(options.stats ? "--counters" : "--places");
    if (options.quiet || messages != nullptr) arguments.push_back("--quiet");
    arguments.push_back(nullptr);
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) return fail(std::string("cannot start meldc: ") + std::strerror(errno));
    if (child == 0) {
        // The child ends with this process, for whatever reason it ends.
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (getppid() != parent) _exit(127);
        dup2(ends[1], STDOUT_FILENO);
        if (said >= 0) dup2(said, STDERR_FILENO);
        close(ends[0]);
        close(ends[1]);
        execvp(meldc.c_str(), const_cast<char* const*>(arguments.data()));
        _exit(127);
    }
    close(ends[1]);
    std::string output;
    char buffer[4096];
    for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) != 0;) {
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) break;
        output.append(buffer, static_cast<std::size_t>(n));
    }
    close(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (said >= 0) {
        off_t at = 0;
        for (ssize_t n = 0; (n = pread(said, buffer, sizeof buffer, at)) > 0; at += n)
            messages->append(buffer, static_cast<std::size_t>(n));
        close(said);
    }
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : static_cast<int>(ExitCode::OurBug);
    if (code == 127) return fail("cannot start " + meldc, "Build it, or put it beside meldsim");
    // A Ctrl-C reaches the child too; any other signal that ends it is a bug of ours.
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGINT || WTERMSIG(status) == SIGTERM))
        return fail("interrupted", "", ExitCode::Interrupted);
    if (WIFSIGNALED(status))
        return fail(fmt::format("meldc was ended by signal {}", WTERMSIG(status)), "It may have needed more memory than there is",
                    ExitCode::OurBug);
    // meldc has printed the reason.
    if (code != 0) return fail("", "", static_cast<ExitCode>(code));
    while (!output.empty() && output.back() == '\n') output.pop_back();
    if (!asks_for_links(options) && wants_graph(options, output)) {
        RunOptions with = options;
        with.by_links = true;
        std::string again;
        return compile_program(with, messages != nullptr ? messages : &again);
    }
    return output;
}

}  // namespace meld::driver
