// Which blocks sleep. A block sleeps when it and all blocks around it have been still for some ticks and do not speed up. So every sleeping
// block that an awake body can touch has only still neighbours, and its bodies can be treated as fixed.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "physics/solver/block_engine.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// A watch over a block doubles while one of its bodies may be turning round, but no longer than this many times the first.
constexpr int kLongestWatches = 64;
// A velocity that changes by the still speed in this many watches belongs to a body that turns round or speeds up.
constexpr int kWatchesOfChange = 16;

// The first watch takes `enough` ticks and one, and each further one twice as long as the one before. So the bodies of a block, which each
// remember how long it has been still, know it also after a new list.
bool ends_half_a_watch(int still_ticks, int enough) {
    const int first = enough + 1;
    return still_ticks == first / 2 || (still_ticks % first == 0 && std::has_single_bit(static_cast<unsigned>(still_ticks / first)));
}

}  // namespace

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

// With a new candidate list, each block starts from what its bodies remember of their former blocks, and all are awake.
void BlockEngine::note_stillness() {
    for (std::size_t b = 0; b < states_.size(); ++b) {
        const Block& block = grid_.blocks()[b];
        for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot)
            world_.bodies.properties[slot].still_ticks = states_[b].stays ? kStays : std::min(states_[b].still_ticks, kStillAtMost);
        if (states_[b].asleep) set_asleep(static_cast<std::uint32_t>(b), false);
    }
    for (Composite& composite : world_.composites.all()) composite.asleep = 0;
}

void BlockEngine::forget_blocks() {
    states_.clear();
    cages_.clear();
    awake_.clear(), active_.clear();
    for (auto& list : coloured_) list.clear();
}

// Follows size and gravity. A body that nothing holds gains g T while its block is watched, or less with damping, which lets it fall at
// g / c at most; so a quarter of that is not still. Without gravity a slow body may move on for ever, so unless the world names a speed,
// only movement by rounding counts as still: at 1e-5 diameters a second, one diameter takes a day.
double BlockEngine::still_speed_m_s(double dt_s) const {
    constexpr double kShareOfFall = 0.25;
    constexpr double kRounding_diameters_s = 1e-5;
    const Settings& settings = world_.settings;
    const double gravity = length(settings.gravity_m_s2);
    if (gravity == 0) return settings.sleep_speed_m_s > 0 ? settings.sleep_speed_m_s : kRounding_diameters_s * 2 * smallest_radius_m_;
    const double natural = settings.sleep_speed_share * std::sqrt(gravity * 2 * smallest_radius_m_);
    const double watch_s = settings.sleep_ticks * dt_s, damping = settings.linear_damping_per_s;
    const double falling_s = damping > 0 ? -std::expm1(-damping * watch_s) / damping : watch_s;
    return std::min(settings.sleep_speed_m_s > 0 ? settings.sleep_speed_m_s : natural, kShareOfFall * gravity * falling_s);
}

// Before a new candidate list, which forgets the speeds.
void BlockEngine::count_still_ticks(double dt_s) {
    const double speed = still_speed_m_s(dt_s);
    const auto limit = static_cast<float>(speed * speed);
    const int enough = std::min(world_.settings.sleep_ticks, 0x1000);
    if (enough == 0) return;
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        BlockState& state = states_[b];
        if (state.asleep) continue;
        if (state.speed_squared > limit && !only_rattles(b, limit, dt_s)) {
            state.still_ticks = 0;
            state.stays = false;
            continue;
        }
        const float speed_squared = std::min(state.speed_squared, limit);
        if (state.still_ticks < std::numeric_limits<std::uint16_t>::max()) ++state.still_ticks;
        if (state.stays || state.still_ticks == 0) continue;
        if (state.still_ticks == 1 || state.decide_at == 0) {
            state.decide_at = static_cast<std::uint16_t>(enough + 1);
            state.first_speed_squared = state.second_speed_squared = 0;
        }
        // The second and the last quarter of the watch; in the first, a body that has just landed may still be sinking in.
        const int quarter = (4 * state.still_ticks - 1) / state.decide_at;
        if (quarter == 1) state.first_speed_squared = std::max(state.first_speed_squared, speed_squared);
        if (quarter == 3) state.second_speed_squared = std::max(state.second_speed_squared, speed_squared);
        if (state.still_ticks >= state.decide_at) {
            constexpr float kGrows = 2;
            const bool grows = state.second_speed_squared > kGrows * state.first_speed_squared && state.decide_at < 0x8000;
            const bool turns = !grows && state.decide_at < kLongestWatches * std::min(enough, 0x100) && turns_or_speeds_up(b, speed);
            state.stays = !grows && !turns;
            if (state.stays) continue;
            state.decide_at = static_cast<std::uint16_t>(2 * state.decide_at);
            state.first_speed_squared = std::exchange(state.second_speed_squared, 0.0f);
        }
        if (ends_half_a_watch(state.still_ticks, enough)) mark_velocities(b, speed);
    }
}

