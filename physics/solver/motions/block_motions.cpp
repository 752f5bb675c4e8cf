// What moves as the world says in the block engine: fixed bodies with prescribed motions, and the belts of obstacles.
#include "physics/solver/block_engine.h"

namespace meld::physics {

// From the end of a step on they are those of the next one's first substep: its relaxation sweep and the next list see them.
void BlockEngine::prescribe_velocities(const StepTimes& times, Workers& workers) {
    if (world_.prescribed.empty()) return;
    world_.prescribed.set_velocities(world_.bodies, world_.composites, times.start_s(world_.tick, substep_),
                                     times.start_s(world_.tick, substep_ + 1));
    // Also of those that come to rest for a moment.
    world_.composites.set_all_velocities(world_.bodies, workers);
}

void BlockEngine::prescribe_places(const StepTimes& times) {
    if (world_.prescribed.empty()) return;
    Bodies& bodies = world_.bodies;
    world_.prescribed.place(bodies, world_.composites, times.start_s(world_.tick, substep_ + 1));
    if (world_.shapes.empty()) return;
    world_.prescribed.each_slot(bodies, [&](std::uint32_t slot) { shape_contacts_.turn(shape_setup(), slot, 1); });
}

// By places alone, which all subdomains know of the blocks around theirs.
bool BlockEngine::is_by_belt(std::uint32_t block) const {
    const Obstacles& obstacles = world_.obstacles;
    if (obstacles.belts().empty()) return false;
    const Bodies& bodies = world_.bodies;
    for (std::uint32_t slot = grid_.blocks()[block].first; slot < grid_.blocks()[block].first + grid_.blocks()[block].count; ++slot) {
        if ((bodies.properties[slot].flags & kFixed) != 0) continue;
        for (std::size_t obstacle = 0; obstacle < obstacles.count(); ++obstacle)
            if (obstacles.belt(obstacle) != 0 &&
                obstacles.may_reach(obstacle, centre_of(bodies.place[slot]), bodies.place[slot].radius, margin_m_))
                return true;
    }
    return false;
}

}  // namespace meld::physics
