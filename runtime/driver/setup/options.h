// The options of `meldsim run`, and of the commands that run a program in another way.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace meld::driver {

// The facts of a body that was found to hold are followed so many steps, if nothing else is said.
inline constexpr std::size_t kWitnessDepth = 3;

// What `meldsim bisect` asks about a run.
struct Question {
    enum class Asks { Until, While } asks = Asks::Until;
    std::string body;       // In Meld.
    std::size_t depth = 0;  // The facts of the answer are followed so many steps; 0: they are not told.
};

// Why a run was started again, and where.
struct Restart {
    std::string reason;
    std::int64_t in_tick = 0;    // 0: before the first.
    std::int64_t from_tick = 0;  // 0: from the start.
};

// Of `meldsim query`, `facts`, `why` and their like: one command of a session, in one tick.
struct Inquiry {
    std::string command;                      // Its name.
    std::vector<std::string> words;           // What stands behind it.
    std::vector<std::string> flags = {};      // Those of the command itself, before the words.
    std::int64_t tick = -1;                   // -1: where the run ends, or where a checkpoint is.
    std::optional<std::uint64_t> limit = {};  // Rows or lines that are printed.
    bool csv = false;
    bool dot = false;
};

// Of `meldsim shot`. Ticks are numbers, or "end": where the run ends, or where a checkpoint is.
struct ShotOptions {
    std::vector<std::string> ticks = {};  // None: the end.
    int columns = 0;                      // Of a sheet with several ticks; 0: as they fit.
};

// A film of a run takes no longer, unless something else is said.
inline constexpr double kMovieSeconds = 10;

// Of `meldsim movie`.
struct MovieOptions {
    std::string from = {}, to = {};          // Ticks; otherwise the first and the last.
    std::optional<std::int64_t> every = {};  // Ticks from a frame to the next; otherwise as `seconds` needs it.
    double fps = 30;                         // Frames a second.
    std::optional<double> seconds = {};      // How long it takes, at most; otherwise kMovieSeconds, and of recorded steps all.
    double hold = 0;                         // Of these, how long the last tick stays.
    double turn = 0;                         // Degrees that the camera goes around.
    std::vector<std::string> keys = {};      // "TICK,AZIMUTH,ELEVATION,ZOOM"
};

// Of `meldsim export`.
struct ExportOptions {
    std::vector<std::string> ticks = {};  // As of `meldsim shot`.
};

// Of those that make a picture of a run: what is in it, and from where it is seen.
struct PictureOptions {
    std::string file = {};
    std::string size = "1280x720";  // In pixels.
    // Bodies, in Meld; runtime/show/picture/frame.h says what of.
    std::string colour = {}, only = {}, hide = {}, links = {}, arrows = {}, labels = {};
    std::vector<std::string> callouts = {};  // "@12", "@12=TEXT", or a body.
    std::string map = "viridis";
    std::string range = {};                              // "LOW:HIGH"
    std::string form = {};                               // Otherwise that of the lattice.
    std::optional<double> azimuth = {}, elevation = {};  // Degrees; otherwise from the side, and in the plane from above.
    std::optional<double> angle = {};
    double zoom = 1;
    std::optional<double> catom_size = {};  // As a part of what it is.
    std::string title = {};
    std::string background = "white";  // Or "transparent".
    bool ground = false, scale = false, bare = false, edges = false;
    int samples = 2;
    bool steps = false;  // The steps of a recording are painted as they are, and no run is made.
    std::variant<ShotOptions, MovieOptions, ExportOptions> of = ShotOptions{};
};

struct RunOptions;

// A run as a page of its own.
struct ShareOrder {
    std::string file = {};
    // Bodies, in Meld; runtime/show/picture/frame.h says what of.
    std::string colour = {}, only = {}, hide = {}, links = {}, arrows = {}, labels = {};
    std::string map = "viridis";
    bool exposed = false;
    std::string form = {};
    std::vector<std::string> facts = {};  // Predicates, or "all".
    std::int64_t every = 1;               // Ticks between two frames.
    std::uint64_t limit_mb = 64;
};

// Of `meldsim view`.
struct ViewOptions {
    ShareOrder share = {};                          // Without a file: none.
    std::string other = {};                         // Another program or recording, as it was named.
    std::shared_ptr<const RunOptions> beside = {};  // The run of that.
    int port = 0;                                   // 0: one that is free.
    bool opens = true;                              // In a browser, if there is a screen.
    bool framed = false;                            // Pages of this machine, such as notebooks, may show it within them.
    std::int64_t tick = -1;                         // -1: before the first, or where a checkpoint is.
    std::optional<double> seconds = {};             // It ends by itself after so long.
};

// Of `meldsim world`.
struct WorldOptions {
    std::string file = {};
    std::vector<std::string> extensions = {};
    std::string links = {}, nodes = {};                  // Files for those of its graph.
    std::string import = {}, lattice = {}, output = {};  // A configuration of VisibleSim, its lattice, and the world to be written.
    PictureOptions picture = {};                         // Of the start; without a file there is none.
};