void BlockEngine::mark_velocities(std::uint32_t index, double still_speed_m_s) {
    const auto scale = static_cast<float>(kMarkedStill / still_speed_m_s);
    const auto share = [scale](float velocity) {
        return static_cast<std::int16_t>(std::clamp<float>(velocity * scale, -kMarkedStill, kMarkedStill));
    };
    const Block& block = grid_.blocks()[index];
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        const BodyVelocity& v = world_.bodies.velocity[slot];
        world_.bodies.properties[slot].marked = {share(v.linear[0]),  share(v.linear[1]),  share(v.linear[2]),
                                                 share(v.surface[0]), share(v.surface[1]), share(v.surface[2])};
    }
}

// Caged bodies may do what they like. What is far slower than a body is that turns round, before or after, sinks or settles.
bool BlockEngine::turns_or_speeds_up(std::uint32_t index, double still_speed_m_s) const {
    constexpr float kFast = 0.25f;
    const double ticks = states_[index].decide_at - states_[index].decide_at / 2;
    const double change_m_s = still_speed_m_s * ticks / (kWatchesOfChange * world_.settings.sleep_ticks);
    const auto caged = cages_.find(index);
    const bool some = caged != cages_.end() && caged->second.are_sure();
    const std::span<const Rattler> rattlers = some ? caged->second.rattlers : std::span<const Rattler>();
    const auto still = static_cast<float>(still_speed_m_s), unit = still / kMarkedStill;
    const auto limit = static_cast<float>(change_m_s * change_m_s);
    const Block& block = grid_.blocks()[index];
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        const BodyVelocity& now = world_.bodies.velocity[slot];
        const auto& marked = world_.bodies.properties[slot].marked;
        float changed = 0, before = 0, after = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const float linear = unit * marked[i], surface = unit * marked[i + 3];
            before += linear * linear + surface * surface;
            after += now.linear[i] * now.linear[i] + now.surface[i] * now.surface[i];
            changed += (now.linear[i] - linear) * (now.linear[i] - linear) + (now.surface[i] - surface) * (now.surface[i] - surface);
        }
        if (changed <= limit || std::max(before, after) < kFast * kFast * still * still) continue;
        if (std::ranges::find(rattlers, slot, &Rattler::slot) == rattlers.end()) return true;
    }
    return false;
}

