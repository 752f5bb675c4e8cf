#include "runtime/world/file/obstacle_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/description/obstacles.h"
#include "runtime/world/file/motion_keys.h"
#include "runtime/world/file/mover_section.h"
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

constexpr std::array<std::string_view, 7> kKinds = {"plane", "box", "terrain", "mesh", "sphere", "cylinder", "capsule"};

// Of the keys that are there.
void refuse_keys(const Section& section, const ObstacleOptions& obstacle) {
    refuse_keys_of_others(section, obstacle.form.compound ? "compound" : obstacle.kind,
                          {{"plane", {"normal", "offset"}},
                           {"box", {"centre", "size", "degrees", "turned", "rounding"}},
                           {"terrain", {"centre", "cell", "heights"}},
                           {"mesh", {"shape"}},
                           {"sphere", {"centre", "diameter"}},
                           {"cylinder", {"centre", "diameter", "height", "rounding", "turned"}},
                           {"capsule", {"centre", "diameter", "length", "turned"}},
                           {"compound", {"centre", "turned"}}});
}

void read_kind(const Section& section, const std::string& name, std::span<const CompoundForm> compounds, ObstacleOptions& obstacle) {
    std::string kind = obstacle.kind;
    section.read("kind", kind);
    const auto compound = std::ranges::find(compounds, kind, &CompoundForm::name);
    if (std::ranges::find(kKinds, kind) != kKinds.end()) {
        obstacle.kind = kind;
    } else if (compound != compounds.end()) {
        obstacle.kind = obstacle.form.kind = kind, obstacle.form.compound = static_cast<std::size_t>(compound - compounds.begin());
    } else {
        std::vector<std::string_view> choices(kKinds.begin(), kKinds.end());
        for (const CompoundForm& known : compounds) choices.push_back(known.name);
        section.wrong("kind", fmt::format("{} kind = \"{}\" does not exist", name, kind), did_you_mean(kind, choices));
    }
}

// How large a solid is, and how it is turned.
void read_solid(const Section& section, ObstacleOptions& obstacle) {
    constexpr double kMostDegrees = 1e6;
    section.read("turned", obstacle.turned);
    if (!(std::hypot(obstacle.turned[0], obstacle.turned[1], obstacle.turned[2]) <= kMostDegrees))
        section.wrong("turned", "an obstacle is turned by more than a million degrees",
                      "write turned = [0, 0, 90]: about z, by 90 degrees");
    if (section.has("turned") && section.has("degrees"))
        section.wrong("degrees", "a box is turned by degrees about z, and by turned",
                      fmt::format("take degrees out; turned = [0, 0, {}] is the same", obstacle.degrees));
    obstacle.form.kind = obstacle.kind;
    // Unless it is given.
    obstacle.form.rounding = 0;
    section.read_positive("diameter", obstacle.diameter);
    obstacle.form.length = obstacle.kind == "cylinder" ? 1 : 2;
    section.read_positive(obstacle.kind == "cylinder" ? "height" : "length", obstacle.form.length);
    section.read_number("rounding", *obstacle.form.rounding, 0);
    const double least = obstacle.kind == "box" ? std::ranges::min(obstacle.size) : std::min(obstacle.form.length, obstacle.diameter);
    if (section.has("rounding") && !(2 * *obstacle.form.rounding < least))
        section.wrong("rounding", fmt::format("edges rounded by {} leave nothing of the {}", *obstacle.form.rounding, obstacle.kind),
                      fmt::format("write less than half of its least edge, {}", least / 2));
}

void read_obstacle(TomlReader& reader, const toml::table& table, const std::string& name, Touched touched,
                   std::span<const CompoundForm> compounds, ObstacleOptions& obstacle) {
    std::vector<std::string_view> keys = {"kind",    "normal", "offset",   "centre", "size",     "degrees", "cell",
                                          "heights", "shape",  "diameter", "height", "rounding", "length",  "turned"};
    if (touched == Touched::Yes)
        keys.insert(keys.end(), {"friction", "restitution", "rolling_friction", "spinning_friction", "belt", "swing", "tilt", "frequency",
                                 "phase", "spin", "pivot"});
    const Section section(reader, table, name, keys);
    obstacle.place = reader.place(table.source());
    read_kind(section, name, compounds, obstacle);
    refuse_keys(section, obstacle);
    section.read("normal", obstacle.normal);
    section.read_number("offset", obstacle.offset);
    section.read("centre", obstacle.centre);
    section.read("size", obstacle.size);
    section.read_number("degrees", obstacle.degrees);
    if (is_solid(obstacle)) read_solid(section, obstacle);
    section.read_positive("cell", obstacle.cell);
    if (obstacle.kind == "terrain") read_heights(reader, section, name, obstacle);
    if (obstacle.kind == "mesh") read_mesh(section, obstacle);
    if (touched == Touched::No) return;
    section.read("belt", obstacle.belt);
    read_prescribed(reader, section, table, obstacle.motion);
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
                    std::span<const CompoundForm> compounds, std::vector<ObstacleOptions>& all) {
    const toml::node* node = table.get("obstacle");
    if (!node) return;
    const std::string name = fmt::format("[[{}.obstacle]]", owner);
    if (node->is_table()) return read_obstacle(reader, *node->as_table(), name, touched, compounds, all.emplace_back());
    if (!node->is_array_of_tables())
        return reader.wrong(node->source(), fmt::format("[{}] obstacle {}", owner, type_mismatch(*node, "tables " + name)));
    for (const toml::node& each : *node->as_array()) read_obstacle(reader, *each.as_table(), name, touched, compounds, all.emplace_back());
}

}  // namespace meld::world
