// [[assembly]], what robots of several bodies consist of, and [[body]] assembly = "NAME", where they stand.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "physics/bodies/types.h"
#include "runtime/world/description/world.h"
#include "runtime/world/file/toml_reader.h"
#include "runtime/world/lists/positions_file.h"
#include "runtime/world/shapes/robots.h"

namespace meld::world {

// What a world says of robots, while it is read: first names and places, which regions and the numbers of catoms need, and when the shapes
// of bodies are known, what parts are like.
struct DescribedRobots {
    struct Kind {
        Assembly assembly;
        const toml::table* table = nullptr;
        std::vector<const toml::table*> parts;  // By part.
        std::vector<Vec3> at;                   // By part, in the frame of the robot, in diameters.
    };
    struct Frame {
        Vec3 at{};
        physics::Quat turn;
    };
    std::vector<Kind> kinds;
    std::vector<RobotGroup> groups;
    std::vector<std::vector<Frame>> frames;  // By group and robot.
    std::shared_ptr<Robots> robots;          // Null: the world describes none.
};

// All [[assembly]] tables of a world: names, places and connections of their parts.
DescribedRobots read_assemblies(TomlReader& reader, const toml::table& top);

// Places robots of the assembly that a [[body]] names, turned as its key `turned` says in addition; the centres of their parts follow the
// catoms that are placed already. Errors: there is no such assembly; `turned` is of other robots than there are; there are too many.
void place_robots(TomlReader& reader, const Section& body, std::vector<RobotPlace> places, DescribedRobots& described,
                  std::vector<PlacedCatom>& placed);

// After the last [[body]]: regions of the world may name robots and parts. `first_listed`: how many catoms come before the listed ones.
void number_robots(TomlReader& reader, std::uint64_t first_listed, DescribedRobots& described, World& world);

// What the bodies of all robots are like, and their joints. Compounds are known. Cost: linear in the joints of all robots.
void read_robots(TomlReader& reader, const DescribedRobots& described, PhysicsOptions& p);

}  // namespace meld::world