// In a pile some bodies carry nothing and move to and fro in a cage of others, without rolling resistance for ever. A caged body travels
// less far than its speed would take it, in a time long enough for a swing or two; a rolling body does travel that far, however slowly, and
// one that turns round on a slope does so in the next time. If caged bodies are few, the block may sleep, and they with it.
bool BlockEngine::only_rattles(std::uint32_t index, float still_squared, double dt_s) {
    constexpr float kFastest = 8;
    constexpr std::size_t kFew = 16;
    constexpr int kWatches = 4;
    constexpr double kComesNotFar = 0.25;
    const Block& block = grid_.blocks()[index];
    const Bodies& bodies = world_.bodies;
    if (states_[index].speed_squared > kFastest * kFastest * still_squared || block.count < kFew) {
        cages_.erase(index);
        return false;
    }
    Cages& cages = cages_[index];
    std::vector<Rattler>& rattlers = cages.rattlers;
    const std::size_t before = rattlers.size();
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        const BodyVelocity& v = bodies.velocity[slot];
        float speed_squared = 0;
        for (int i = 0; i < 3; ++i) speed_squared += v.linear[i] * v.linear[i] + v.surface[i] * v.surface[i];
        if (!(speed_squared > still_squared)) continue;
        const auto known = std::find_if(rattlers.begin(), rattlers.end(), [slot](const Rattler& r) { return r.slot == slot; });
        if (known == rattlers.end())
            rattlers.push_back({slot, bodies.drift[slot], speed_squared});
        else
            known->peak_squared = std::max(known->peak_squared, speed_squared);
    }
    if (rattlers.size() * kFew > block.count) {
        cages_.erase(index);
        return false;
    }
    const auto watch = [&](int ticks) {
        cages.since_tick = world_.tick, cages.watch_ticks = ticks;
        for (Rattler& r : rattlers) r = {r.slot, bodies.drift[r.slot], 0};
    };
    const int least = kWatches * world_.settings.sleep_ticks;
    if (rattlers.size() != before) {
        watch(std::max(least, cages.watch_ticks));
        cages.confirmed = 0;
    }
    const auto ticks = static_cast<int>(world_.tick - cages.since_tick);
    if (cages.are_sure() || ticks < cages.watch_ticks) return cages.are_sure();
    const bool caged = std::all_of(rattlers.begin(), rattlers.end(), [&](const Rattler& r) {
        const Drift& now = bodies.drift[r.slot];
        const auto way = static_cast<double>(std::hypot(now.x - r.at.x, now.y - r.at.y, now.z - r.at.z));
        return way < kComesNotFar * ticks * dt_s * std::sqrt(static_cast<double>(r.peak_squared));
    });
    cages.confirmed = caged ? cages.confirmed + 1 : 0;
    // Perhaps its swings take longer.
    if (!cages.are_sure())
        watch(caged ? cages.watch_ticks : std::min(2 * cages.watch_ticks, kLongestWatches * world_.settings.sleep_ticks));
    return cages.are_sure();
}

// Former speeds are no longer known, so the second quarter of the watch ends later. But if lists are made often, blocks that have long been
// still may sleep if no body's velocity changes.
void BlockEngine::resume_stillness(BlockState& state, std::uint16_t still_ticks) const {
    constexpr int kLongAsWatches = 2;
    const int enough = std::min(world_.settings.sleep_ticks, 0x1000), still = still_ticks;
    state.stays = still_ticks == kStays;
    state.still_ticks = still_ticks;
    if (still == 0 || state.stays) return;
    const bool long_still = still > kLongAsWatches * enough;
    int decide_at = enough + 1;
    while (decide_at < (long_still ? still + 1 : 2 * still + 2) && decide_at < 0x8000) decide_at *= 2;
    state.decide_at = static_cast<std::uint16_t>(decide_at);
    state.first_speed_squared = long_still ? std::numeric_limits<float>::max() : 0;
}

bool BlockEngine::has_moving_fixed_body(std::uint32_t index) const {
    const Block& block = grid_.blocks()[index];
    const Bodies& bodies = world_.bodies;
    if (is_by_belt(index)) return true;
    for (std::uint32_t slot = block.first; slot < block.first + block.count; ++slot) {
        if ((bodies.properties[slot].flags & kFixed) == 0) continue;
        // At the turn of a swing it does not move.
        if (world_.prescribed.has(bodies.properties[slot].id)) return true;
        const BodyVelocity& v = bodies.velocity[slot];
        for (const float component : {v.linear[0], v.linear[1], v.linear[2], v.surface[0], v.surface[1], v.surface[2]})
            if (component != 0) return true;
    }
    return false;
}

// What a fixed body or a belt carries or pushes moves, however slowly; and what an obstacle will meet that moves wakes before it does.
void BlockEngine::keep_pushed_awake(const StepTimes& times) {
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        BlockState& state = states_[b];
        if (!state.stays || !((!state.asleep && has_moving_fixed_body(b)) || may_be_met(b, times))) continue;
        state.stays = false;
        state.still_ticks = 0;
    }
}

