#include "runtime/driver/setup/inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/files/input_file.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/run/replay.h"
#include "runtime/driver/setup/default_world.h"
#include "runtime/driver/setup/extension_file.h"
#include "runtime/driver/setup/memory_check.h"
#include "runtime/engine/tuple/program_actions.h"
#include "runtime/world/description/limits.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

std::string world_path(const RunOptions& options) {
    if (!options.world.empty()) return options.world;
    const std::string beside = std::filesystem::path(options.program).replace_extension(".toml").string();
    std::error_code error;
    return std::filesystem::exists(beside, error) ? beside : "";
}

namespace {

constexpr std::uint64_t kMostEvents_bytes = std::uint64_t{1} << 30;

// Several files as one text, whose places are those of the first file.
class Joined {
  public:
    // Messages name its first lines as those of `path`, unless they come from elsewhere.
    explicit Joined(std::string path) : path_(std::move(path)) {}

    // On lines of their own: those of the file at `path` from this number on.
    void add(std::string_view lines, const std::string& path, std::uint64_t first = 1) {
        if (!text_.empty() && text_.back() != '\n') text_ += "\n";
        begins_.push_back({static_cast<std::uint64_t>(std::ranges::count(text_, '\n')), first, path});
        text_ += lines;
    }
    const std::string& text() const { return text_; }
    const std::string& path() const { return path_; }

    // A message or a place with each place as that of the file in which it is.
    std::string placed(const std::string& said) const {
        std::string out;
        std::size_t done = 0;
        for (std::size_t at = 0; (at = said.find(path_ + ":", at)) != std::string::npos; at = done) {
            const char* const digits = said.data() + at + path_.size() + 1;
            std::uint64_t line = 0;
            const char* const end = std::from_chars(digits, said.data() + said.size(), line).ptr;
            const auto file = std::ranges::find_if(begins_.rbegin(), begins_.rend(), [&](const Begin& b) { return line > b.lines; });
            out.append(said, done, at - done);
            done = static_cast<std::size_t>(end - said.data());
            if (end == digits || file == begins_.rend())
                out.append(said, at, done - at);
            else
                out += fmt::format("{}:{}", file->path, line - file->lines + file->first - 1);
        }
        return out + said.substr(done);
    }

    // The world that this is the text of.
    Result<world::World> parse() const {
        Result<world::World> world = world::parse_world(text_, path_);
        if (!world) return fail(placed(world.error().problem), world.error().suggestion, world.error().code);
        for (std::string& warning : world->warnings) warning = placed(warning);
        for (world::GivenFact& fact : world->facts) fact.place = placed(fact.place);
        for (world::Event& event : world->events) {
            for (auto* facts : {&event.give, &event.take})
                for (world::GivenFact& fact : *facts) fact.place = placed(fact.place);
            for (auto* catoms : {&event.kill, &event.hang, &event.restart})
                for (world::CatomChoice& one : *catoms) one.place = placed(one.place);
            for (auto* links : {&event.cut, &event.heal, &event.join})
                for (world::LinkChoice& one : *links) one.place = placed(one.place);
            for (world::Jam& jam : event.jam) jam.links.place = placed(jam.links.place);
        }
        return world;
    }

