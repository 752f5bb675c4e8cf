// The options of `meldsim run`, and of the commands that run a program in another way.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace meld::driver {

// What `meldsim bisect` asks about a run.
struct Question {
    enum class Asks { Until, While } asks = Asks::Until;
    std::string body;  // In Meld.
};

// Why a run was started again, and where.
struct Restart {
    std::string reason;
    std::int64_t in_tick = 0;    // 0: before the first.
    std::int64_t from_tick = 0;  // 0: from the start.
};

// Of `meldsim debug`: how the run is walked through.
struct DebugOptions {
    std::string history = "1GiB";  // Memory for snapshots, of each process.
    std::string commands = {};     // A file with commands; empty: standard input.
    bool typed = false;            // They are typed at a terminal, here or where the processes were started.
    bool shown = false;            // Answers are shown on one.
};

struct RunOptions {
    std::string program = {};                     // A .meld file, or a compiled .so.
    std::string world = {};                       // Empty: PROGRAM.toml if it exists, otherwise a cube of 1,000 catoms.
    std::vector<std::string> library_paths = {};  // For the program's includes and libraries.
    std::int64_t ticks = -1;
    int processes = 1;
    int threads = 1;
    std::int64_t seed = -1;
    std::vector<std::string> set = {};         // name=value
    std::vector<std::string> link = {};        // C files with extern functions.
    std::optional<int> optimisation = {};      // Of the module, 0 to 3; otherwise meldc decides.
    std::vector<std::string> given = {};       // Values of @arg1, @arg2, ...
    std::vector<std::string> extensions = {};  // Shared objects that add implementations of components.
    std::string facts_out = {};
    std::string record = {};
    std::string digest = {};                 // A file, or "-" for standard output.
    std::string checkpoint = {};             // A folder.
    std::string checkpoint_every = "10min";  // Or "1000ticks".
    int retries = 3;                         // After a process was killed or has crashed.
    std::string heartbeat = "10min";         // The longest time without a sign of life, or "off".
    std::string resume = {};                 // The folder whose newest checkpoint the run goes on from.
    std::string fork = {};                   // The folder from whose newest checkpoint the run branches off.
    bool sync = false;                       // Files survive a stop of the machine.
    double timeout_seconds = 0;              // Of compilation and run, each; 0: none.
    std::string replay = {};                 // The recording whose run is made again.
    std::optional<Question> question = {};   // The run goes on until it is answered, and writes nothing else.
    std::optional<DebugOptions> debug = {};  // Somebody walks through the run, and it writes nothing.
    std::string module = {};                 // Passed to the processes by the command that started them.
    bool strict = false;
    bool json = false;
    bool quiet = false;
    std::vector<Restart> restarts = {};       // Of this run so far.
    std::vector<std::string> command = {};    // As typed where the run began, for the recording and for checkpoints.
    std::vector<std::string> arguments = {};  // Of the processes: of this command, which may go on with that run.
};

// Reads a command line of `meldsim run`, as a checkpoint has it; nothing if it is none.
using ParseRun = std::function<std::optional<RunOptions>(const std::vector<std::string>&)>;

// Of `meldsim resume`: what the run is to do otherwise than its command says.
struct ResumeOptions {
    std::string folder = {};
    std::optional<int> processes = {}, threads = {};
    std::optional<std::int64_t> ticks = {};
    std::string module = {};
    bool json = false;
    bool quiet = false;
};

}  // namespace meld::driver
