#include "physics/collision/sight.h"

namespace meld::physics {

std::optional<double> first_on(const Obstacles& obstacles, const Ray& ray) {
    std::optional<double> first;
    for (std::size_t i = 0; i < obstacles.count(); ++i)
        if (const std::optional<double> met = obstacles.first_on(i, ray); met && (!first || *met < *first)) first = met;
    return first;
}

namespace {

Ray between(const RayGrid& bodies, RayGrid::Index from, RayGrid::Index to) {
    const Vec3 start = bodies.thing(from).centre;
    return {start, bodies.thing(to).centre - start};
}

bool meets_none(const Obstacles& obstacles, const Ray& ray) {
    for (std::size_t i = 0; i < obstacles.count(); ++i)
        if (obstacles.first_on(i, ray)) return false;
    return true;
}

}  // namespace

bool is_free(const Obstacles& obstacles, const RayGrid& bodies, RayGrid::Index from, RayGrid::Index to) {
    return meets_none(obstacles, between(bodies, from, to));
}

bool in_sight(const Obstacles& obstacles, const RayGrid& bodies, RayGrid::Index from, RayGrid::Index to) {
    const Ray ray = between(bodies, from, to);
    return meets_none(obstacles, ray) && !bodies.blocks(ray, from, to);
}

}  // namespace meld::physics
