// From TOML to a World: one function per section.
#include "runtime/world/file/world_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/input_file.h"
#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/file/amoebot_section.h"
#include "runtime/world/file/assembly_section.h"
#include "runtime/world/file/body_section.h"
#include "runtime/world/file/event_section.h"
#include "runtime/world/file/given_facts.h"
#include "runtime/world/file/graph_section.h"
#include "runtime/world/file/moves_section.h"
#include "runtime/world/file/network_section.h"
#include "runtime/world/file/physics_section.h"
#include "runtime/world/file/point_section.h"
#include "runtime/world/file/program_section.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {
namespace {

// How many bricks are examined for a first catom; after that a body is assumed to have one.
constexpr int kBricksSearched = 10'000;

// Worlds are written by people; lists may have a line for each of 100 million catoms.
constexpr std::uint64_t kMaxWorld_bytes = std::uint64_t{256} << 20;

// The name of what is no lattice.
constexpr std::string_view kGraph = "graph";

bool says_graph(const Section& top) {
    std::string name;
    top.read("lattice", name);
    return name == kGraph;
}

// The table under a key, which is empty if there is none.
const toml::table& table_at(TomlReader& reader, const toml::table& top, std::string_view key) {
    static const toml::table kNone;
    const toml::node* node = top.get(key);
    if (!node) return kNone;
    if (node->is_table()) return *node->as_table();
    reader.wrong(node->source(), fmt::format("{} {}", key, type_mismatch(*node, fmt::format("a table [{}]", key))));
    return kNone;
}

std::string no_such_ports(std::string_view name) { return fmt::format("there is no robot '{}' whose ports are known", name); }

// Why the ports of this world cannot have the numbers that they have; empty: they can.
Error misplaced_ports(const World& world) {
    if (!world.ports) return {};
    const PortNumbers& ports = *world.ports;
    const std::string those = fmt::format("ports = \"{}\" numbers the sides of {}", ports.name, ports.robot);
    if (world.is_graph()) return {those + ", and the nodes of a graph have none", "take it out"};
    if (world.is_free()) return {those + ", and a port of a body is only the number of a link", "take it out"};
    if (world.lattice_name() == ports.lattice) return {};
    return {fmt::format("{}, which stand on the {} lattice, and this one is {}", those, ports.lattice, world.lattice_name()),
            fmt::format("write lattice = \"{}\", or take ports out", ports.lattice)};
}

void read_top(TomlReader& reader, const Section& top, World& world) {
    std::string name(Lattice(world.lattice).name());
    top.read("lattice", name);
    if (const auto kind = Lattice::kind_named(name)) {
        world.lattice = *kind;
    } else if (name == kGraph) {
        // Pictures of graphs are flat.
        world.lattice = LatticeKind::Square;
    } else {
        auto known = Lattice::kind_names();
        known.push_back(kGraph);
        reader.wrong(top.find("lattice")->source(), fmt::format("there is no lattice '{}'", name), did_you_mean(name, known));
    }
    std::string ports(kLatticePorts);
    top.read("ports", ports);
    world.ports = port_numbers_of(ports);
    if (!world.ports && ports != kLatticePorts) top.wrong("ports", no_such_ports(ports), did_you_mean(ports, port_numbers_names()));
    top.read_positive("radius", world.radius);
    top.read_count("seed", world.seed);
    top.read_count("held", world.held, 0);
}

// [target] cells = [[0, 0, 0], ...] or "cells.csv": the target as a list.
void read_listed_target(TomlReader& reader, const Section& target, World& world) {
    const Lattice lattice(world.lattice);
    CellList listed(lattice);
    read_cells(reader, target, "[target]", listed);
    const Result<std::vector<Cell>> cells = listed.sorted();
    if (!cells) return reader.wrong(cells.error());
    if (cells->empty() && !reader.error()) return target.wrong("cells", "[target] cells lists no cell", "take [target] out");
    world.target = around_each(*cells, lattice, fmt::format("{} listed cell{}", cells->size(), cells->size() == 1 ? "" : "s"));
}

void read_target(TomlReader& reader, const toml::table& table, World& world) {
    const Section target(reader, table, "[target]", {"shape", "cells", "fit"});
    const toml::node* cells = target.find("cells");
    if (cells && (cells->is_array() || (cells->is_string() && **cells->as_string() != "mass"))) {
        for (const char* other : {"shape", "fit"})
            if (target.has(other))
                return target.wrong("cells", fmt::format("[target] cells lists the target, so it has no {}", other),
                                    "take one of the two out");
        return read_listed_target(reader, target, world);
    }
    world.target = target.read_shape("shape");
    if (!table.empty() && !target.has("shape"))
        return reader.wrong(table.source(), "[target] has neither shape nor a list of cells", "add cells = [[0, 0, 0]]");
    if (target.has("fit")) {
        std::string fit;
        target.read_choice("fit", fit, {"mass"});
        world.target_fits_mass = true;
        if (cells) target.wrong("cells", "[target] cells already follows from fit = \"mass\"", "take one of the two out");
        return;
    }
    if (!cells) return;
    if (cells->is_string() && **cells->as_string() == "mass") {
        world.target_is_mass = true;
        return;
    }
    std::uint64_t count = 0;
    target.read_count("cells", count, 1);
    world.target_cells = count;
}

void read_names(TomlReader& reader, const toml::table& table, std::string_view section, std::map<std::string, std::string>& names) {
    for (const auto& [key, value] : table) {
        if (!value.is_string())
            return reader.wrong(value.source(), fmt::format("[{}] {} {}", section, key.str(), type_mismatch(value, "a string")));
        names[std::string(key.str())] = **value.as_string();
    }
}

void read_motion(TomlReader& reader, const toml::table& table, const DescribedRobots& robots, World& world) {
    MotionOptions& motion = world.motion;
    const toml::node* kind = table.get("kind");
    // "ode" is the name of earlier versions, for any engine.
    if (kind && kind->is_string() && (**kind->as_string() == "bodies" || **kind->as_string() == "ode")) {
        motion.kind = "bodies";
        double smallest = world.radius;
        for (const PlacedCatom& placed : world.placed) smallest = std::min(smallest, placed.radius.value_or(smallest));
        read_physics(reader, table, 2 * world.radius, 2 * smallest, robots, world.physics);
        world.tick_seconds = world.physics.step * world.physics.steps;
        return;
    }
    if (kind && kind->is_string() && **kind->as_string() == "amoebot") return read_amoebots(reader, table, motion);
    if (kind && kind->is_string() && **kind->as_string() == "points") return read_points(reader, table, motion);
    const Section section(reader, table, "[motion]", {"kind", "capacity", "keep_connected", "moves", "move"});
    section.read("kind", motion.kind);
    section.read_count("capacity", motion.capacity, 0);
    section.read("keep_connected", motion.keep_connected);
    read_moves(reader, section, world);
}

void read_record(TomlReader& reader, const toml::table& table, RecordOptions& record) {
    const Section section(reader, table, "[record]", {"every", "predicates"});
    section.read_count("every", record.every, 1);
    section.read("predicates", record.predicates);
}

void read_limits(TomlReader& reader, const toml::table& table, Limits& limits) {
    const Section section(reader, table, "[limits]",
                          {"max_facts_per_catom", "max_derivations_per_tick", "max_ticks", "max_list", "memory"});
    for (const auto& [key, limit] : {std::pair{"max_facts_per_catom", &limits.max_facts_per_catom},
                                     std::pair{"max_derivations_per_tick", &limits.max_derivations_per_tick}}) {
        std::uint64_t value = 0;
        section.read_count(key, value, 1);
        if (value > 0) *limit = value;
    }
    section.read_count("max_ticks", limits.max_ticks, 1);
    section.read_count("max_list", limits.max_list, 1, std::numeric_limits<std::uint32_t>::max());
    section.read_bytes("memory", limits.memory_bytes);
}

void read_time(TomlReader& reader, const toml::table& table, World& world) {
    const Section section(reader, table, "[time]", {"tick"});
    section.read_seconds("tick", world.tick_seconds);
}

// Whether no cell of the world's lattice lies in the body; false if the search in a large body would take too long.
bool surely_empty(const World& world, const Lattice& lattice) {
    int left = kBricksSearched;
    bool found = !world.cells.empty() || !world.placed.empty();
    if (found) return false;
    for_each_brick(world.body, lattice, [&](Cell brick) {
        found = cells_in_shape(world.body, lattice, brick) != BrickCells{};
        return !found && --left > 0;
    });
    return !found && left > 0;
}

// Which sections go with bodies that move freely, and which with cells.
void check_free(TomlReader& reader, const Section& top, World& world) {
    if (!world.is_free()) {
        if (top.has("assembly"))
            reader.wrong(top.find("assembly")->source(), "robots consist of bodies, and this world has none",
                         "write [motion] kind = \"bodies\", or take [[assembly]] out");
        if (!world.placed.empty())
            reader.wrong(top.find("body")->source(), "a [[body]] has positions, and catoms stand on cells here",
                         "give it cells, or the world [motion] kind = \"bodies\"");
        return;
    }
    for (const char* section : {"network", "clock"})
        if ((world.apart() || world.network.detect > 0) && top.has(section))
            reader.wrong(top.find(section)->source(), fmt::format("[{}] is for catoms on a lattice, and these are bodies", section),
                         "take it out, or the bodies");
    if (top.has("time"))
        reader.wrong(top.find("time")->source(), "a tick of this world lasts [motion] step times steps", "take [time] out");
    if (top.has("held")) reader.wrong(top.find("held")->source(), "catoms hold units only where they stand on a lattice", "take held out");
    if (world.target_cells || world.target_is_mass || world.target_fits_mass) {
        reader.wrong(top.find("target")->source(), "a target with a given number of cells needs a lattice",
                     fmt::format("take [target] {} out", world.target_fits_mass ? "fit" : "cells"));
    }
}

// Checks that concern the world as a whole.
void check_whole(TomlReader& reader, const Section& top, World& world) {
    if (world.held > world.motion.capacity) {
        reader.wrong(top.find("held")->source(),
                     fmt::format("held = {} is more than a catom can hold, [motion] capacity = {}", world.held, world.motion.capacity));
    }
    check_free(reader, top, world);
    if (world.has_amoebots()) check_amoebots(reader, top, world);
    if (const Error misplaced = misplaced_ports(world); !misplaced.problem.empty())
        top.wrong("ports", misplaced.problem, misplaced.suggestion);
    check_moving(reader, top, world);
    const toml::node* network = top.find("network");
    if (const toml::node* reach = network != nullptr && network->is_table() ? network->as_table()->get("reach") : nullptr;
        reach != nullptr && !world.is_graph())
        reader.wrong(reach->source(), "on a lattice, facts go only to catoms that a link leads to",
                     "take reach out, or write lattice = \"graph\"");
    if (reader.error() || world.is_graph()) return;
    const toml::source_region& body = top.find("body")->source();
    if (const Result<WorldSize> size = measure(world); !size) return reader.wrong(body, size.error().problem, size.error().suggestion);
    if (surely_empty(world, Lattice(world.lattice))) reader.wrong(body, "no catom: the body is empty", "make its shape larger");
    if (!world.target) return;
    World target;
    target.lattice = world.lattice;
    target.body = *world.target;
    const Result<WorldSize> size = measure(target);
    if (!size)
        reader.wrong(top.find("target")->source(), "the target is not a possible body: " + size.error().problem, size.error().suggestion);
}

std::map<std::string, std::uint64_t> hash_parts(const TomlReader& reader, const toml::table& table) {
    std::map<std::string, std::uint64_t> parts;
    for (const auto& [key, value] : table) {
        std::ostringstream text;
        text << toml::node_view<const toml::node>(value);
        parts[std::string(key.str())] = hash_text(text.str());
    }
    parts["files"] = reader.files_hash();
    return parts;
}

bool is_graph(const toml::table& top) { return top["lattice"].value<std::string_view>() == "graph"; }

// Graphs, networks that take time, links that fail, catoms that hang and amoebots are known by their links.
bool by_links(const toml::table& top) {
    return is_graph(top) || top["links"].is_table() || top.contains("network") || top.contains("clock") || needs_links(top) ||
           says_amoebots(top);
}

World read_sections(TomlReader& reader, const toml::table& table) {
    World world;
    world.path = reader.path();
    world.by_links = by_links(table);
    const Section top(reader, table, "", {"lattice", "ports", "acyclic", "graph",      "links",  "nodes",   "directed", "radius",  "seed",
                                          "held",    "body",  "target",  "facts",      "event",  "set",     "motion",   "record",  "limits",
                                          "network", "clock", "time",    "components", "faults", "program", "without",  "assembly"});
    read_top(reader, top, world);
    DescribedRobots robots = read_assemblies(reader, table);
    // Before a graph, which is made where it is read.
    read_limits(reader, table_at(reader, table, "limits"), world.limits);
    if (says_graph(top)) {
        if (!reader.error()) read_graph_world(reader, top, world);
    } else {
        refuse_graph_keys(reader, top);
        if (links_by_range(top)) read_range(reader, *top.find("links")->as_table(), world);
        read_bodies(reader, top, robots, world);
    }
    read_target(reader, table_at(reader, table, "target"), world);
    read_facts(reader, table_at(reader, table, "facts"), world.facts);
    read_programs(reader, table, world);
    read_settings(reader, table_at(reader, table, "set"), world.set);
    read_motion(reader, table_at(reader, table, "motion"), robots, world);
    read_network(reader, table_at(reader, table, "network"), world.network);
    read_clock(reader, table_at(reader, table, "clock"), world.clock);
    read_record(reader, table_at(reader, table, "record"), world.record);
    read_time(reader, table_at(reader, table, "time"), world);
    read_events(reader, table, world);
    read_faults(reader, table, world);
    read_names(reader, table_at(reader, table, "components"), "components", world.components);
    if (!reader.error()) check_whole(reader, top, world);
    world.source_hash = reader.source_hash();
    world.files = reader.files_read();
    for (const std::string& warning : reader.models().warnings()) world.warnings.push_back(warning);
    world.parts = hash_parts(reader, table);
    return world;
}

// Help for common mistakes in TOML itself.
std::string cure_of(std::string_view mistake) {
    const auto has = [mistake](std::string_view text) { return mistake.find(text) != std::string_view::npos; };
    if (has("could not determine value type")) return "write a text in quotes: lattice = \"square\"";
    if (has("control characters")) return "a text in quotes ends on its line: is its second quote missing?";
    if (has("expected '='")) return "write key = value";
    if (has("cannot redefine")) return "give each key once; a section that may occur several times has two brackets: [[body]]";
    return "";
}

}  // namespace

