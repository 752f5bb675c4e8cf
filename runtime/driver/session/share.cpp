#include "runtime/driver/session/share.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/units.h"
#include "runtime/cli/command_line.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/show/view/looks.h"
#include "runtime/show/view/share/share.h"

namespace meld::driver {

namespace {

constexpr std::tuple<const char*, std::string ShareOrder::*, const char*> kBodies[] = {
    {"--colour", &ShareOrder::colour, "With --share: colour catoms by what this body in Meld says"},
    {"--only", &ShareOrder::only, "With --share: show only the catoms for which this holds"},
    {"--hide", &ShareOrder::hide, "With --share: do not show the catoms for which this holds"},
    {"--links", &ShareOrder::links, "With --share: draw lines between the catoms of this body"},
    {"--arrows", &ShareOrder::arrows, "With --share: draw arrows between the catoms of this body"},
    {"--labels", &ShareOrder::labels, "With --share: write the value of this body at its catoms"},
};

Result<picture::Look> look_of(const ShareOrder& order) {
    return view::look_of({{"colour", order.colour},
                          {"only", order.only},
                          {"hide", order.hide},
                          {"links", order.links},
                          {"arrows", order.arrows},
                          {"labels", order.labels},
                          {"map", order.map},
                          {"exposed", order.exposed},
                          {"form", order.form}});
}

}  // namespace

void add_share(CLI::App& app, ShareOrder& order) {
    CLI::Option* const file =
        app.add_option("--share", order.file, "Serve nothing: write the run to this file, as a page that needs no server")
            ->type_name("FILE");
    // Nothing is served, and nobody waits.
    for (const char* served : {"--port", "--no-open", "--framed", "--for", "BESIDE"}) file->excludes(app.get_option(served));
    for (const auto& [name, body, help] : kBodies) app.add_option(name, order.*body, help)->type_name("BODY")->needs(file);
    app.add_option("--map", order.map, "With --share: colours of numbers: viridis, cividis, magma, coolwarm, grey")
        ->type_name("NAME")
        ->capture_default_str()
        ->needs(file);
    app.add_option("--form", order.form, "With --share: draw sphere, cube, rounded, disc or hexagon")->type_name("NAME")->needs(file);
    app.add_flag("--exposed", order.exposed, "With --share: only catoms with a free cell beside them")->needs(file);
    app.add_option("--facts", order.facts, "With --share: predicates whose facts a click shows, or all")
        ->delimiter(',')
        ->type_name("NAMES")
        ->needs(file);
    app.add_option("--every", order.every, "With --share: a frame every so many ticks")
        ->check(cli::whole_number(1, std::numeric_limits<std::int64_t>::max() - 1))
        ->type_name("INT")
        ->capture_default_str()
        ->needs(file);
    app.add_option("--limit", order.limit_mb, "With --share: the page has at most so many MB")
        ->check(cli::whole_number(1, 2000))
        ->type_name("MB")
        ->capture_default_str()
        ->needs(file);
}

void add_share_arguments(const ShareOrder& order, std::vector<std::string>& words) {
    if (order.file.empty()) return;
    words.insert(words.end(), {"--share", order.file, "--map", order.map, "--every", std::to_string(order.every), "--limit",
                               std::to_string(order.limit_mb)});
    for (const auto& [name, body, help] : kBodies)
        if (!(order.*body).empty()) words.insert(words.end(), {name, order.*body});
    if (order.exposed) words.emplace_back("--exposed");
    if (!order.form.empty()) words.insert(words.end(), {"--form", order.form});
    for (const std::string& name : order.facts) words.insert(words.end(), {"--facts", name});
}

Result<int> share_run(const RunOptions& options, const world::World& world, comm::Communicator& comm, timeline::Timeline& timeline,
                      const std::function<record::Drawing&()>& drawing) {
    const ShareOrder& order = options.debug->view->share;
    Result<picture::Look> look = look_of(order);
    if (!look) return tl::unexpected<Error>(look.error());
    timeline.each([](sim::Simulation& simulation) {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
    });
    const std::string& target = options.replay.empty() ? options.program : options.replay;
    // Paths are as of where the command was given.
    const bool as_it_is = order.file == "-" || options.debug->folder.empty();
    const auto shared =
        view::write_share(timeline, world, drawing,
                          {.file = as_it_is ? order.file : (std::filesystem::path(options.debug->folder) / order.file).string(),
                           .title = std::filesystem::path(target).filename().string(),
                           .look = std::move(*look),
                           .facts = order.facts,
                           .last = options.ticks,
                           .every = order.every,
                           .most_bytes = order.limit_mb * 1'000'000});
    if (!shared) return tl::unexpected<Error>(shared.error());
    Result<void> said;
    if (comm.process() == 0 && !options.quiet)
        said = print(order.file == "-" ? stderr : stdout,
                     options.json ? nlohmann::ordered_json{{"file", order.file},
                                                           {"frames", shared->frames},
                                                           {"first", shared->first},
                                                           {"last", shared->last},
                                                           {"catoms", shared->catoms},
                                                           {"bytes", shared->bytes}}
                                            .dump() +
                                        "\n"
                                  : fmt::format("{}: {} frame{} of ticks {} to {}, {} catoms, {:.1f} MB\n", order.file,
                                                grouped(shared->frames), shared->frames == 1 ? "" : "s", shared->first, shared->last,
                                                grouped(shared->catoms), 1e-6 * static_cast<double>(shared->bytes)));
    if (const auto all = comm::outcome_of_first(comm, said); !all) return tl::unexpected<Error>(all.error());
    return static_cast<int>(ExitCode::Fine);
}

}  // namespace meld::driver
