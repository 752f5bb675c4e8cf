#include "runtime/driver/session/view.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/report.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/run/run_configuration.h"
#include "runtime/driver/session/debug_state.h"
#include "runtime/driver/session/open_link.h"
#include "runtime/driver/session/session_run.h"
#include "runtime/driver/session/share.h"
#include "runtime/driver/session/view_world.h"
#include "runtime/driver/setup/option_groups.h"
#include "runtime/driver/setup/outputs.h"
#include "runtime/driver/setup/program_files.h"
#include "runtime/show/library/view_library.h"
#include "runtime/show/view/http.h"
#include "runtime/show/view/page/page.h"
#include "runtime/show/view/service.h"
#include "runtime/show/view/viewer.h"

namespace meld::driver {

namespace {

// So many facts are listed for a page.
constexpr std::uint64_t kMostLines = 1000;

// One of the runs that are shown, with all that stands behind it.
struct Shown {
    Drawings drawings = {};
    std::unique_ptr<sim::OpenCheckpoint> beginning = {};
    std::unique_ptr<timeline::Timeline> timeline = {};
    timeline::Timeline::Make make = {};
    std::optional<DebuggedRun> run = {};
    std::optional<WorldTab> world = {};
    std::unique_ptr<view::Viewer> viewer = {};
};

// What the user has named.
const std::string& name_of(const RunOptions& options) { return options.replay.empty() ? options.program : options.replay; }

Result<void> go_to(std::int64_t tick, timeline::Timeline& timeline) {
    if (tick < 0) return {};
    timeline.each([](sim::Simulation& simulation) {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
    });
    if (auto there = timeline.to(tick); !there) return there;
    if (timeline.ended() == sim::Ending::Interrupted)
        return fail(fmt::format("interrupted after tick {}", timeline.tick()), "", ExitCode::Interrupted);
    if (timeline.tick() == tick) return {};
    return fail(fmt::format("the run ends with tick {}, before tick {}", timeline.tick(), tick));
}

Result<void> begin(const RunOptions& options, Inputs& inputs, const std::vector<Claim>& claims, comm::Communicator& comm, Shown& shown) {
    Result<timeline::Timeline::Make> make = make_simulations(options, inputs, comm, &shown.drawings);
    if (!make) return tl::unexpected<Error>(make.error());
    Result<std::unique_ptr<sim::OpenCheckpoint>> beginning = open_beginning(options, claims, inputs.world, comm);
    if (!beginning) return tl::unexpected<Error>(beginning.error());
    shown.beginning = std::move(*beginning);
    const std::uint64_t history_bytes = parse_bytes(options.debug->history).value_or(0);
    Result<std::unique_ptr<timeline::Timeline>> started = start_timeline(options, inputs, *make, shown.beginning.get(), history_bytes);
    if (!started) return tl::unexpected<Error>(started.error());
    shown.timeline = std::move(*started);
    timeline::Timeline& timeline = *shown.timeline;
    make = begin_drawing(options, inputs, comm, timeline, std::move(*make), shown.drawings);
    if (!make) return tl::unexpected<Error>(make.error());
    shown.make = std::move(*make);
    shown.run.emplace(options, inputs, claims, comm);
    shown.world.emplace(options, inputs, [&shown] { return shown.viewer->seconds_per_evaluation(); });
    view::ViewerOptions how{
        .program = name_of(options),
        .world = inputs.world.path,
        .session = {.most_lines = kMostLines,
                    .folder = options.debug->folder,
                    .recorded = !options.replay.empty(),
                    .inputs = inputs_of(options, world_path(options)),
                    .host = {.reload = [&shown] { return shown.run->reload(*shown.timeline, shown.make); },
                             .save =
                                 [&shown](const std::string& folder, const std::string& events) {
                                     return shown.run->save(shown.timeline->simulation(), folder, events);
                                 }}},
        .drawing = [&shown]() -> record::Drawing& { return shown.drawings.of(*shown.timeline); },
        .world_file = [&shown] { return shown.world->file(); },
        .check_world = [&shown](const std::string& toml) { return shown.world->check(toml); },
        .save_world = [&shown](const std::string& path, const std::string& toml) { return shown.world->save(path, toml); }};
    if (!options.replay.empty()) how.last_tick = options.ticks;
    shown.viewer = std::make_unique<view::Viewer>(timeline, inputs.world, std::move(how));
    return go_to(options.debug->view->tick, timeline);
}

// The run beside the first one, on one process.
struct Beside {
    std::string module = {};
    std::optional<Inputs> inputs = {};
    std::vector<Claim> claimed = {};
    Shown shown = {};
};

Result<void> begin_beside(const RunOptions& options, comm::Communicator& comm, Beside& beside) {
    Result<std::string> module = compile_program(options);
    if (!module) return tl::unexpected<Error>(module.error());
    Result<Inputs> inputs = read_inputs(options, comm, *module);
    if (!inputs) return tl::unexpected<Error>(inputs.error());
    if (auto counted = count_catoms(options, comm, *inputs); !counted) return counted;
    beside.inputs.emplace(std::move(*inputs));
    beside.claimed = claims(options, beside.inputs->module, beside.inputs->world);
    return begin(options, *beside.inputs, beside.claimed, comm, beside.shown);
}

Result<void> announce(const view::Server& server, const RunOptions& options) {
    std::string names = visible(name_of(options));
    if (const auto& other = options.debug->view->beside) names += " beside " + visible(name_of(*other));
    const std::string text = options.json ? nlohmann::ordered_json{{"link", server.link()}, {"port", server.port()}}.dump() + "\n"
                                          : fmt::format("{} is shown at {}\n", names, server.link());
    if (auto printed = print(stdout, text); !printed) return printed;
    if (options.quiet || options.json) return {};
    return print(stdout, options.debug->view->seconds ? fmt::format("It ends after {}\n", format_duration(*options.debug->view->seconds))
                                                      : "Ctrl-C ends it\n");
}

}  // namespace

Result<int> view_run(const RunOptions& options, Inputs& inputs, const std::vector<Claim>& claims, comm::Communicator& comm) {
    const ViewOptions& asked = *options.debug->view;
    // A page to send is a file: nothing serves it, and it needs no more than the page.
    if (asked.share.file.empty() || view::viewer_page().empty())
        if (auto there = show::need_view(); !there) return tl::unexpected<Error>(there.error());
    // The first request ends what is being done between two ticks.
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    Shown shown;
    if (auto begun = begin(options, inputs, claims, comm, shown); !begun) return tl::unexpected<Error>(begun.error());

    if (!asked.share.file.empty())
        return share_run(options, inputs.world, comm, *shown.timeline,
                         [&]() -> record::Drawing& { return shown.drawings.of(*shown.timeline); });
    Beside beside;
    std::vector<view::Viewer*> viewers = {shown.viewer.get()};
    if (asked.beside) {
        if (auto begun = begin_beside(*asked.beside, comm, beside); !begun) return tl::unexpected<Error>(begun.error());
        viewers.push_back(beside.shown.viewer.get());
    }

    std::unique_ptr<view::Server> server;
    std::optional<OpenedLink> opened;
    const auto started = [&]() -> Result<void> {
        if (comm.process() != 0) return {};
        Result<std::unique_ptr<view::Server>> listening =
            view::Server::start({.port = asked.port, .page = std::string(view::viewer_page()), .framed = asked.framed});
        if (!listening) return tl::unexpected<Error>(listening.error());
        server = std::move(*listening);
        if (auto said = announce(*server, options); !said) return said;
        if (asked.opens && OpenedLink::can_open()) opened.emplace(server->link());
        return {};
    }();
    if (const auto all = comm::outcome_of_first(comm, started); !all) return tl::unexpected<Error>(all.error());

    view::ServiceOptions how{.seconds = asked.seconds};
    Pace pace(shown.timeline->simulation().summary());
    how.progress = [&](sim::Simulation& simulation) { return progress_line(simulation, pace, options.ticks); };
    ProgramFiles files;
    if (options.replay.empty() && options.program.ends_with(".meld"))
        how.program_changed = [&] { return files.changed(inputs.info(), options.program); };
    view::Service service(std::move(viewers), server.get(), comm, std::move(how));
    const bool interrupted = service.serve();
    return static_cast<int>(interrupted ? ExitCode::Interrupted : ExitCode::Fine);
}

std::vector<std::string> view_arguments(const ViewOptions& view) {
    std::vector<std::string> words = {"--port", std::to_string(view.port)};
    if (!view.opens) words.emplace_back("--no-open");
    if (view.framed) words.emplace_back("--framed");
    if (view.tick >= 0) words.insert(words.end(), {"--tick", std::to_string(view.tick)});
    if (view.seconds) words.insert(words.end(), {"--for", fmt::format("{}", *view.seconds)});
    add_share_arguments(view.share, words);
    return words;
}

void add_serving(CLI::App& command, ViewOptions& view, CLI::Option* of) {
    const std::string prefix = of == nullptr ? "" : fmt::format("Of {}: ", of->get_name());
    CLI::Option* const port = command.add_option("--port", view.port, prefix + "The port of the server; otherwise one that is free")
                                  ->check(cli::whole_number(1, 65535))
                                  ->type_name("INT");
    CLI::Option* const open = command.add_flag("!--no-open", view.opens, prefix + "Do not open the link in a browser");
    CLI::Option* const seconds = command.add_option("--for", view.seconds, prefix + "End after so many seconds; otherwise Ctrl-C ends it")
                                     ->check(cli::seconds())
                                     ->type_name("SECONDS");
    if (of == nullptr) return;
    for (CLI::Option* const each : {port, open, seconds}) each->needs(of);
}

void add_view(CLI::App& app, Asking& asking) {
    RunOptions& run = asking.run;
    run.debug = {.view = ViewOptions{}};
    ViewOptions& view = *run.debug->view;
    CLI::App* v = app.add_subcommand("view",
                                     "Show a run in a browser, and let it go on from there: step forward and back, colour catoms by what "
                                     "holds, ask why, give and take facts. A page is served on this machine alone, at a link that is "
                                     "printed.\nExample: meldsim view examples/meld/gradient.meld --for 2");
    asking.command = v;
    v->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    v->add_option("BESIDE", view.other, "Another program or recording, shown beside it");
    add_serving(*v, view);
    v->add_flag("--framed", view.framed, "Let pages of this machine, such as notebooks, show the page in a frame");
    v->add_option("--tick", view.tick, "Begin after this tick; otherwise before the first, or where the checkpoint is")
        ->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT");
    add_share(*v, view.share);
    add_inputs(*v, run, "The world, a .toml file; the default is the .toml next to the program, or else a cube of 1,000 catoms");
    add_ticks(*v, run.ticks, "The run has so many ticks");
    add_processes(*v, run.processes, run.threads);
    v->add_option("--history", run.debug->history, "Memory for snapshots, of each process; 0: every way back is from the start")
        ->type_name("BYTES")
        ->capture_default_str();
    v->add_flag("--json", run.json, "Print the link as JSON");
    v->add_flag("--quiet", run.quiet, "Print nothing but the link");
    v->add_option("--module", run.module)->group("");
    v->add_option("--scratch", asking.scratch)->group("");
    v->add_option("--folder", run.debug->folder)->group("");
}

}  // namespace meld::driver
