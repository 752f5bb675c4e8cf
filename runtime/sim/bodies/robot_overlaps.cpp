#include "runtime/sim/bodies/robot_overlaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace meld::sim {

namespace {

using GridCell = std::array<std::int64_t, 3>;

struct Part {
    GridCell cell{};
    physics::BodyId body = 0;
};

// What is less, in shares of the least thickness of any body, moves nothing that anybody sees.
constexpr double kTolerated = 0.01;

class RobotCheck {
  public:
    RobotCheck(const world::World& world, const PhysicsScene& physics, const BodyMaker& bodies)
        : world_(world),
          robots_(*world.robots),
          scene_(*physics.scene),
          bodies_(bodies),
          tolerated_m_(kTolerated * 2 * bodies.radii().least) {}

    Result<void> connections() const {
        for (const world::RobotGroup& group : robots_.groups()) {
            const world::Assembly& assembly = robots_.assemblies()[group.assembly];
            for (std::uint64_t robot = 0; robot < group.robots; ++robot)
                for (const auto& pair : assembly.connections)
                    if (auto fine = connected(assembly, robots_.first_catom(group) + robot * assembly.parts.size(), pair); !fine)
                        return fine;
        }
        return {};
    }

    Result<void> overlaps() const {
        const std::vector<Part> parts = by_cell();
        for (const Part& part : parts)
            for (std::int64_t n = 0; n < 27; ++n) {
                const GridCell cell{part.cell[0] + n % 3 - 1, part.cell[1] + n / 3 % 3 - 1, part.cell[2] + n / 9 - 1};
                for (auto other = std::ranges::lower_bound(parts, cell, {}, &Part::cell); other != parts.end() && other->cell == cell;
                     ++other)
                    if (part.body < other->body && overlap(part.body, other->body)) return overlapping(part.body, other->body);
            }
        return {};
    }

  private:
    // All bodies of robots by cells as wide as the largest body, so what overlaps one is in its cell or beside that.
    std::vector<Part> by_cell() const {
        const double width_m = 2 * bodies_.radii().max;
        const auto at = [&](double x) { return static_cast<std::int64_t>(std::floor(x / width_m)); };
        std::vector<Part> parts;
        for (const world::RobotGroup& group : robots_.groups()) {
            const std::uint64_t first = robots_.first_catom(group);
            const std::uint64_t count = group.robots * robots_.assemblies()[group.assembly].parts.size();
            for (std::uint64_t id = first; id < first + count; ++id) {
                const auto body = static_cast<physics::BodyId>(id);
                const physics::Vec3 centre = scene_.pose(body).centre_m;
                parts.push_back({{at(centre.x), at(centre.y), at(centre.z)}, body});
            }
        }
        std::ranges::sort(parts, [](const Part& a, const Part& b) { return a.cell != b.cell ? a.cell < b.cell : a.body < b.body; });
        return parts;
    }

    bool overlap(physics::BodyId one, physics::BodyId other) const {
        const double far_m = scene_.radius(one) + scene_.radius(other);
        if (length(scene_.pose(one).centre_m - scene_.pose(other).centre_m) >= far_m - tolerated_m_) return false;
        if (scene_.joined(one, other) || scene_.together(one, other) || (scene_.fixed(one) && scene_.fixed(other))) return false;
        return scene_.nearer(one, other, -tolerated_m_);
    }

    Result<void> overlapping(physics::BodyId one, physics::BodyId other) const {
        const world::RobotPart a = *robots_.of(one), b = *robots_.of(other);
        const world::Assembly &of_a = robots_.assemblies()[a.assembly], &of_b = robots_.assemblies()[b.assembly];
        const std::string &first = of_a.parts[a.part], &second = of_b.parts[b.part];
        if (a.robot == b.robot)
            return fail(
                fmt::format("{}: {} and {} of a {} overlap, and have neither a joint nor a connection, so they would push each other "
                            "away",
                            of_a.place, first, second, of_a.name),
                fmt::format("Move one of them, or write [[assembly.joint]] between = [\"{}\", \"{}\"], or connections = [[\"{}\", "
                            "\"{}\"]]",
                            first, second, first, second));
        return fail(fmt::format("{}: robots {} and {} overlap: {} of the {} @{}, and {} of the {} @{}", robots_.groups()[b.group].place,
                                a.robot, b.robot, first, of_a.name, one, second, of_b.name, other),
                    "Place them farther apart");
    }

    Result<void> connected(const world::Assembly& assembly, std::uint64_t first, const std::array<std::uint32_t, 2>& pair) const {
        const auto one = static_cast<physics::BodyId>(first + pair[0]), other = static_cast<physics::BodyId>(first + pair[1]);
        // Groups of the world may say otherwise of one of them.
        if (scene_.connected(one, other) || bodies_.connected_in(one) != bodies_.connected_in(other) ||
            bodies_.connected_in(one).value_or(0) < world_.physics.groups.size())
            return {};
        return fail(
            fmt::format("{}: {} and {} are connected, and do not touch", assembly.place, assembly.parts[pair[0]], assembly.parts[pair[1]]),
            "Move them together, or take their pair out of connections");
    }

    const world::World& world_;
    const world::Robots& robots_;
    const physics::Scene& scene_;
    const BodyMaker& bodies_;
    const double tolerated_m_;
};

}  // namespace

Result<void> check_robots(const world::World& world, const PhysicsScene& physics, const BodyMaker& bodies) {
    const RobotCheck check(world, physics, bodies);
    if (auto fine = check.connections(); !fine) return fine;
    return check.overlaps();
}

}  // namespace meld::sim
