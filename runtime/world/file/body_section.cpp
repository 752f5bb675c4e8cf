#include "runtime/world/file/body_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/lists/positions_file.h"
#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {
namespace {

constexpr std::uint64_t kMaxList_bytes = std::uint64_t{4} << 30;
// In a shape.
constexpr double kMostRobots = 1e7;

// cells = [[0, 0, 0], [1, 0, 0]]
void read_cell_array(TomlReader& reader, const toml::array& array, CellList& listed) {
    for (const toml::node& item : array) {
        std::vector<std::int64_t> coordinates;
        if (!item.is_array()) return reader.wrong(item.source(), "a cell " + type_mismatch(item, "an array [x, y, z]"));
        for (const toml::node& coordinate : *item.as_array()) {
            if (!coordinate.is_integer())
                return reader.wrong(coordinate.source(), "a cell coordinate " + type_mismatch(coordinate, "an integer"));
            coordinates.push_back(**coordinate.as_integer());
        }
        const toml::source_position at = item.source().begin;
        const Result<void> added = listed.add(coordinates, reader.path(), at.line, at.column);
        if (!added) return reader.wrong(item.source(), added.error().problem, added.error().suggestion);
    }
}

// A file that the node names.
void unreadable(TomlReader& reader, const toml::node& node, const Error& error) {
    reader.wrong(Error{fmt::format("{}: {}", reader.place(node.source()), error.problem), error.suggestion, error.code});
}

// cells = "points.csv", relative to the world file.
void read_cell_file(TomlReader& reader, const toml::node& node, CellList& listed) {
    const std::string path = reader.beside(**node.as_string());
    const Result<std::string> text = reader.read_file(path, kMaxList_bytes);
    if (!text) return unreadable(reader, node, text.error());
    if (const Result<void> added = listed.add_file(*text, path); !added) reader.wrong(added.error());
}

// positions = [[0, 0, 0.5], ...] or "points.csv", relative to the world file.
void read_positions(TomlReader& reader, const Section& body, std::vector<PlacedCatom>& placed) {
    const toml::node* node = body.find("positions");
    if (!node) return;
    if (node->is_array()) {
        std::vector<Vec3> listed;
        body.read("positions", listed);
        for (const Vec3& position : listed) placed.push_back({.position = position, .radius = {}, .mass = {}});
        return;
    }
    if (!node->is_string())
        return reader.wrong(node->source(), "[[body]] positions " + type_mismatch(*node, "a file name or an array of [x, y, z]"));
    const std::string path = reader.beside(**node->as_string());
    const Result<std::string> text = reader.read_file(path, kMaxList_bytes);
    if (!text) return unreadable(reader, *node, text.error());
    if (const Result<void> added = add_positions(*text, path, placed); !added) reader.wrong(added.error());
}

}  // namespace

void read_cells(TomlReader& reader, const Section& section, std::string_view name, CellList& listed) {
    const toml::node* cells = section.find("cells");
    if (!cells) return;
    if (cells->is_array()) return read_cell_array(reader, *cells->as_array(), listed);
    if (cells->is_string()) return read_cell_file(reader, *cells, listed);
    reader.wrong(cells->source(), fmt::format("{} cells {}", name, type_mismatch(*cells, "a file name or an array of [x, y, z]")));
}

Shape around_each(const std::vector<Cell>& cells, const Lattice& lattice, const std::string& text) {
    std::vector<Shape> balls;
    for (const Cell cell : cells) balls.push_back(make_shape(Moved{make_shape(Ball{0.25}, ""), lattice.position(cell)}, ""));
    return make_shape(Union{std::move(balls)}, text);
}

