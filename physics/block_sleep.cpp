// Which blocks sleep. A block sleeps when it and all blocks around have been still for some ticks; so every sleeping block
// that something awake can touch has only still neighbours, and its bodies can be taken for fixed.
#include <algorithm>
#include <limits>

#include "physics/block_engine.h"
#include "runtime/base/assert.h"

namespace meld::physics {

void BlockEngine::set_asleep(std::uint32_t index, bool asleep) {
    MELD_EXPECT(index < states_.size() && states_.size() == grid_.blocks().size(), "block {} of {}", index, states_.size());
    const Block& block = grid_.blocks()[index];
    Bodies& bodies = world_.bodies;
    states_[index].asleep = asleep;
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        if (asleep)
            bodies.velocity[slot] = {};
        else
            bodies.restore_masses(slot);
    }
}

// A new candidate list begins with what each body knows of its former block, all awake.
void BlockEngine::note_stillness() {
    for (std::size_t b = 0; b < states_.size(); ++b) {
        const Block& block = grid_.blocks()[b];
        for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot)
            world_.bodies.properties[slot].still_ticks = states_[b].still_ticks;
        if (states_[b].asleep) set_asleep(static_cast<std::uint32_t>(b), false);
    }
}

void BlockEngine::forget_blocks() {
    states_.clear();
    awake_.clear(), active_.clear();
    for (auto& list : coloured_) list.clear();
}

// Before a new candidate list, which forgets the speeds.
void BlockEngine::count_still_ticks() {
    const auto limit = static_cast<float>(world_.settings.sleep_speed_m_s * world_.settings.sleep_speed_m_s);
    for (BlockState& state : states_) {
        if (state.speed_squared > limit)
            state.still_ticks = 0;
        else if (state.still_ticks < std::numeric_limits<std::uint16_t>::max())
            ++state.still_ticks;
    }
}

void BlockEngine::find_resting() {
    const int enough = world_.settings.sleep_ticks;
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        const auto& around = grid_.blocks()[b].neighbours;
        states_[b].rests = enough > 0 && std::all_of(around.begin(), around.end(),
                                                     [&](std::uint32_t n) { return n == kNoBlock || states_[n].still_ticks > enough; });
    }
}

void BlockEngine::update_sleep() {
    bool changed = rebuilt_in_step_ || active_.empty();
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        if (states_[b].rests == states_[b].asleep) continue;
        set_asleep(b, states_[b].rests);
        states_[b].speed_squared = 0;
        changed = true;
    }
    if (changed) list_blocks();
}

void BlockEngine::list_blocks() {
    awake_.clear(), active_.clear();
    for (auto& list : coloured_) list.clear();
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        const Block& block = grid_.blocks()[b];
        BlockState& state = states_[b];
        state.active = std::any_of(block.neighbours.begin(), block.neighbours.end(),
                                   [&](std::uint32_t n) { return n != kNoBlock && !states_[n].asleep; });
        if (!state.asleep) awake_.push_back(b);
        if (!state.active || !state.owned) continue;
        active_.push_back(b);
        coloured_[static_cast<std::size_t>(colour_of(unpack(block.key)))].push_back(b);
    }
    MELD_ENSURE(awake_.size() <= states_.size() && active_.size() <= states_.size());
}

// Wakes the body's block, and with it those around.
void BlockEngine::body_changed(std::uint32_t slot, bool moved) {
    fresh_ = fresh_ && !moved;
    if (rebuild_ || moved) {
        rebuild_ = true;
        world_.bodies.properties[slot].still_ticks = 0;
    }
    const auto blocks = grid_.blocks();
    const auto after =
        std::upper_bound(blocks.begin(), blocks.end(), slot, [](std::uint32_t value, const Block& block) { return value < block.first; });
    if (after == blocks.begin()) return;
    const auto index = static_cast<std::size_t>(after - blocks.begin()) - 1;
    if (index < states_.size()) states_[index].still_ticks = 0;
}

bool BlockEngine::asleep(std::uint32_t slot) const {
    const auto blocks = grid_.blocks();
    const auto after =
        std::upper_bound(blocks.begin(), blocks.end(), slot, [](std::uint32_t value, const Block& block) { return value < block.first; });
    return after != blocks.begin() && states_[static_cast<std::size_t>(after - blocks.begin()) - 1].asleep;
}

void BlockEngine::state_restored() {
    forget_ = true;
    fresh_ = false;
    rebuild_ = true;
    // A body may have slept in the state that is back and not in the one that was left, or the other way round.
    for (std::uint32_t slot = 0; slot < world_.bodies.count(); ++slot) world_.bodies.restore_masses(slot);
    for (BlockState& state : states_) state.asleep = false, state.still_ticks = 0;
}

}  // namespace meld::physics