// Of `meldsim debug`: how the run is walked through.
struct DebugOptions {
    std::string history = "1GiB";                // Memory for snapshots, of each process.
    std::string folder = {};                     // Where paths in commands begin; empty: where the process is.
    std::string commands = {};                   // A file with commands; empty: standard input.
    bool typed = false;                          // They are typed at a terminal, here or where the processes were started.
    bool shown = false;                          // Answers are shown on one.
    bool served = false;                         // Commands come from another program, which takes answers as JSON with their text.
    std::optional<Inquiry> inquiry = {};         // Instead of commands that somebody gives.
    std::optional<PictureOptions> picture = {};  // Of an inquiry that makes one.
    std::optional<ViewOptions> view = {};        // Instead: it is shown in a browser.
    // Modules that wrote in the run of the checkpoint: the session writes nothing, but finds what they have kept.
    std::vector<std::string> writers = {};
};

struct RunOptions {
    std::string program = {};                     // A .meld file, or a compiled .so.
    std::string world = {};                       // Empty: PROGRAM.toml if it exists, otherwise a cube of 1,000 catoms.
    std::vector<std::string> library_paths = {};  // For the program's includes and libraries.
    std::int64_t ticks = -1;
    int processes = 1;
    int threads = 1;
    std::int64_t seed = -1;
    std::string ports = {};                    // Whose numbers ports have; empty: as the world says.
    std::vector<std::string> set = {};         // name=value
    std::vector<std::string> limits = {};      // name=value, after those of the world.
    std::vector<std::string> link = {};        // C files with extern functions.
    std::optional<int> optimisation = {};      // Of the module, 0 to 3; otherwise meldc decides.
    std::vector<std::string> given = {};       // Values of @arg1, @arg2, ...
    std::vector<std::string> events = {};      // Files with [[event]] tables, after those of the world.
    std::vector<std::string> extensions = {};  // Shared objects that add implementations of components.
    std::string facts_out = {};
    std::string record = {};
    std::string digest = {};                 // A file, or "-" for standard output.
    std::int64_t digest_check = 0;           // In every so many ticks; 0: never.
    std::string checkpoint = {};             // A folder.
    std::string checkpoint_every = "10min";  // Or "1000ticks".
    bool checkpoint_changes = false;         // Between whole ones, they hold what has changed.
    int retries = 3;                         // After a process was killed or has crashed.
    std::string heartbeat = "10min";         // The longest time without a sign of life, or "off".
    std::string resume = {};                 // The folder whose newest checkpoint the run goes on from.
    std::string fork = {};                   // The folder from whose newest checkpoint the run branches off.
    std::vector<std::string> watch = {};     // Bodies that stop the run, or files of rules that say what is watched.
    std::vector<std::string> expect = {};    // Bodies that must hold at its end.
    std::vector<std::string> never = {};     // Bodies that may hold in no tick.
    std::string junit = {};                  // A file for how it went with each.
    bool sync = false;                       // Files survive a stop of the machine.
    double timeout_seconds = 0;              // Of compilation and run, each; 0: none.
    std::string balance = "auto";            // When the ensemble is divided anew: also "never", or "100ticks".
    std::string replay = {};                 // The recording whose run is made again.
    std::vector<std::string> programs = {};  // Of that run, after the first; otherwise the world names them.
    std::optional<Question> question = {};   // The run goes on until it is answered, and writes nothing else.
    std::optional<DebugOptions> debug = {};  // Somebody walks through the run, and it writes nothing.
    std::string module = {};                 // Passed to the processes by the command that started them.
    bool strict = false;
    bool by_links = false;     // Neighbours are found in a table, although the world does not ask for it.
    bool stats = false;        // What the run did in detail is counted, and part of the summary.
    std::string profile = {};  // A file for where the time went, and for what is counted.
    bool places = false;       // The module says which rule runs, though there is no profile: this run goes on as one that had.
    bool measured() const { return stats || places || !profile.empty(); }
    bool json = false;
    bool quiet = false;
    std::vector<Restart> restarts = {};       // Of this run so far.
    std::vector<std::string> command = {};    // As typed where the run began, for the recording and for checkpoints.
    std::vector<std::string> arguments = {};  // Of the processes: of this command, which may go on with that run.
};

// The files that a run writes. Whatever runs a program in another way names each of them anew, or leaves it out.
struct OutputOption {
    const char* name;
    std::string RunOptions::* path;
};
inline constexpr std::array<OutputOption, 5> kOutputs = {{{"--facts-out", &RunOptions::facts_out},
                                                          {"--digest", &RunOptions::digest},
                                                          {"--record", &RunOptions::record},
                                                          {"--profile", &RunOptions::profile},
                                                          {"--junit", &RunOptions::junit}}};

// What a run is watched for.
struct BodiesOption {
    const char* name;
    std::vector<std::string> RunOptions::* bodies;
};
inline constexpr std::array<BodiesOption, 3> kWatches = {
    {{"--watch", &RunOptions::watch}, {"--expect", &RunOptions::expect}, {"--never", &RunOptions::never}}};

// Reads a command line of `meldsim run`, as a checkpoint has it; nothing if it is none.
using ParseRun = std::function<std::optional<RunOptions>(const std::vector<std::string>&)>;

// Of `meldsim resume`: what the run is to do otherwise than its command says.
struct ResumeOptions {
    std::string folder = {};
    std::optional<int> processes = {}, threads = {};
    std::optional<std::int64_t> ticks = {};
    std::optional<int> retries = {};
    std::optional<std::string> heartbeat = {};
    std::string module = {};
    bool json = false;
    bool quiet = false;
};

}  // namespace meld::driver
