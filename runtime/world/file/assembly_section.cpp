#include "runtime/world/file/assembly_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "physics/bodies/symmetric.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/world/file/joint_section.h"
#include "runtime/world/file/motion_keys.h"
#include "runtime/world/file/physics_section.h"

namespace meld::world {

namespace {

using Kind = DescribedRobots::Kind;
using Frame = DescribedRobots::Frame;

// Of all robots of a world together.
constexpr std::uint64_t kMostRobotCatoms = 100'000'000;
// Of each coordinate of a part, in diameters; and of more turns, too few digits are left to say how a robot stands.
constexpr double kFarthestRobotPart = 1e6, kMostDegreesOfRobot = 1e6;

// Regions name it, so it is a word of theirs.
bool is_word(std::string_view text) {
    const Parsed<std::vector<Token>> tokens = tokenize(text);
    return tokens && tokens->size() == 2 && (*tokens)[0].kind == TokenKind::Word && (*tokens)[0].text == text;
}

void read_word(const Section& section, std::string_view what, std::string& name) {
    section.read("name", name);
    if (name.empty()) return section.wrong("name", fmt::format("{} has no name", what), "write name = \"hull\"");
    if (!is_word(name))
        section.wrong("name", fmt::format("'{}' is no word, and regions name it", name),
                      "use letters, digits and _, and begin with a letter");
}

void read_part(TomlReader& reader, const toml::table& table, Kind& kind) {
    std::vector<std::string_view> keys = body_keys();
    keys.insert(keys.end(), {"name", "at"});
    const Section section(reader, table, "[[assembly.part]]", keys);
    std::string name;
    read_word(section, "an [[assembly.part]]", name);
    if (kind.assembly.part_named(name))
        section.wrong("name", fmt::format("the assembly {} has two parts {}", kind.assembly.name, name), "give one of them another name");
    Vec3 at{};
    section.read("at", at);
    if (std::ranges::any_of(at, [](double x) { return !(std::abs(x) <= kFarthestRobotPart); }))
        section.wrong("at", "a part of a robot is more than a million diameters away", "write at = [1, 0, 0], in catom diameters");
    kind.assembly.parts.push_back(std::move(name));
    kind.parts.push_back(&table);
    kind.at.push_back(at);
}

// connections = [["hull", "nose"], ...]
void read_connections(TomlReader& reader, const Section& section, Assembly& assembly) {
    const toml::node* node = section.find("connections");
    if (node == nullptr) return;
    if (!node->is_array())
        return reader.wrong(node->source(), "[[assembly]] connections " + type_mismatch(*node, "an array of pairs of parts"));
    for (const toml::node& each : *node->as_array()) {
        const auto parts = read_two_parts(reader, each, assembly);
        if (!parts) return;
        assembly.connections.push_back({std::min((*parts)[0], (*parts)[1]), std::max((*parts)[0], (*parts)[1])});
    }
    std::ranges::sort(assembly.connections);
    const auto twice = std::ranges::unique(assembly.connections);
    assembly.connections.erase(twice.begin(), twice.end());
}

void read_assembly(TomlReader& reader, const toml::table& table, std::vector<Kind>& kinds) {
    const Section section(reader, table, "[[assembly]]", {"name", "part", "joint", "connections"});
    Kind kind;
    kind.table = &table;
    kind.assembly.place = reader.place(table.source());
    read_word(section, "an [[assembly]]", kind.assembly.name);
    if (std::ranges::any_of(kinds, [&](const Kind& other) { return other.assembly.name == kind.assembly.name; }))
        section.wrong("name", fmt::format("there are two assemblies {}", kind.assembly.name), "give one of them another name");
    each_table(reader, table, "assembly", "part", [&](const toml::table& part) { read_part(reader, part, kind); });
    if (kind.parts.empty())
        section.wrong("part", fmt::format("the assembly {} has no parts", kind.assembly.name), "write tables [[assembly.part]] behind it");
    read_connections(reader, section, kind.assembly);
    kinds.push_back(std::move(kind));
}

bool is_turned(const Vec3& turned) { return turned != Vec3{}; }

physics::Quat turn_of(const Vec3& degrees) {
    constexpr double kRadians = std::numbers::pi / 180;
    return is_turned(degrees) ? physics::turned_by({}, {kRadians * degrees[0], kRadians * degrees[1], kRadians * degrees[2]})
                              : physics::Quat{};
}

Vec3 rotated(const physics::Quat& turn, const Vec3& v) {
    const physics::Vec3 r = rotate(turn, physics::Vec3{v[0], v[1], v[2]});
    return {r.x, r.y, r.z};
}

// A point of the robot in the world.
Vec3 placed_at(const Frame& frame, const Vec3& point) {
    const Vec3 there = rotated(frame.turn, point);
    return {frame.at[0] + there[0], frame.at[1] + there[1], frame.at[2] + there[2]};
}

// turned = [0, 0, 90] for all, or one for each.
void read_turned(const Section& body, std::vector<RobotPlace>& places) {
    const toml::node* node = body.find("turned");
    if (node == nullptr) return;
    const toml::array* array = node->as_array();
    std::vector<Vec3> turned(1);
    if (array != nullptr && !array->empty() && (*array)[0].is_array())
        body.read("turned", turned);
    else
        body.read("turned", turned[0]);
    if (turned.size() != 1 && turned.size() != places.size())
        return body.wrong("turned", fmt::format("robots here: {}; vectors that turn them: {}", places.size(), turned.size()),
                          "write one vector, for all of them, or one for each");
    if (std::ranges::any_of(places, [](const RobotPlace& place) { return is_turned(place.turned); }))
        return body.wrong("turned", "the file of these robots says how they are turned, too", "take turned out, or the columns");
    for (std::size_t i = 0; i < places.size(); ++i) places[i].turned = turned[turned.size() == 1 ? 0 : i];
}

// The joints of a robot: those of its description, in its place.
void add_joints(const std::vector<JointOptions>& joints, const Frame& frame, std::uint64_t first_catom, PhysicsOptions& p) {
    for (const JointOptions& described : joints) {
        JointOptions& joint = p.joints.emplace_back(described);
        for (std::uint64_t& part : *joint.between) part += first_catom;
        if (joint.anchor) joint.anchor = placed_at(frame, *joint.anchor);
        joint.axis = rotated(frame.turn, joint.axis);
    }
}

std::vector<JointOptions> read_joints(TomlReader& reader, const Kind& kind) {
    std::vector<JointOptions> joints;
    each_table(reader, *kind.table, "assembly", "joint", [&](const toml::table& table) {
        JointOptions& joint = joints.emplace_back();
        read_assembly_joint(reader, table, kind.assembly, joint);
        if (!joint.between) return;
        const auto same = [&](const JointOptions& other) {
            return other.between && std::ranges::minmax(*other.between).min == std::ranges::minmax(*joint.between).min &&
                   std::ranges::minmax(*other.between).max == std::ranges::minmax(*joint.between).max;
        };
        const auto [one, other] = *joint.between;
        const auto named = [&](std::uint64_t part) { return kind.assembly.parts[part]; };
        if (std::ranges::any_of(joints.begin(), joints.end() - 1, same))
            reader.wrong(table.source(), fmt::format("{} and {} have two joints", named(one), named(other)), "leave one of them");
        if (kind.assembly.connects(static_cast<std::uint32_t>(one), static_cast<std::uint32_t>(other)))
            reader.wrong(table.source(), fmt::format("{} and {} have a joint, and are connected, which locks it", named(one), named(other)),
                         "take the joint out, or their pair out of connections");
    });
    return joints;
}

// What the bodies of all robots of a kind are like: a group for each part.
void add_groups(TomlReader& reader, const Kind& kind, PhysicsOptions& p) {
    for (std::size_t part = 0; part < kind.parts.size(); ++part) {
        std::vector<std::string_view> keys = body_keys();
        keys.insert(keys.end(), {"name", "at"});
        const Section section(reader, *kind.parts[part], "[[assembly.part]]", keys);
        CatomGroup& group = p.groups.emplace_back();
        group.place = reader.place(kind.parts[part]->source());
        const auto where = parse_region_text(fmt::format("assembly == {} && part == {}", kind.assembly.name, kind.assembly.parts[part]),
                                             reader.nameable());
        if (where) group.where = *where;
        read_body_keys(section, p.compounds, group);
    }
}

}  // namespace

DescribedRobots read_assemblies(TomlReader& reader, const toml::table& top) {
    DescribedRobots described;
    const toml::node* node = top.get("assembly");
    if (node == nullptr) return described;
    if (node->is_table()) {
        read_assembly(reader, *node->as_table(), described.kinds);
    } else if (node->is_array_of_tables()) {
        for (const toml::node& table : *node->as_array()) read_assembly(reader, *table.as_table(), described.kinds);
    } else {
        reader.wrong(node->source(), "assembly " + type_mismatch(*node, "tables [[assembly]]"));
    }
    return described;
}

void place_robots(TomlReader& reader, const Section& body, std::vector<RobotPlace> places, DescribedRobots& described,
                  std::vector<PlacedCatom>& placed) {
    std::string name;
    body.read("assembly", name);
    if (reader.error()) return;
    const auto kind = std::ranges::find_if(described.kinds, [&](const Kind& each) { return each.assembly.name == name; });
    if (kind == described.kinds.end()) {
        std::vector<std::string_view> known;
        for (const Kind& each : described.kinds) known.emplace_back(each.assembly.name);
        return body.wrong("assembly", fmt::format("there is no assembly '{}'", name),
                          known.empty() ? "describe it by [[assembly]]" : did_you_mean(name, known));
    }
    if (places.empty()) return body.wrong("positions", "no robot stands here", "list positions, or choose a larger shape");
    if (places.size() > kMostRobotCatoms / kind->parts.size())
        return body.wrong("assembly", fmt::format("{} robots of {} parts are too many", places.size(), kind->parts.size()),
                          fmt::format("place at most {} catoms of robots", kMostRobotCatoms));
    read_turned(body, places);
    const std::uint64_t robots = described.groups.empty() ? 0 : described.groups.back().first_robot + described.groups.back().robots;
    RobotGroup& group = described.groups.emplace_back();
    group.assembly = static_cast<std::uint32_t>(kind - described.kinds.begin());
    group.first_catom = placed.size(), group.first_robot = robots, group.robots = places.size();
    group.place = reader.place(body.source());
    const bool turned = std::ranges::any_of(places, [](const RobotPlace& place) { return is_turned(place.turned); });
    std::vector<Frame>& frames = described.frames.emplace_back();
    for (const RobotPlace& place : places) {
        if (!(std::hypot(place.turned[0], place.turned[1], place.turned[2]) <= kMostDegreesOfRobot))
            return body.wrong("turned", "a robot is turned by more than a million degrees",
                              "write turned = [0, 0, 90]: about z, by 90 degrees");
        const Frame& frame = frames.emplace_back(Frame{place.at, turn_of(place.turned)});
        if (turned) group.turns.push_back({frame.turn.w, frame.turn.x, frame.turn.y, frame.turn.z});
        for (const Vec3& at : kind->at) placed.push_back({.position = placed_at(frame, at), .radius = {}, .mass = {}});
    }
}

void number_robots(TomlReader& reader, std::uint64_t first_listed, DescribedRobots& described, World& world) {
    if (described.kinds.empty()) return;
    std::vector<Assembly> assemblies;
    for (const Kind& kind : described.kinds) {
        assemblies.push_back(kind.assembly);
        const auto is_kind = [&](const RobotGroup& group) { return &described.kinds[group.assembly] == &kind; };
        if (std::ranges::none_of(described.groups, is_kind))
            world.warnings.push_back(fmt::format("{}: no robot is a {}; [[body]] assembly = \"{}\" places some", kind.assembly.place,
                                                 kind.assembly.name, kind.assembly.name));
    }
    described.robots = std::make_shared<Robots>(std::move(assemblies), described.groups);
    described.robots->number_from(first_listed);
    world.robots = described.robots;
    reader.know_robots(described.robots);
}

void read_robots(TomlReader& reader, const DescribedRobots& described, PhysicsOptions& p) {
    for (std::size_t i = 0; i < described.kinds.size(); ++i) {
        const Kind& kind = described.kinds[i];
        const std::vector<JointOptions> joints = read_joints(reader, kind);
        const std::size_t before = p.groups.size();
        add_groups(reader, kind, p);
        if (reader.error()) return;
        bool placed = false;
        for (std::size_t g = 0; g < described.groups.size(); ++g) {
            const RobotGroup& group = described.groups[g];
            if (group.assembly != i) continue;
            placed = true;
            std::uint64_t first = described.robots->first_catom(group);
            for (const Frame& frame : described.frames[g]) add_joints(joints, frame, std::exchange(first, first + kind.parts.size()), p);
        }
        // Nothing would be in their regions.
        if (!placed) p.groups.resize(before);
    }
}

}  // namespace meld::world