Result<World> parse_world(const std::string& text, const std::string& path, const WorldFiles* files) {
    if (const Result<void> shallow = check_key_depth(text, path); !shallow) return tl::unexpected<Error>(shallow.error());
    TomlReader reader(text, path, files);
    toml::table table;
    // The library's parser reports mistakes only by an exception.
    try {
        table = toml::parse(std::string_view(text), std::string_view(path));
    } catch (const toml::parse_error& error) {
        if (path.ends_with(".meld"))
            return fail(fmt::format("{} is a program, not a world", path),
                        fmt::format("Give a world, a .toml file: a program runs in it by meldsim run {} --world FILE.toml", path));
        return fail(fmt::format("{}: {}", reader.place(error.source()), error.description()), cure_of(error.description()));
    }
    World world = read_sections(reader, table);
    if (reader.error()) return tl::unexpected(*reader.error());
    world.text = text;
    return world;
}

namespace {

// The keys of a file; none if it has mistakes, or is a pipe.
toml::table keys_of(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return {};
    const Result<std::string> text = read_input(path, kMaxWorld_bytes, InputKind::File);
    if (!text || !check_key_depth(*text, path)) return {};
    try {
        return toml::parse(std::string_view(*text), std::string_view(path));
    } catch (const toml::parse_error&) {
        return {};
    }
}

}  // namespace

