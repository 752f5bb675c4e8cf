// Robots of several bodies: which catom is which part of which robot.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meld::world {

// What robots of one kind consist of.
struct Assembly {
    std::string name;
    std::vector<std::string> parts;  // Their names, in the order in which the catoms of a robot are numbered.
    // Parts that are held together rigidly, the earlier one first; sorted.
    std::vector<std::array<std::uint32_t, 2>> connections;
    std::string place;  // "world.toml:12:1"

    std::optional<std::uint32_t> part_named(std::string_view part) const;
    // Whether the part is connected to any other.
    bool connects(std::uint32_t part) const;
    bool connects(std::uint32_t one, std::uint32_t other) const;
};

// A unit quaternion, w first.
using Turn = std::array<double, 4>;

// Robots of one kind that one [[body]] of the world places. They are numbered one after the other, and so are their catoms.
struct RobotGroup {
    std::uint32_t assembly = 0;
    std::uint64_t first_catom = 0, first_robot = 0, robots = 0;
    std::vector<Turn> turns;  // Of each robot; empty: none is turned.
    std::string place;        // "world.toml:40:1"
};

// A catom as a part of a robot.
struct RobotPart {
    std::uint32_t group = 0, assembly = 0, part = 0;
    std::uint64_t robot = 0;
    std::uint64_t first_catom = 0;  // Of the robot.
};

// All robots of a world. Any thread may use it.
class Robots {
  public:
    // `groups`: in the order of their catoms, whose numbers count from that of the first listed one.
    Robots(std::vector<Assembly> assemblies, std::vector<RobotGroup> groups)
        : assemblies_(std::move(assemblies)), groups_(std::move(groups)) {}
    // How many catoms have numbers before the first listed one; until it is called, none.
    void number_from(std::uint64_t first_listed) { first_listed_ = first_listed; }

    const std::vector<Assembly>& assemblies() const { return assemblies_; }
    const std::vector<RobotGroup>& groups() const { return groups_; }
    std::uint64_t first_catom(const RobotGroup& group) const { return first_listed_ + group.first_catom; }
    std::uint64_t count() const { return groups_.empty() ? 0 : groups_.back().first_robot + groups_.back().robots; }
    // Nothing: the catom is of no robot. Cost: a search among the groups, and a division.
    std::optional<RobotPart> of(std::uint64_t catom) const;
    // How the robot is turned from the attitude of its description; null: not at all.
    const Turn* turn_of(const RobotPart& part) const;
    // Whether parts of any robot are connected.
    bool connects() const;

  private:
    std::vector<Assembly> assemblies_;
    std::vector<RobotGroup> groups_;
    std::uint64_t first_listed_ = 0;
};

}  // namespace meld::world
