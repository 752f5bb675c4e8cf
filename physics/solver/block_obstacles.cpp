// Contacts with obstacles: which surfaces a body touches, and which lane takes which.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "physics/collision/ode_library.h"
#include "physics/solver/block_engine.h"

namespace meld::physics {

namespace {

// A lane of the contacts with obstacles: one of the places where a body may touch one.
struct Lane {
    Batch* batch;
    int lane;
    ObstacleLane what;

    std::uint32_t body() const { return batch->a[lane]; }
};

// Those of a block that are in use. The parts of one contact lie in different batches, because they share the body; in the result they are
// together.
void list_lanes(std::span<Batch> batches, const ObstacleLane* lanes_of, std::size_t bodies, std::vector<Lane>& found) {
    found.clear();
    for (std::size_t n = 0; n < batches.size(); ++n)
        for (int i = 0; i < kLanes; ++i)
            if (batches[n].a[i] < bodies) found.push_back({&batches[n], i, lanes_of[n * kLanes + static_cast<std::size_t>(i)]});
    if (std::ranges::all_of(found, [](const Lane& lane) { return lane.what.part == 0; })) return;
    std::ranges::sort(found, {}, [](const Lane& lane) { return std::tuple(lane.body(), lane.what.obstacle, lane.what.part); });
}

// Each lane takes the surface whose normal is most similar to its last one; those left over touch nothing.
void take_surfaces(std::span<const Lane> lanes, std::span<const SurfaceContact> surfaces) {
    std::array<bool, kMaxSurfaceContacts> used{};
    for (const Lane& lane : lanes) {
        Batch& batch = *lane.batch;
        const int i = lane.lane;
        std::size_t best = surfaces.size();
        double likeness = -2;
        for (std::size_t c = 0; c < surfaces.size(); ++c) {
            const Vec3 normal = surfaces[c].normal;
            const double like = -(normal.x * static_cast<double>(batch.nx[i]) + normal.y * static_cast<double>(batch.ny[i]) +
                                  normal.z * static_cast<double>(batch.nz[i]));
            if (!used[c] && like > likeness) best = c, likeness = like;
        }
        if (best == surfaces.size()) {
            batch.gap[i] = kNoContactGap;
            batch.normal_impulse[i] = batch.tx[i] = batch.ty[i] = batch.tz[i] = 0;
            continue;
        }
        used[best] = true;
        const SurfaceContact& surface = surfaces[best];
        const float nx = static_cast<float>(-surface.normal.x), ny = static_cast<float>(-surface.normal.y),
                    nz = static_cast<float>(-surface.normal.z);
        const float along = batch.tx[i] * nx + batch.ty[i] * ny + batch.tz[i] * nz;
        batch.nx[i] = nx, batch.ny[i] = ny, batch.nz[i] = nz;
        batch.gap[i] = static_cast<float>(surface.gap_m);
        batch.tx[i] -= along * nx, batch.ty[i] -= along * ny, batch.tz[i] -= along * nz;
    }
}

}  // namespace

// How many surfaces of an obstacle the body in a slot touches or will soon.
template <class Fails>
int BlockEngine::surfaces_near(int worker, std::uint32_t slot, std::uint32_t obstacle, double dt_s,
                               std::array<SurfaceContact, kMaxSurfaceContacts>& surfaces, const Fails& fails) {
    const Bodies& bodies = world_.bodies;
    const Place& p = bodies.place[slot];
    const BodyId id = bodies.properties[slot].id;
    // On uneven ground, looking too far ahead would find more contacts than a body has lanes for.
    const double ahead = world_.obstacles.parts(obstacle) == 1 ? list_reach_m() : margin_m_;
    int count = 0;
    try {
        count = world_.obstacles.collide(worker, obstacle, {p.x, p.y, p.z}, p.radius, ahead, surfaces);
    } catch (const OdeFailure& wrong) {
        fails(id, {fmt::format("ODE cannot collide body {} with an obstacle ({})", id, wrong.what()), "Check the obstacle's shape"});
    }
    for (int c = 0; c < count; ++c)
        if (auto fine = world_.check_depth(id, p.radius, obstacle, -surfaces[static_cast<std::size_t>(c)].gap_m); !fine)
            fails(id, fine.error());
    // A body from farther away would be behind a wall before it is noticed, and for a near one only its path tells what it will touch.
    Vec3 path = kStepsAhead * dt_s * velocity_of(bodies.velocity[slot]);
    if (world_.obstacles.moves(obstacle)) path = path - kStepsAhead * dt_s * world_.obstacles.frame(obstacle).velocity_at({p.x, p.y, p.z});
    const auto touches = [&](int c) { return surfaces[static_cast<std::size_t>(c)].gap_m <= kLookAheadShare * 2 * smallest_radius_m_; };
    const bool apart = count == 0 || !touches(0);
    if (dot(path, path) <= ahead * ahead || !(apart || world_.obstacles.can_be_met_again(obstacle))) return count;
    while (count > 0 && !touches(count - 1)) --count;
    const std::span<const SurfaceContact> touched(surfaces.data(), static_cast<std::size_t>(count));
    const auto met =
        touched.size() < surfaces.size() ? world_.obstacles.meet(obstacle, {p.x, p.y, p.z}, p.radius, path, touched) : std::nullopt;
    if (met) surfaces[static_cast<std::size_t>(count++)] = *met;
    return count;
}

tl::expected<void, std::pair<BodyId, Error>> BlockEngine::refresh_obstacles(int worker, std::uint32_t block, double dt_s) {
    thread_local std::vector<Lane> found;
    list_lanes(contacts_.obstacle_contacts(block), contacts_.obstacle_lanes(block), world_.bodies.count(), found);
    std::array<SurfaceContact, kMaxSurfaceContacts> surfaces;
    std::optional<std::pair<BodyId, Error>> failure;
    const auto fails = [&](BodyId body, Error error) {
        if (!failure || body < failure->first) failure = std::pair(body, std::move(error));
    };
    for (std::size_t begin = 0; begin < found.size();) {
        const Lane& first = found[begin];
        // The other parts of the contact.
        std::size_t end = begin + 1;
        while (end < found.size() && found[end].what.part > 0 && found[end].body() == first.body() &&
               found[end].what.obstacle == first.what.obstacle)
            ++end;
        const int count = surfaces_near(worker, first.body(), first.what.obstacle, dt_s, surfaces, fails);
        take_surfaces(std::span(found).subspan(begin, end - begin), std::span(surfaces).first(static_cast<std::size_t>(count)));
        begin = end;
    }
    if (failure) return tl::unexpected(std::move(*failure));
    return {};
}

}  // namespace meld::physics
