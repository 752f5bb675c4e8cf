#include "runtime/world/file/obstacle_section.h"

#include <fmt/format.h>

#include <initializer_list>
#include <limits>
#include <string>

#include "runtime/world/file/motion_keys.h"
#include "runtime/world/shapes/surface.h"

namespace meld::world {
namespace {

void read_heights(TomlReader& reader, const Section& section, std::string_view name, ObstacleOptions& obstacle) {
    const toml::node* node = section.find("heights");
    const auto wrong = [&](const toml::node& at) {
        reader.wrong(at.source(), fmt::format("{} heights are not rows of numbers, [[0, 0], [0, 1]]", name));
    };
    if (!node) return section.wrong("heights", "a terrain has no heights", "write heights = [[0, 0], [0, 1]], a row along x for each y");
    if (!node->is_array()) return wrong(*node);
    for (const toml::node& row : *node->as_array()) {
        if (!row.is_array()) return wrong(row);
        std::vector<double>& heights = obstacle.heights.emplace_back();
        for (const toml::node& height : *row.as_array()) {
            if (!height.is_number()) return wrong(height);
            heights.push_back(*height.value<double>());
        }
        if (heights.size() != obstacle.heights[0].size())
            return reader.wrong(row.source(), "the rows of a terrain's heights are of different lengths");
    }
    if (obstacle.heights.size() < 2 || obstacle.heights[0].size() < 2)
        reader.wrong(node->source(), "a terrain has fewer than two rows of two heights");
}

void read_mesh(const Section& section, ObstacleOptions& obstacle) {
    if (!section.has("shape")) return section.wrong("shape", "a mesh has no shape", "write shape = \"mesh('part.stl', size = 20)\"");
    const std::optional<Shape> shape = section.read_shape("shape");
    if (!shape) return;
    obstacle.shape = *shape;
    if (!surface(*shape))
        section.wrong("shape", fmt::format("the shape {} of an obstacle is not one mesh", shape->text()),
                      "write mesh('part.stl', ...), if need be inside move, rotate and scale");
}

void read_obstacle(TomlReader& reader, const toml::table& table, const std::string& name, Touched touched, ObstacleOptions& obstacle) {
    const std::initializer_list<std::string_view> of_form = {"kind",    "normal", "offset",  "centre", "size",
                                                             "degrees", "cell",   "heights", "shape"};
    const std::initializer_list<std::string_view> all = {
        "kind",     "normal",      "offset",           "centre",           "size", "degrees", "cell", "heights", "shape",
        "friction", "restitution", "rolling_friction", "spinning_friction"};
    const Section section(reader, table, name, touched == Touched::Yes ? all : of_form);
    obstacle.place = reader.place(table.source());
    section.read_choice("kind", obstacle.kind, {"plane", "box", "terrain", "mesh"});
    refuse_keys_of_others(section, obstacle.kind,
                          {{"plane", {"normal", "offset"}},
                           {"box", {"centre", "size", "degrees"}},
                           {"terrain", {"centre", "cell", "heights"}},
                           {"mesh", {"shape"}}});
    section.read("normal", obstacle.normal);
    section.read_number("offset", obstacle.offset);
    section.read("centre", obstacle.centre);
    section.read("size", obstacle.size);
    section.read_number("degrees", obstacle.degrees);
    section.read_positive("cell", obstacle.cell);
    if (obstacle.kind == "terrain") read_heights(reader, section, name, obstacle);
    if (obstacle.kind == "mesh") read_mesh(section, obstacle);
    if (touched == Touched::Yes)
        read_surface(section, {obstacle.friction, obstacle.restitution, obstacle.rolling_friction, obstacle.spinning_friction});
}

}  // namespace

void read_surface(const Section& section, const SurfaceKeys& surface) {
    constexpr double kMost = std::numeric_limits<double>::max();
    const auto read = [&](const char* key, std::optional<double>& value, double most) {
        double number = 0;
        if (section.has(key)) section.read_number(key, number, 0, most), value = number;
    };
    read("friction", surface.friction, kMost);
    read("restitution", surface.restitution, 1);
    read("rolling_friction", surface.rolling_friction, kMost);
    read("spinning_friction", surface.spinning_friction, kMost);
}

void read_obstacles(TomlReader& reader, const toml::table& table, std::string_view owner, Touched touched,
                    std::vector<ObstacleOptions>& all) {
    const toml::node* node = table.get("obstacle");
    if (!node) return;
    const std::string name = fmt::format("[[{}.obstacle]]", owner);
    if (node->is_table()) return read_obstacle(reader, *node->as_table(), name, touched, all.emplace_back());
    if (!node->is_array_of_tables())
        return reader.wrong(node->source(), fmt::format("[{}] obstacle {}", owner, type_mismatch(*node, "tables " + name)));
    for (const toml::node& each : *node->as_array()) read_obstacle(reader, *each.as_table(), name, touched, all.emplace_back());
}

}  // namespace meld::world