  private:
    struct Begin {
        std::uint64_t lines;  // Before it.
        std::uint64_t first;  // The number of its first line in its file.
        std::string path;
    };
    std::string path_, text_;
    std::vector<Begin> begins_;
};

// A world and its text.
struct Composed {
    Joined text;
    world::World world;
};

// Says in its section [network], which it may have, that nodes send to any that they know.
Joined with_reach(const std::string& file, const Places& places, const std::string& path) {
    Joined all(path);
    all.add(places.text, places.path);
    const world::KeyPlace place = world::key_place(file, "network");
    const std::string key = place.before + kReachesAny + place.after, before = file.substr(0, place.at), after = file.substr(place.at);
    if (key.find('\n') == std::string::npos) {
        all.add(before + key + after, path);
        return all;
    }
    all.add(before, path);
    all.add(key, places.path);
    all.add(after, path, static_cast<std::uint64_t>(std::ranges::count(before, '\n')) + 1);
    return all;
}

// The world of a file that does not say where catoms are: where they would be without it.
Result<Composed> in_default_places(const std::string& path, const ModuleInfo* module) {
    const Result<std::string> file = world::read_text(path);
    if (!file) return tl::unexpected<Error>(file.error());
    const Result<Places> places = module != nullptr ? default_places(*module) : default_places();
    if (!places) return tl::unexpected<Error>(places.error());
    Joined all(path);
    all.add(places->text, places->path);
    all.add(*file, path);
    Result<world::World> world = all.parse();
    if (world && places->graph && !world->network.reach) {
        all = with_reach(*file, *places, path);
        world = all.parse();
    }
    if (!world) return tl::unexpected<Error>(world.error());
    world->warnings.insert(world->warnings.end(), places->warnings.begin(), places->warnings.end());
    return Composed{std::move(all), std::move(*world)};
}

Result<Composed> read_composed(const std::string& path, const ModuleInfo* module) {
    if (!path.empty() && !world::says_places(path)) return in_default_places(path, module);
    Result<world::World> world = !path.empty() ? world::read_world(path) : module != nullptr ? default_world(*module) : default_world();
    if (!world) return tl::unexpected<Error>(world.error());
    Joined text(world->path);
    text.add(world->text, world->path);
    return Composed{std::move(text), std::move(*world)};
}

// The same world with the events of these files after its own.
Result<world::World> with_events(Composed whole, const std::vector<std::string>& files) {
    for (const std::string& file : files) {
        const Result<std::string> events = read_input(file, kMostEvents_bytes, InputKind::FileOrPipe);
        if (!events) return tl::unexpected<Error>(events.error());
        whole.text.add(*events, file);
    }
    const std::string names = fmt::format("{}", fmt::join(files, ", "));
    Result<world::World> with = whole.text.parse();
    if (!with) return fail(fmt::format("--events: {}", with.error().problem), with.error().suggestion);
    const auto rest = [](std::map<std::string, std::uint64_t> parts) {
        parts.erase("event");
        return parts;
    };
    if (rest(whole.world.parts) != rest(with->parts))
        return fail(fmt::format("--events {}: there is more than [[event]] tables in it", names), "Put the rest into the world");
    return with;
}

// Priorities count only where turns are given.
void note_priorities(const ModuleInfo& module, world::World& world) {
    if (world.clock.gives_turns()) return;
    const tuple::ProgramActions actions(module);
    for (const ActionInfo& action : known_actions()) {
        if (action.performer != ActionInfo::Performer::Clock || !actions.uses(action.kind)) continue;
        return world.warnings.push_back(fmt::format(
            "`{}` has no effect, since this world does not give turns; give the world [clock] kind = \"priority\" or \"sequential\"",
            action.word));
    }
}

}  // namespace

Result<world::World> choose_world(const RunOptions& options, const ModuleInfo* module) {
    if (!options.replay.empty()) return recorded_world(options.replay);
    Result<Composed> read = read_composed(world_path(options), module);
    if (!read) return tl::unexpected<Error>(read.error());
    Result<world::World> world = options.events.empty() ? std::move(read->world) : with_events(std::move(*read), options.events);
    if (!world) return world;
    if (options.seed >= 0)
        if (const auto done = world::set_seed(*world, static_cast<std::uint64_t>(options.seed)); !done)
            return tl::unexpected<Error>(done.error());
    for (const std::string& limit : options.limits)
        if (const auto done = world::set_limit(*world, limit); !done) return tl::unexpected<Error>(done.error());
    if (!options.ports.empty())
        if (const auto done = world::set_ports(*world, options.ports); !done)
            return fail("--ports: " + done.error().problem, done.error().suggestion);
    if (options.given.size() > 9)
        return fail(fmt::format("there are {} --arg, and a program has no more than nine: @arg1 to @arg9", options.given.size()));
    for (std::size_t i = 0; i < options.given.size(); ++i) world->set[fmt::format("arg{}", i + 1)] = options.given[i];
    for (const std::string& setting : options.set) {
        const std::size_t equals = setting.find('=');
        if (equals == std::string::npos || equals == 0) return fail("--set " + setting + " sets nothing", "Write --set name=value");
        world->set[setting.substr(0, equals)] = setting.substr(equals + 1);
    }
    if (module != nullptr) note_priorities(*module, *world);
    return world;
}

