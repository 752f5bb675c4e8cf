#include "runtime/show/view/viewer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <span>
#include <variant>

#include "runtime/ask/debug/command.h"
#include "runtime/ask/debug/listing.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/picture/sheet.h"
#include "runtime/show/render/image.h"
#include "runtime/show/view/looks.h"
#include "runtime/show/view/scene/block.h"
#include "runtime/sim/ending_name.h"

namespace meld::view {

namespace {

constexpr std::int64_t kMostTick = std::numeric_limits<std::int64_t>::max() - 1;
constexpr double kLeastPixels = 16, kMostPixels = 2000;  // Along each side of a picture.
constexpr std::int64_t kMostPoints = 100'000;
// Catoms in a frame, unless the page asks for more or fewer: what software draws in a second, and what memory holds.
constexpr std::int64_t kMostSent = 300'000, kMostPerFrame = 20'000'000;
constexpr const char* kVerbs =
    "There are hello, frame, image, command, play, pause, metrics, series, world, world-check, world-save and interrupt";

// What every request may have besides its own keys.
Fields fields_of(const Json& request) {
    Fields fields(request, "the request");
    for (const char* key : {"id", "do", "run"}) fields.known(key);
    return fields;
}

// Pages write files where the viewer was started, and nowhere else.
Result<void> stays_in_folder(const std::string& path) {
    const std::filesystem::path asked(path);
    const bool leaves = asked.is_absolute() || std::ranges::any_of(asked, [](const auto& part) { return part == ".."; });
    if (!leaves) return {};
    return fail(fmt::format("'{}' leads out of the folder where the viewer was started", path), "Give a name in that folder");
}

Result<void> may_write(const debug::Command& command) {
    if (const auto* save = std::get_if<debug::Save>(&command)) return stays_in_folder(save->folder);
    if (const auto* save = std::get_if<debug::SaveEvents>(&command)) return stays_in_folder(save->path);
    return {};
}

// Whether later ticks may not be what they were.
bool changes_what_comes(const debug::Command& command) {
    return std::holds_alternative<debug::Change>(command) || std::holds_alternative<debug::Kill>(command) ||
           std::holds_alternative<debug::StrikeLinks>(command) || std::holds_alternative<debug::Switch>(command);
}

}  // namespace

Viewer::Viewer(timeline::Timeline& timeline, world::World& world, ViewerOptions options)
    : timeline_(timeline),
      world_(world),
      options_(std::move(options)),
      session_(timeline, world, options_.session),
      latest_(timeline.tick()) {
    timeline_.each_new([this](sim::Simulation& simulation) -> Result<void> {
        if (simulation.subdomain().comm.process() == 0) metrics_.note(simulation);
        series_.forget_from(simulation.subdomain().tick());
        seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
        evaluations_ += simulation.subdomain().totals.tick.awake;
        return {};
    });
}

std::optional<double> Viewer::seconds_per_evaluation() const {
    if (evaluations_ == 0) return std::nullopt;
    return seconds_ / static_cast<double>(evaluations_);
}

Viewer::~Viewer() { timeline_.each_new({}); }

Result<Reply> Viewer::answer(const Json& request) {
    const auto verb_at = request.find("do");
    const std::string verb = verb_at != request.end() && verb_at->is_string() ? verb_at->get<std::string>() : "";
    if (verb == "hello") return hello();
    if (verb == "frame") return frame(request);
    if (verb == "image") return image(request);
    if (verb == "command") return command(request);
    if (verb == "metrics") return metrics(request);
    if (verb == "series") return series(request);
    if (verb == "world" || verb == "world-check" || verb == "world-save") return about_world(request, verb);
    if (!verb.empty()) return fail(fmt::format("there is no request \"{}\"", visible(verb.substr(0, 40))), kVerbs);
    return fail("the request does not say what to do, in \"do\"", kVerbs);
}

Result<debug::Answer> Viewer::execute(const debug::Command& command) {
    const std::int64_t before = timeline_.tick();
    Result<debug::Answer> answer = session_.execute(command);
    const bool changed = answer && (std::holds_alternative<debug::Reloaded>(*answer) || std::holds_alternative<debug::Change>(command));
    if (answer && std::holds_alternative<debug::Reloaded>(*answer)) series_.forget_from(timeline_.first_tick());
    if (changes_what_comes(command)) series_.forget_from(timeline_.tick() + 1);
    latest_ = changed ? timeline_.tick() : std::max({latest_, before, timeline_.tick()});
    if (changed || timeline_.tick() != before) ++changes_;
    return answer;
}

Result<debug::Moved> Viewer::step() {
    Result<debug::Answer> answer = execute(debug::Step{1});
    if (!answer) return tl::unexpected<Error>(answer.error());
    return std::get<debug::Moved>(std::move(*answer));
}

Result<debug::Reloaded> Viewer::reload() {
    Result<debug::Answer> answer = execute(debug::Reload{});
    if (!answer) return tl::unexpected<Error>(answer.error());
    return std::get<debug::Reloaded>(std::move(*answer));
}

Json Viewer::where() const {
    Json out = {{"tick", timeline_.tick()},
                {"first", timeline_.first_tick()},
                {"latest", std::max(latest_, timeline_.tick())},
                {"last", nullptr},
                {"ended", nullptr}};
    const std::optional<sim::Ending> ended = timeline_.ended();
    if (ended) out["ended"] = sim::name_of(*ended);
    if (options_.last_tick)
        out["last"] = *options_.last_tick;
    else if (ended && *ended != sim::Ending::Interrupted && timeline_.tick() >= latest_)
        out["last"] = timeline_.tick();
    return out;
}

Result<Reply> Viewer::hello() {
    const sim::Subdomain& subdomain = timeline_.simulation().subdomain();
    const ModuleInfo& module = subdomain.module;
    const Result<debug::PredicatesListed> listed = debug::list_predicates(module);
    if (!listed) return tl::unexpected<Error>(listed.error());
    const Result<debug::Answer> standing = session_.execute(debug::Where{});
    if (!standing) return tl::unexpected<Error>(standing.error());
    // Names of the prelude may stand for several, in the same order in both.
    std::vector<bool> used(module.predicate_count, false);
    Json predicates = Json::array();
    for (const auto& each : listed->predicates) {
        const PredicateInfo* info = nullptr;
        for (u32 i = 0; i < module.predicate_count && info == nullptr; ++i)
            if (!used[i] && !module.predicates[i].auxiliary && module.predicates[i].name == each.name) {
                used[i] = true;
                info = &module.predicates[i];
            }
        if (info == nullptr) continue;
        predicates.push_back({{"name", each.name},
                              {"declaration", each.declaration},
                              {"arguments", info->arity},
                              {"linear", info->kind == PredicateKind::Linear},
                              {"action", info->kind == PredicateKind::Action},
                              {"own", each.own}});
    }
    Json maps = Json::array();
    for (const std::string_view name : render::ColourMap::names()) maps.push_back(name);
    const bool is_free = subdomain.ensemble.is_free(), is_graph = subdomain.ensemble.is_graph();
    Reply reply;
    reply.words = {{"program", options_.program},
                   {"world", options_.world},
                   {"lattice", is_free && !is_graph ? "free" : std::string(subdomain.world.lattice_name())},
                   {"flat", (!is_free || is_graph) && subdomain.lattice.flat()},
                   {"catoms", std::get<debug::Standing>(*standing).catoms},
                   {"recorded", options_.session.recorded},
                   {"live", !options_.session.recorded},
                   {"links", subdomain.ensemble.keeps_links() && (!is_free || is_graph)},
                   {"jams", subdomain.world.longest_jam},
                   {"predicates", std::move(predicates)},
                   {"maps", std::move(maps)}};
    reply.words.update(where());
    return reply;
}

Result<void> Viewer::go_to(std::optional<std::int64_t> tick) {
    if (!tick || *tick == timeline_.tick()) return {};
    const Result<debug::Answer> moved = execute(debug::To{*tick});
    if (!moved) return tl::unexpected<Error>(moved.error());
    return {};
}

Result<Reply> Viewer::frame(const Json& request) {
    Fields fields = fields_of(request);
    std::optional<std::int64_t> tick;
    std::int64_t most = kMostSent;
    fields.read("tick", tick, 0, kMostTick);
    fields.read("most", most, 1, kMostPerFrame);
    bool with_values = false;
    fields.read("values", with_values);
    Result<picture::Look> look = look_of(fields.object("look"));
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    if (!look) return tl::unexpected<Error>(look.error());
    // The run is where it is, whatever somebody writes into a field.
    look->skips_mistakes = true;
    if (auto there = go_to(tick); !there) return tl::unexpected<Error>(there.error());
    const FrameRequest asked{.text = fmt::format("{} {} {}", most, with_values, fields.object("look").dump()),
                             .look = std::move(*look),
                             .most = static_cast<std::size_t>(most),
                             .with_values = with_values};
    return frames_.make(asked, timeline_, options_.drawing(), changes_);
}

Result<Reply> Viewer::image(const Json& request) {
    Fields fields = fields_of(request);
    std::optional<std::int64_t> tick;
    std::vector<double> size;
    fields.read("tick", tick, 0, kMostTick);
    fields.read("size", size, 2, kLeastPixels, kMostPixels);
    Result<picture::Look> look = look_of(fields.object("look"));
    const sim::Subdomain& subdomain = timeline_.simulation().subdomain();
    const Result<picture::SheetOptions> sheet =
        sheet_of(fields.object("camera"), size, !subdomain.world.is_free() && subdomain.lattice.flat());
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    if (!look) return tl::unexpected<Error>(look.error());
    if (!sheet) return tl::unexpected<Error>(sheet.error());
    // The run is where it is, whatever somebody writes into a field.
    look->skips_mistakes = true;
    if (auto there = go_to(tick); !there) return tl::unexpected<Error>(there.error());
    Result<picture::Frame> seen = picture::look_at(timeline_.simulation().subdomain(), options_.drawing(), *look);
    if (!seen) return tl::unexpected<Error>(as_page_says_it(seen.error()));
    Reply reply;
    if (!speaks()) return reply;
    reply.words = frame_words(*seen, picture::colour(std::span(&*seen, 1), *look));
    reply.words["mistakes"] = as_page_says_them(seen->mistakes);
    Workers workers(static_cast<int>(std::clamp(sysconf(_SC_NPROCESSORS_ONLN), 1L, 64L)));
    Result<render::Image> picture = picture::paint_sheet(std::span(&*seen, 1), *look, *sheet, workers);
    if (!picture) return tl::unexpected<Error>(picture.error());
    reply.words["width"] = picture->width;
    reply.words["height"] = picture->height;
    reply.binary = render::png_of(*picture);
    return reply;
}

Result<Reply> Viewer::command(const Json& request) {
    Fields fields = fields_of(request);
    std::string line;
    fields.read("line", line);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    if (line.find_first_not_of(" \t") == std::string::npos) return fail("the command is empty", "`help` lists the commands");
    const Result<debug::Command> parsed = debug::parse_command(line);
    if (!parsed) return tl::unexpected<Error>(parsed.error());
    if (auto may = may_write(*parsed); !may) return tl::unexpected<Error>(may.error());
    const Result<debug::Answer> answer = execute(*parsed);
    if (!answer) return tl::unexpected<Error>(answer.error());
    Reply reply;
    if (!speaks()) return reply;
    Json json = Json::parse(debug::to_json_with_text(*answer));
    reply.words["text"] = std::move(json["text"]);
    json.erase("text");
    reply.words["answer"] = std::move(json);
    return reply;
}

Result<Reply> Viewer::metrics(const Json& request) {
    Fields fields = fields_of(request);
    std::int64_t most = 2000;
    fields.read("most", most, 1, kMostPoints);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    return Reply{.words = metrics_.json(static_cast<std::size_t>(most))};
}

Result<Reply> Viewer::series(const Json& request) {
    Fields fields = fields_of(request);
    std::string body;
    std::int64_t most = 1000;
    fields.read("body", body);
    fields.read("most", most, 2, kMostPoints);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    if (body.find_first_not_of(" \t") == std::string::npos) return fail("the body is empty", "Write what is to be counted, in Meld");
    Result<Json> known = series_.ask(timeline_, body, options_.last_tick.value_or(std::max(latest_, timeline_.tick())), most);
    if (!known) return tl::unexpected<Error>(known.error());
    return Reply{.words = std::move(*known)};
}

Result<Reply> Viewer::about_world(const Json& request, const std::string& verb) {
    Fields fields = fields_of(request);
    std::string toml, path;
    if (verb != "world") fields.read("toml", toml);
    if (verb == "world-save") fields.read("path", path);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    if (!speaks()) return Reply{};
    if (verb == "world") return options_.world_file();
    return verb == "world-check" ? options_.check_world(toml) : options_.save_world(path, toml);
}

}  // namespace meld::view
