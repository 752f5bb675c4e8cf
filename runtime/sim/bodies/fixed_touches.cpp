#include "runtime/sim/bodies/fixed_touches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/sim/bodies/divided_bodies.h"

namespace meld::sim {

namespace {

bool touch(const FixedBody& a, const FixedBody& b, double touch_m) {
    if (length(b.position_m - a.position_m) >= a.radius_m + b.radius_m + touch_m) return false;
    if (a.shape.is_sphere() && b.shape.is_sphere()) return true;
    return physics::nearer(a.shape, {a.position_m, a.orientation}, b.shape, {b.position_m, b.orientation}, touch_m);
}

void write(const FixedBody& body, ByteWriter& out) {
    out.write(body.id), out.write(body.position_m), out.write(body.radius_m), out.write(body.orientation);
    physics::write_shape(body.shape, out);
}

FixedBody read_body(ByteReader& in) {
    FixedBody body{.id = in.read<std::uint64_t>(), .position_m = in.read<physics::Vec3>(), .radius_m = in.read<double>()};
    body.orientation = in.read<physics::Quat>();
    body.shape = physics::read_shape(in);
    return body;
}

}  // namespace

std::vector<physics::TouchEvent> touches_among(Subdomain& subdomain, const std::vector<FixedBody>& mine, double max_radius_m,
                                               double touch_m) {
    MELD_EXPECT(mine.empty() || max_radius_m > 0, "{} bodies, the largest of {} m", mine.size(), max_radius_m);
    const double reach_m = 2 * max_radius_m + touch_m;
    ByteWriter bytes;
    for (const FixedBody& body : mine) write(body, bytes);
    // By cells as wide as the reach, so everything that touches a body is in its cell or a neighbouring one.
    using GridCell = std::array<std::int64_t, 3>;
    std::map<GridCell, std::vector<FixedBody>> cells;
    const auto cell_of = [&](physics::Vec3 p) {
        const auto at = [&](double x) { return static_cast<std::int64_t>(std::floor(x / reach_m)); };
        return GridCell{at(p.x), at(p.y), at(p.z)};
    };
    for (const auto& from : gather_bytes(subdomain, bytes))
        for (ByteReader in(from, "catoms that nothing moves"); !in.done();) {
            const FixedBody body = read_body(in);
            cells[cell_of(body.position_m)].push_back(body);
        }
    std::vector<physics::TouchEvent> touches;
    for (const auto& [cell, bodies] : cells)
        for (std::int64_t n = 0; n < 27; ++n) {
            const auto others = cells.find({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
            if (others == cells.end()) continue;
            for (const FixedBody& a : bodies)
                for (const FixedBody& b : others->second)
                    if (a.id < b.id && touch(a, b, touch_m))
                        touches.push_back({{static_cast<physics::BodyId>(a.id), static_cast<std::uint32_t>(b.id), false}, true});
        }
    std::sort(touches.begin(), touches.end());
    return touches;
}

}  // namespace meld::sim