namespace {

int processes_on_this_machine(const comm::Communicator& comm) {
    const char* local = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
    return local != nullptr ? std::max(1, std::atoi(local)) : comm.processes();
}

}  // namespace

namespace {

// Views need what their neighbours tell in the end; a raw network loses it.
Result<void> check_raw(const ModuleInfo& module, const world::World& world) {
    if (world.network.kind != world::NetworkKind::Raw) return {};
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        if (p.column == kNone16 || !module.columns[p.column].exported) continue;
        return fail(fmt::format("{}: neighbours read {} of the program, and in a network that is raw they may never learn of it",
                                world.path, p.auxiliary ? "what rules derive" : p.name),
                    "Send linear facts instead, or choose a network that is lossy");
    }
    return {};
}

// Each program that the world names is in the module.
Result<void> check_programs(const ModuleInfo& module, const world::World& world, const std::string& module_path) {
    if (module.program_count == world.programs.size() + 1) return {};
    return fail(fmt::format("{} contains {} program{}, and with those that {} names there are {}", module_path, module.program_count,
                            module.program_count == 1 ? "" : "s", world.path, world.programs.size() + 1),
                fmt::format("Give the .meld file{}, or compile it with meldc compile --with FILE for each [[program]] file",
                            world.programs.empty() ? "" : " and the world as a file"));
}

}  // namespace

Result<Inputs> read_inputs(const RunOptions& options, const comm::Communicator& comm, const std::string& module_path) {
    Result<Module> module = load_module(module_path, kAbiVersion);
    if (!module) return tl::unexpected<Error>(module.error());
    const ModuleInfo& info = *static_cast<const ModuleInfo*>(module->table());
    if (info.schema_hash != module->note().schema_hash)
        return fail(module_path + " contradicts its own note", "Compile it again", ExitCode::ModuleRefused);
    Result<world::World> world = choose_world(options, &info);
    if (!world) return tl::unexpected<Error>(world.error());
    Result<world::Target> target = world::Target::make(*world, world::Lattice(world->lattice));
    if (!target) return tl::unexpected<Error>(target.error());
    if (world->by_links && !info.by_links)
        return fail(fmt::format("{} finds neighbours by geometry, and in this world they are known by their links", module_path),
                    fmt::format("Give the .meld file, or compile it with meldc compile {}", world->is_graph() ? "--graph" : "--links"));
    if (info.for_graphs && !world->is_graph())
        return fail(fmt::format("{} was compiled for graphs, and this world has a lattice", module_path),
                    "Give the .meld file, or compile it with meldc compile --no-graph");
    if (auto all = check_programs(info, *world, module_path); !all) return tl::unexpected<Error>(all.error());
    if (auto fits = check_raw(info, *world); !fits) return tl::unexpected<Error>(fits.error());
    Inputs inputs{.module = std::move(*module),
                  .world = std::move(*world),
                  .target = std::move(*target),
                  .processes_here = processes_on_this_machine(comm)};
    if (auto done = add_extensions(options.extensions, inputs.registry); !done) return tl::unexpected<Error>(done.error());
    return inputs;
}

Result<void> count_catoms(const RunOptions& options, comm::Communicator& comm, Inputs& inputs,
                          const std::function<Result<void>(const MemoryNeed&)>& before_check) {
    auto counts = sim::count_beforehand(inputs.world, comm, options.threads);
    if (!counts) return tl::unexpected<Error>(counts.error());
    inputs.counts = std::move(*counts);
    inputs.memory = memory_need(inputs.world, inputs.info(), options, comm.processes(), inputs.counts);
    if (before_check)
        if (const auto all = comm::outcome_of_all(comm, before_check(inputs.memory)); !all) return all;
    return comm::outcome_of_all(comm, check_memory(inputs.world, inputs.memory, inputs.processes_here));
}

}  // namespace meld::driver
