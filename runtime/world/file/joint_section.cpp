#include "runtime/world/file/joint_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/file/motion_keys.h"

namespace meld::world {

namespace {

constexpr double kMostNumber = std::numeric_limits<double>::max();
// Of each coordinate, in diameters.
constexpr double kFarthestAnchor = 1e9;

// [a, b], if both are numbers.
std::optional<std::array<double, 2>> two_numbers(const toml::node& node) {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->size() != 2 || !(*array)[0].is_number() || !(*array)[1].is_number()) return std::nullopt;
    return std::array{*(*array)[0].value<double>(), *(*array)[1].value<double>()};
}

void read_anchor(const Section& section, JointOptions& joint) {
    if (!section.has("anchor")) return;
    Vec3 anchor{};
    section.read("anchor", anchor);
    for (const double component : anchor)
        if (std::abs(component) > kFarthestAnchor)
            return section.wrong("anchor", "the anchor of a joint is too far away",
                                 "write where it is, in diameters: anchor = [0.5, 0, 0]");
    joint.anchor = anchor;
}

void read_bodies(const Section& section, JointOptions& joint) {
    if (section.has("between") == section.has("where"))
        return section.wrong("between", "a [[motion.joint]] needs either two catoms or a region",
                             "write between = [0, 1], or where = \"id < 10\" for all that touch there");
    if (auto where = section.read_region("where")) joint.where = *where;
    const toml::node* node = section.find("between");
    if (node == nullptr) {
        if (section.has("anchor"))
            section.wrong("anchor", "one anchor cannot be that of several joints", "name two catoms, between = [0, 1], or take anchor out");
        return;
    }
    const toml::array* array = node->as_array();
    const bool two = array != nullptr && array->size() == 2 && (*array)[0].is_integer() && (*array)[1].is_integer();
    const std::int64_t first = two ? *(*array)[0].value<std::int64_t>() : -1, second = two ? *(*array)[1].value<std::int64_t>() : -1;
    if (first < 0 || second < 0 || first == second)
        return section.wrong("between", "a joint is not between two catoms", "write the numbers of two: between = [0, 1]");
    joint.between = {static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(second)};
    read_anchor(section, joint);
}

// A ball moves along nothing; and wherever the two halves of a slider are, they move along the same axis.
void refuse_keys_of_other_joints(const Section& section, std::string_view kind) {
    refuse_keys_of_others(
        section, kind,
        {{"hinge", {"anchor", "axis", "limits", "torque", "speed", "response", "motor", "servo", "brake", "stiffness", "damping", "rest"}},
         {"slider", {"axis", "limits", "force", "speed", "response", "motor", "servo", "brake", "stiffness", "damping", "rest"}},
         {"ball", {"anchor"}}});
}

void read_limits(const Section& section, JointOptions& joint) {
    const toml::node* node = section.find("limits");
    if (node == nullptr) return;
    joint.limits = two_numbers(*node);
    if (!joint.limits || !((*joint.limits)[0] <= 0 && (*joint.limits)[1] >= 0))
        section.wrong("limits", "the limits of a joint are not around 0, where it is at the start",
                      "write limits = [-90, 90]; inf stands for none");
}

// At most one of motor, servo and brake acts at the start.
void read_drive(const Section& section, JointOptions& joint) {
    const bool hinge = joint.kind == "hinge";
    section.read_number(hinge ? "torque" : "force", joint.strength, 0, kMostNumber);
    double value = 1;
    if (section.has("speed")) section.read_positive("speed", value), joint.speed = value;
    value = 1;
    if (section.has("response")) section.read_seconds("response", value), joint.response = value;
    int drives = 0;
    for (const std::string_view key : {"motor", "servo"})
        if (section.has(key)) section.read_number(key, joint.target), joint.drive = key, ++drives;
    bool brake = false;
    section.read("brake", brake);
    if (brake) joint.drive = "brake", ++drives;
    if (drives > 1) section.wrong("motor", "a joint does two things at the start", "leave one of motor, servo and brake");
    if (joint.strength == 0)
        for (const std::string_view key : {"motor", "servo", "brake", "speed", "response"})
            if (section.has(key))
                section.wrong(key, fmt::format("a joint without {} has no motor", hinge ? "torque" : "force"),
                              hinge ? "write torque = 10, in N m" : "write force = 10, in N");
}

void read_spring(const Section& section, JointOptions& joint) {
    section.read_number("stiffness", joint.stiffness, 0, kMostNumber);
    section.read_number("damping", joint.damping, 0, kMostNumber);
    section.read_number("rest", joint.rest);
    const bool spring = joint.stiffness > 0 || joint.damping > 0;
    if (section.has("rest") && joint.stiffness == 0)
        section.wrong("rest", "a joint without stiffness has no spring", "write stiffness = 10");
    if (spring && joint.strength > 0)
        section.wrong("stiffness", "a joint has a spring or a motor", "take stiffness and damping out, or the motor");
}

// The keys that say what a joint is like, whoever it is between.
const std::vector<std::string_view> kKeys = {"kind",    "anchor",   "axis",           "limits",         "torque", "force",
                                             "speed",   "response", "motor",          "servo",          "brake",  "stiffness",
                                             "damping", "rest",     "breaking_force", "breaking_torque"};

std::vector<std::string_view> with_keys(std::initializer_list<std::string_view> more) {
    std::vector<std::string_view> all = kKeys;
    all.insert(all.end(), more);
    return all;
}

void read_kind(const Section& section, JointOptions& joint) {
    section.read_choice("kind", joint.kind, {"hinge", "slider", "ball"});
    refuse_keys_of_other_joints(section, joint.kind);
}

void read_working(const Section& section, JointOptions& joint) {
    read_breaking(section, joint.breaking_force, joint.breaking_torque);
    if (joint.kind == "ball") return;
    section.read("axis", joint.axis);
    const double largest = std::max({std::abs(joint.axis[0]), std::abs(joint.axis[1]), std::abs(joint.axis[2])});
    if (!(largest > 0)) section.wrong("axis", "the axis of a joint has no direction", "write axis = [0, 0, 1]");
    // Only the direction counts, and the square of a length may be more or less than a number can be.
    constexpr double kMuch = 1e100;
    if (largest > kMuch || (largest > 0 && largest < 1 / kMuch))
        for (double& component : joint.axis) component /= largest;
    read_limits(section, joint);
    read_drive(section, joint);
    read_spring(section, joint);
}

}  // namespace

