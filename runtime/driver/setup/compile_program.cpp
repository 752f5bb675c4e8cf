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

#include "runtime/driver/run/replay.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/setup/default_world.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

// meldc is beside meldsim, or else along PATH.
std::string meldc_path() {
    std::error_code error;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::filesystem::path beside = self.parent_path() / "meldc";
    return !error && std::filesystem::exists(beside, error) ? beside.string() : "meldc";
}

// How the program is to be compiled. Without a world it is not known beforehand whether the links of the program make a graph.
enum class Form { Cells, Links, Graph, Undecided };

// Of a program whose world says where catoms are, or else how they find their neighbours if its links make no graph.
struct Wanted {
    Form form;
    Form without_graph = Form::Cells;
};

// Mistakes of the world are told when it is read as a whole.
Wanted form_of(const RunOptions& options) {
    if (!options.replay.empty()) {
        const Result<world::World> world = recorded_world(options.replay);
        if (world && world->is_graph()) return {Form::Graph};
        return {options.by_links || (world && world->by_links) ? Form::Links : Form::Cells};
    }
    const std::string path = world_path(options);
    if (!path.empty() && world::asks_for_graph(path)) return {Form::Graph};
    const bool places = !path.empty() && world::says_places(path);
    if (options.by_links || (!path.empty() && world::asks_for_links(path)) || std::ranges::any_of(options.events, world::asks_for_links)) {
        if (path.empty() || places) return {Form::Links};
        return {Form::Undecided, Form::Links};
    }
    return {places ? Form::Cells : Form::Undecided};
}

const char* flag_of(Form form) {
    switch (form) {
        case Form::Cells:
            return "--no-graph";
        case Form::Links:
            return "--links";
        case Form::Graph:
            return "--graph";
        case Form::Undecided:
            return nullptr;
    }
    return nullptr;
}

// The lattice and whose numbers its ports have: a program may name the sides of another robot's modules.
world::PortKeys ports_of(const RunOptions& options) {
    world::PortKeys keys;
    if (!options.replay.empty()) {
        if (const Result<world::World> world = recorded_world(options.replay))
            keys = {std::string(world->lattice_name()), std::string(world->ports_name())};
    } else {
        keys = world::port_keys(world_path(options));
    }
    if (!options.ports.empty()) keys.ports = options.ports;
    return keys;
}

// The other programs of the ensemble.
std::vector<std::string> other_programs(const RunOptions& options) {
    if (!options.replay.empty()) return options.programs;
    const std::string path = world_path(options);
    return path.empty() ? std::vector<std::string>() : world::programs_named(path);
}

// The form of a program without a world, once it has been compiled in one of both: that of its world, which may be the graph of its links.
Form form_without_world(const std::string& module_path, Form without_graph) {
    const Result<Module> module = load_module(module_path, kAbiVersion);
    if (!module) return Form::Undecided;
    const auto& info = *static_cast<const ModuleInfo*>(module->table());
    const Result<world::World> world = default_world(info);
    const bool graph = world && world->is_graph();
    if (graph == info.by_links && (graph || without_graph == Form::Cells)) return Form::Undecided;
    return graph ? Form::Graph : without_graph;
}

Result<std::string> compile_in(Wanted wanted, const RunOptions& options, std::string* messages);

}  // namespace

Result<std::string> compile_program(const RunOptions& options, std::string* messages) {
    if (options.program.ends_with(".so")) return options.program;
    return compile_in(form_of(options), options, messages);
}

namespace {

Result<std::string> compile_in(Wanted wanted, const RunOptions& options, std::string* messages) {
    const Form form = wanted.form;
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
    if (const char* flag = flag_of(form)) arguments.push_back(flag);
    if (const std::string world = world_path(options); form == Form::Graph && !world.empty() && world::says_acyclic(world))
        arguments.push_back("--acyclic");
    const world::PortKeys ports = ports_of(options);
    arguments.insert(arguments.end(), {"--lattice", ports.lattice.c_str(), "--ports", ports.ports.c_str()});
    if (form == Form::Links) arguments.push_back("--no-graph");
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
    if (form != Form::Undecided) return output;
    const Form found = form_without_world(output, wanted.without_graph);
    if (found == Form::Undecided) return output;
    // The messages have been printed; only a program for graphs whose world is none has others.
    std::string again;
    return compile_in({found}, options, messages != nullptr || found == Form::Cells ? messages : &again);
}

}  // namespace

}  // namespace meld::driver