namespace {

// The cells of a shape, in the order in which catoms there would be numbered.
std::vector<Cell> cells_of(const Section& body, const Shape& shape, const Lattice& lattice) {
    World alone;
    alone.lattice = lattice.kind();
    alone.body = shape;
    std::vector<Cell> cells;
    const Result<WorldSize> size = measure(alone);
    if (!size) {
        body.wrong("shape", size.error().problem, size.error().suggestion);
    } else if (size->cells_estimate > kMostRobots) {
        body.wrong("shape", fmt::format("about {:.0f} robots are too many", size->cells_estimate), "make the shape smaller");
    } else {
        std::vector<std::uint32_t> numbers;
        for (const auto& [brick, count] : count_bricks(alone, lattice, 0, 1)) {
            cells_of_brick(alone, lattice, brick, numbers);
            for (const std::uint32_t number : numbers) cells.push_back(lattice.cell_in_brick(lattice.brick_at(brick), number));
        }
    }
    return cells;
}

// Where the robots of a [[body]] stand: at positions, or at cells that are `spacing` apart.
std::vector<RobotPlace> read_robot_places(TomlReader& reader, const Section& body, const Lattice& lattice) {
    std::vector<RobotPlace> places;
    const toml::node* positions = body.find("positions");
    if (positions != nullptr && positions->is_string()) {
        const std::string path = reader.beside(**positions->as_string());
        const Result<std::string> text = reader.read_file(path, kMaxList_bytes);
        if (!text) return unreadable(reader, *positions, text.error()), places;
        if (const Result<void> added = add_robot_places(*text, path, places); !added) reader.wrong(added.error());
        return places;
    }
    std::vector<Vec3> listed;
    body.read("positions", listed);
    for (const Vec3& at : listed) places.push_back({at, {}});
    if (positions != nullptr && body.has("spacing"))
        body.wrong("spacing", "robots at positions have no spacing", "take spacing out; it is for those in a shape or at cells");
    double spacing = 1;
    body.read_positive("spacing", spacing);
    std::vector<Cell> cells;
    if (const auto shape = body.read_shape("shape")) cells = cells_of(body, *shape, lattice);
    CellList list(lattice);
    read_cells(reader, body, "[[body]]", list);
    if (const Result<std::vector<Cell>> sorted = list.sorted(); !sorted)
        reader.wrong(sorted.error());
    else
        cells.insert(cells.end(), sorted->begin(), sorted->end());
    for (const Cell cell : cells) {
        Vec3& at = places.emplace_back(RobotPlace{lattice.position(cell), {}}).at;
        for (double& x : at) x *= spacing;
    }
    return places;
}

void read_body(TomlReader& reader, const toml::table& table, std::vector<Shape>& shapes, CellList& listed, DescribedRobots& robots,
               std::vector<PlacedCatom>& placed) {
    const Section body(reader, table, "[[body]]", {"shape", "cells", "positions", "assembly", "turned", "spacing"});
    const int given = body.has("shape") + body.has("cells") + body.has("positions");
    if (given != 1) {
        return reader.wrong(
            table.source(),
            given == 0 ? "a [[body]] has neither shape nor cells" : "a [[body]] has more than one of shape, cells and positions",
            "give each its own [[body]] with one of them");
    }
    if (body.has("assembly")) return place_robots(reader, body, read_robot_places(reader, body, listed.lattice()), robots, placed);
    for (const char* key : {"turned", "spacing"})
        if (body.has(key))
            body.wrong(key, fmt::format("a [[body]] has {}, which is of robots, and no assembly", key),
                       key[0] == 't' ? "turn catoms by [[motion.catoms]] turned" : "write [motion] spacing");
    if (const auto shape = body.read_shape("shape")) shapes.push_back(*shape);
    read_positions(reader, body, placed);
    read_cells(reader, body, "[[body]]", listed);
}

// A cell of [without] on which no catom would stand anyway is probably a mistake.
void warn_of_free_cells(const std::string& place, std::span<const Cell> cells, const Lattice& lattice, World& world) {
    const auto before = [&](Cell a, Cell b) { return lattice.key(a) < lattice.key(b); };
    const auto taken = [&](Cell cell) {
        return std::ranges::binary_search(world.cells, cell, before) ||
               (world.body.root() != nullptr && world.body.contains(lattice.position(cell)));
    };
    const auto free = std::ranges::find_if_not(cells, taken);
    if (free == cells.end()) return;
    const auto count = std::ranges::count_if(cells, [&](Cell cell) { return !taken(cell); });
    world.warnings.push_back(fmt::format("{}: cell ({}, {}, {}){} in no body, so [without] has no effect there", place, free->x, free->y,
                                         free->z, count == 1 ? " is" : fmt::format(" and {} more are", count - 1)));
}

// No catoms stand on the cells that [without] lists, whatever the bodies are.
void read_without(TomlReader& reader, const Section& top, const Lattice& lattice, World& world) {
    const toml::node* node = top.find("without");
    if (!node) return;
    if (!node->is_table()) return reader.wrong(node->source(), "without " + type_mismatch(*node, "a table [without]"));
    const Section without(reader, *node->as_table(), "[without]", {"cells"});
    if (!without.has("cells")) return reader.wrong(node->source(), "[without] has no cells", "add cells = [[0, 0, 0]]");
    CellList listed(lattice);
    read_cells(reader, without, "[without]", listed);
    const Result<std::vector<Cell>> cells = listed.sorted();
    if (!cells) return reader.wrong(cells.error());
    const auto before = [&](Cell a, Cell b) { return lattice.key(a) < lattice.key(b); };
    warn_of_free_cells(reader.place(without.find("cells")->source()), *cells, lattice, world);
    std::erase_if(world.cells, [&](Cell cell) { return std::binary_search(cells->begin(), cells->end(), cell, before); });
    if (cells->empty() || !world.body.root()) return;
    const std::string text = fmt::format("minus({}, {} cells)", world.body.text(), cells->size());
    world.body = make_shape(Difference{world.body, {around_each(*cells, lattice, "")}}, text);
}

// How many catoms stand on cells; 0 if there are too many to be counted, which is an error later.
std::uint64_t catoms_on_cells(const World& world, const Lattice& lattice) {
    World cells;
    cells.lattice = world.lattice;
    cells.body = world.body;
    cells.cells = world.cells;
    if (cells.body.root() == nullptr && cells.cells.empty()) return 0;
    return measure(cells) ? count_catoms(cells, lattice) : 0;
}

}  // namespace

void read_bodies(TomlReader& reader, const Section& top, DescribedRobots& robots, World& world) {
    const toml::node* node = top.find("body");
    if (!node)
        return reader.wrong(
            Error{fmt::format("{}: no catom: the body is empty", reader.path()), "add [[body]] shape = \"box(10, 10, 10)\""});
    const Lattice lattice(world.lattice);
    std::vector<Shape> shapes;
    CellList listed(lattice);
    if (node->is_table()) {
        read_body(reader, *node->as_table(), shapes, listed, robots, world.placed);
    } else if (node->is_array_of_tables()) {
        for (const toml::node& table : *node->as_array()) read_body(reader, *table.as_table(), shapes, listed, robots, world.placed);
    } else {
        reader.wrong(node->source(), "body " + type_mismatch(*node, "a table [[body]]"));
    }
    world.body = Shape::unite(std::move(shapes));
    Result<std::vector<Cell>> cells = listed.sorted();
    if (!cells) return reader.wrong(cells.error());
    world.cells = std::move(*cells);
    read_without(reader, top, lattice, world);
    if (!robots.kinds.empty()) number_robots(reader, catoms_on_cells(world, lattice), robots, world);
}

}  // namespace meld::world