void read_joint(TomlReader& reader, const toml::table& table, JointOptions& joint) {
    const Section section(reader, table, "[[motion.joint]]", with_keys({"between", "where"}));
    joint.place = reader.place(table.source());
    read_kind(section, joint);
    read_bodies(section, joint);
    read_working(section, joint);
}

std::optional<std::array<std::uint32_t, 2>> read_two_parts(TomlReader& reader, const toml::node& node, const Assembly& assembly) {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->size() != 2 || !(*array)[0].is_string() || !(*array)[1].is_string()) {
        reader.wrong(node.source(), "these are not two parts", "write their names: [\"hull\", \"left\"]");
        return std::nullopt;
    }
    std::array<std::uint32_t, 2> parts{};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::string& name = **(*array)[i].as_string();
        const std::optional<std::uint32_t> part = assembly.part_named(name);
        if (!part) {
            const std::vector<std::string_view> known(assembly.parts.begin(), assembly.parts.end());
            reader.wrong((*array)[i].source(), fmt::format("the assembly {} has no part '{}'", assembly.name, name),
                         did_you_mean(name, known));
            return std::nullopt;
        }
        parts[i] = *part;
    }
    if (parts[0] != parts[1]) return parts;
    reader.wrong(node.source(), fmt::format("the part {} is named twice", assembly.parts[parts[0]]), "name two parts");
    return std::nullopt;
}

void read_assembly_joint(TomlReader& reader, const toml::table& table, const Assembly& assembly, JointOptions& joint) {
    const Section section(reader, table, "[[assembly.joint]]", with_keys({"between"}));
    joint.place = reader.place(table.source());
    read_kind(section, joint);
    if (const toml::node* node = section.find("between")) {
        if (const auto parts = read_two_parts(reader, *node, assembly)) joint.between = {(*parts)[0], (*parts)[1]};
    } else {
        section.wrong("between", "an [[assembly.joint]] is between no parts", "write between = [\"hull\", \"left\"]");
    }
    read_anchor(section, joint);
    read_working(section, joint);
}

void read_joint_kind(TomlReader& reader, const toml::table& table, JointOptions& kind) {
    const Section section(reader, table, "[[motion.joint_kind]]", with_keys({"reach"}));
    kind.place = reader.place(table.source());
    read_kind(section, kind);
    read_anchor(section, kind);
    section.read_number("reach", kind.reach, 0, kFarthestAnchor);
    read_working(section, kind);
}

}  // namespace meld::world