void BlockEngine::find_resting() {
    const int enough = world_.settings.sleep_ticks;
    const auto all_around = [&](std::uint32_t b, const auto& stays) {
        const auto& around = grid_.blocks()[b].neighbours;
        return enough > 0 && std::all_of(around.begin(), around.end(), [&](std::uint32_t n) { return n == kNoBlock || stays(n); });
    };
    if (linked_.empty()) {
        for (std::uint32_t b = 0; b < states_.size(); ++b)
            states_[b].rests = all_around(b, [&](std::uint32_t n) { return states_[n].stays; });
        return;
    }
    // A composite moves as a whole: none of its blocks stays or rests unless all do.
    std::vector<std::uint8_t> stay(states_.size()), rest(states_.size());
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        const bool by_all = divided() && has_joined_[b] != 0;
        stay[b] = by_all ? all_links_.answer(grid_.blocks()[b].key) : states_[b].stays;
    }
    if (!divided()) all_or_none(stay);
    for (std::uint32_t b = 0; b < states_.size(); ++b) rest[b] = all_around(b, [&](std::uint32_t n) { return stay[n] != 0; });
    if (!divided()) all_or_none(rest);
    for (std::uint32_t b = 0; b < states_.size(); ++b) states_[b].rests = rest[b] != 0;
}

// Of a block that another subdomain owns, bodies may be here that joints hold to ours, and no others: its owner knows whether it stays.
void BlockEngine::say_links_and_stays() {
    all_links_.clear();
    for (std::uint32_t b = 0; b < linked_.size(); ++b) {
        if (has_joined_[b] == 0) continue;
        const std::uint64_t key = grid_.blocks()[b].key;
        all_links_.link(grid_.blocks()[linked_[b]].key, key);
        if (states_[b].owned && !states_[b].stays) all_links_.say_no(key);
    }
}

void BlockEngine::say_rests() {
    all_links_.ask();
    for (std::uint32_t b = 0; b < linked_.size(); ++b)
        if (has_joined_[b] != 0 && states_[b].owned && !states_[b].rests) all_links_.say_no(grid_.blocks()[b].key);
}

void BlockEngine::hear_rests() {
    if (!divided()) return;
    for (std::uint32_t b = 0; b < linked_.size(); ++b)
        if (has_joined_[b] != 0) states_[b].rests = all_links_.answer(grid_.blocks()[b].key);
}

void BlockEngine::update_sleep() {
    bool changed = rebuilt_in_step_ || active_.empty();
    for (std::uint32_t b = 0; b < states_.size(); ++b) {
        if (states_[b].rests == states_[b].asleep) continue;
        set_asleep(b, states_[b].rests);
        states_[b].speed_squared = 0;
        changed = true;
    }
    if (!changed) return;
    list_blocks();
    let_composites_sleep();
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

// Wakes the body's block and the blocks around it.
void BlockEngine::body_changed(std::uint32_t slot, bool moved) {
    fresh_ = fresh_ && !moved;
    if (rebuild_ || moved) {
        rebuild_ = true;
        world_.bodies.properties[slot].still_ticks = 0;
    }
    const std::uint32_t block = grid_.block_with(slot);
    if (block < states_.size()) states_[block].still_ticks = 0, states_[block].stays = false;
    cages_.erase(block);
}

void BlockEngine::gravity_changed() {
    for (BlockState& state : states_) state.still_ticks = 0, state.stays = false;
    for (std::uint32_t slot = 0; rebuild_ && slot < world_.bodies.count(); ++slot) world_.bodies.properties[slot].still_ticks = 0;
    cages_.clear();
}

bool BlockEngine::asleep(std::uint32_t slot) const {
    const std::uint32_t block = grid_.block_with(slot);
    return block < states_.size() && states_[block].asleep;
}

void BlockEngine::state_restored() {
    forget_ = true;
    fresh_ = false;
    rebuild_ = true;
    rows_.forget_velocities();
    world_.composites.restore();
    world_.joints.forget_impulses();
    world_.joints.forget_step();
    world_.joints.places_changed();
    world_.loads.forget();
    // A body may have been asleep in the state that is restored and awake in the failed one, or the other way round.
    for (std::uint32_t slot = 0; slot < world_.bodies.count(); ++slot) world_.bodies.restore_masses(slot);
    for (BlockState& state : states_) state.asleep = false, state.still_ticks = 0, state.stays = false;
    cages_.clear();
}

}  // namespace meld::physics