PortKeys port_keys(const std::string& path) {
    const toml::table top = keys_of(path);
    return {top["lattice"].value_or(std::string(Lattice(World().lattice).name())), top["ports"].value_or(std::string())};
}

bool asks_for_links(const std::string& path) { return by_links(keys_of(path)); }

bool says_places(const std::string& path) {
    static constexpr std::string_view kOthers[] = {"seed",    "facts", "event", "set",        "record", "limits",
                                                   "network", "clock", "time",  "components", "faults", "program"};
    const toml::table top = keys_of(path);
    return top.empty() ||
           std::ranges::any_of(top, [](const auto& entry) { return std::ranges::find(kOthers, entry.first.str()) == std::end(kOthers); });
}

KeyPlace key_place(const std::string& text, const std::string& table) {
    const toml::table top = toml::parse(std::string_view(text));
    const toml::node* const node = top.get(table);
    if (node == nullptr) return {text.size(), "\n[" + table + "]\n", ""};
    const toml::source_position begin = node->source().begin;
    std::size_t line = 0;
    for (toml::source_index i = 1; i < begin.line; ++i) line = text.find('\n', line) + 1;
    const std::size_t at = line + begin.column - 1;
    const char first = at < text.size() ? text[at] : ' ';
    if (first == '{') return {at + 1, " ", node->as_table()->empty() ? "" : ","};
    if (first != '[') return {0, table + ".", "\n"};
    const std::size_t end = text.find('\n', at);
    return end == std::string::npos ? KeyPlace{text.size(), "\n", ""} : KeyPlace{end + 1, "", "\n"};
}

bool asks_for_graph(const std::string& path) { return is_graph(keys_of(path)); }

bool says_acyclic(const std::string& path) { return keys_of(path)["acyclic"].value_or(false); }

std::vector<std::string> programs_named(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    return program_files(keys_of(path), [&](const std::string& file) { return (folder / file).string(); });
}

Result<void> set_ports(World& world, std::string_view name) {
    const PortNumbers* const ports = port_numbers_of(name);
    if (!ports && name != kLatticePorts) return fail(no_such_ports(name), did_you_mean(name, port_numbers_names()));
    world.ports = ports;
    Error misplaced = misplaced_ports(world);
    if (misplaced.problem.empty()) return {};
    return tl::unexpected<Error>(std::move(misplaced));
}

Result<std::string> read_text(const std::string& path) { return read_input(path, kMaxWorld_bytes, InputKind::FileOrPipe); }

Result<World> read_world(const std::string& path) {
    const Result<std::string> text = read_text(path);
    if (!text) return tl::unexpected(text.error());
    return parse_world(*text, path);
}

}  // namespace meld::world
