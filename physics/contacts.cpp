// Laying out the batches: find each block's pairs, colour them greedily so that a batch's lanes share no body, and give back
// the impulses of contacts that were there before.
#include "physics/contacts.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kBlocksPerJob = 4;
constexpr std::size_t kSlotsPerJob = 16384;
constexpr int kContactColours = 64;
// Pairs are coloured in segments, about two layers of a packed block each, so that a sweep goes up a pile and not over all of it
// colour by colour: a fifth less residual for 2 % more lanes.
constexpr std::size_t kSegmentPairs = 384;

std::size_t jobs_for(std::size_t count, std::size_t per_job) { return (count + per_job - 1) / per_job; }

std::uint32_t motionless_slot(const Bodies& bodies, std::uint32_t block) { return static_cast<std::uint32_t>(bodies.count()) + block; }

}  // namespace

// One worker's workspace while the candidates are collected, and the lanes it has found: for each of its blocks first the
// pairs' lanes, in batches, then those with obstacles.
struct Contacts::Arena {
    struct Lane {
        std::uint32_t a, b;
        ObstacleLane obstacle;
    };
    PairSearch search;
    // Of all blocks, and of the present one.
    Chunks<BodyPair> lanes;
    std::vector<BodyPair> block_lanes;
    std::vector<ObstacleLane> obstacle_lanes;
    std::vector<BodyPair> obstacle_bodies;

    std::vector<std::uint64_t> used;
    std::vector<std::uint8_t> colour;
    std::vector<std::uint32_t> overflow;

    // Assigns each pair (indices below `bodies`; second may be kNoSlot) of a segment the first colour free at both, then puts
    // colour after colour into whole batches. A pair that finds all colours taken gets a batch of its own. Calls place(lane, pair index).
    template <class Place>
    std::size_t colour_lanes(std::size_t bodies, std::span<const BodyPair> pairs, const Place& place);
};

template <class Place>
std::size_t Contacts::Arena::colour_lanes(std::size_t bodies, std::span<const BodyPair> pairs, const Place& place) {
    colour.resize(pairs.size());
    std::uint32_t lane = 0;
    for (std::size_t begin = 0; begin < pairs.size(); begin += kSegmentPairs) {
        const std::size_t end = std::min(pairs.size(), begin + kSegmentPairs);
        used.assign(bodies, 0);
        overflow.clear();
        std::array<std::uint32_t, kContactColours + 1> next{};
        for (std::size_t i = begin; i < end; ++i) {
            const BodyPair pair = pairs[i];
            std::uint64_t& first = used[pair.first];
            const std::uint64_t taken = first | (pair.second == kNoSlot ? 0 : used[pair.second]);
            const int free = std::countr_one(taken);
            colour[i] = static_cast<std::uint8_t>(free);
            if (free == kContactColours) {
                overflow.push_back(static_cast<std::uint32_t>(i));
                continue;
            }
            const std::uint64_t bit = std::uint64_t{1} << free;
            first |= bit;
            if (pair.second != kNoSlot) used[pair.second] |= bit;
            ++next[static_cast<std::size_t>(free)];
        }
        for (auto& count : next) {
            const std::uint32_t start = lane;
            lane += (count + kLanes - 1) / kLanes * kLanes;
            count = start;
        }
        for (std::size_t i = begin; i < end; ++i)
            if (colour[i] < kContactColours) place(next[colour[i]]++, i);
        for (const std::uint32_t i : overflow) place(lane, i), lane += kLanes;
    }
    return lane;
}

// The carried contacts sorted by the present slot of the body with the lower id.
struct Contacts::Former {
    Buffer<std::uint32_t> start;
    Buffer<CarriedContact> contacts;

    const CarriedContact* find(const Bodies& bodies, std::uint32_t id, std::uint32_t partner) const {
        if (contacts.empty()) return nullptr;
        const std::uint32_t slot = bodies.slot(id);
        for (std::uint32_t i = start[slot]; i < start[slot + 1]; ++i)
            if (contacts[i].partner == partner) return &contacts[i];
        return nullptr;
    }
};

std::vector<CarriedContact> Contacts::carry(const Bodies& bodies, Workers& workers) {
    std::vector<Buffer<CarriedContact>> ended(static_cast<std::size_t>(workers.threads()));
    carried_.clear();
    carried_.resize(static_cast<std::size_t>(workers.threads()));
    const auto take = [](auto& list, const Batch& batch, int i, std::uint32_t partner, std::uint32_t id, float sign,
                         bool touches) {
        if (batch.normal_impulse[i] == 0 && batch.tx[i] == 0 && batch.ty[i] == 0 && batch.tz[i] == 0 && !touches) return;
        list.push_back({id, partner, batch.normal_impulse[i], {sign * batch.tx[i], sign * batch.ty[i], sign * batch.tz[i]}, touches});
    };
    const std::size_t batches = pairs_.size() + obstacles_.size();
    constexpr std::size_t kBatchesPerJob = 1024;
    workers.run(jobs_for(batches, kBatchesPerJob), [&](int worker, std::size_t job) {
        const auto removed = [&](std::uint32_t slot) { return (bodies.nature[slot].flags & kRemoved) != 0; };
        for (std::size_t n = job * kBatchesPerJob; n < std::min(batches, (job + 1) * kBatchesPerJob); ++n) {
            const bool is_pair = n < pairs_.size();
            const Batch& batch = is_pair ? pairs_[n] : obstacles_[n - pairs_.size()];
            for (int i = 0; i < kLanes; ++i) {
                if (batch.a[i] >= bodies.count()) continue;
                const bool touches = (touching[n] >> i & 1) != 0;
                const std::uint32_t a = bodies.nature[batch.a[i]].id;
                const bool ends = removed(batch.a[i]) || (is_pair && removed(batch.b[i]));
                if (ends && !touches) continue;
                const auto note = [&](std::uint32_t partner, std::uint32_t id, float sign) {
                    if (ends) take(ended[static_cast<std::size_t>(worker)], batch, i, partner, id, sign, touches);
                    else take(carried_[static_cast<std::size_t>(worker)], batch, i, partner, id, sign, touches);
                };
                if (!is_pair) {
                    note(obstacle_code(lanes_[(n - pairs_.size()) * kLanes + static_cast<std::size_t>(i)]), a, 1);
                    continue;
                }
                const std::uint32_t b = bodies.nature[batch.b[i]].id;
                note(std::max(a, b), std::min(a, b), a < b ? 1.0f : -1.0f);
            }
        }
    });
    give_back(pairs_), give_back(obstacles_), give_back(lanes_), give_back(touching), give_back(adhesion), give_back(bounces);
    pair_first_.assign(1, 0), obstacle_first_.assign(1, 0);
    candidates_ = 0;
    for (std::size_t worker = 1; worker < ended.size(); ++worker)
        ended[0].insert(ended[0].end(), ended[worker].begin(), ended[worker].end());
    return {ended[0].begin(), ended[0].end()};
}

std::vector<CarriedContact> Contacts::carried_of(const std::vector<bool>& ids_wanted) const {
    std::vector<CarriedContact> found;
    const auto wanted = [&](std::uint32_t id) { return id < ids_wanted.size() && ids_wanted[id]; };
    for (const auto& list : carried_)
        list.each([&](const CarriedContact& contact) {
            if (wanted(contact.id) || wanted(contact.partner)) found.push_back(contact);
        });
    return found;
}

void Contacts::add_carried(std::vector<CarriedContact> contacts) {
    carried_.emplace_back();
    for (const CarriedContact& contact : contacts) carried_.back().push_back(contact);
}

Contacts::Former Contacts::sort_carried(const Bodies& bodies, Workers& workers) {
    Former former;
    std::size_t total = 0;
    for (const auto& list : carried_) total += list.size();
    if (total == 0) return former;
    std::vector<std::atomic<std::uint32_t>> next(bodies.count() + 1);
    workers.run(carried_.size(), [&](int, std::size_t list) {
        carried_[list].each([&](const CarriedContact& contact) {
            if (bodies.has(contact.id)) next[bodies.slot(contact.id)].fetch_add(1, std::memory_order_relaxed);
        });
    });
    former.start.resize(bodies.count() + 1);
    std::uint32_t first = 0;
    for (std::size_t slot = 0; slot <= bodies.count(); ++slot) {
        former.start[slot] = first;
        first += next[slot].exchange(first, std::memory_order_relaxed);
    }
    former.contacts.resize(first);
    workers.run(carried_.size(), [&](int, std::size_t list) {
        carried_[list].consume([&](const CarriedContact& contact) {
            if (bodies.has(contact.id)) former.contacts[next[bodies.slot(contact.id)].fetch_add(1, std::memory_order_relaxed)] = contact;
        });
    });
    carried_.clear();
    return former;
}

void Contacts::lay_out(const Setup& setup, const std::vector<bool>* wanted, Workers& workers) {
    const std::size_t blocks = setup.grid.blocks().size();
    Bodies& bodies = setup.bodies;
    bodies.motion.resize(bodies.count() + blocks);
    bodies.place.resize(bodies.count() + blocks);
    for (std::size_t b = 0; b < blocks; ++b) {
        bodies.motion[bodies.count() + b] = {};
        bodies.place[bodies.count() + b] = {};
    }
    std::vector<Arena> arenas(static_cast<std::size_t>(workers.threads()));
    // By block: the worker that found its contacts, and the pairs' lanes.
    std::vector<std::uint32_t> arena_of_block(blocks);
    std::vector<const BodyPair*> lanes_of_block(blocks);
    obstacle_arena_first_.assign(blocks, 0);
    pair_first_.assign(blocks + 1, 0), obstacle_first_.assign(blocks + 1, 0);
    std::atomic<std::size_t> candidates{0};
    const std::size_t jobs = jobs_for(blocks, kBlocksPerJob);
    workers.run(jobs, [&](int worker, std::size_t job) {
        Arena& arena = arenas[static_cast<std::size_t>(worker)];
        for (std::size_t b = job * kBlocksPerJob; b < std::min(blocks, (job + 1) * kBlocksPerJob); ++b) {
            arena_of_block[b] = static_cast<std::uint32_t>(worker);
            if (wanted && !(*wanted)[b]) continue;
            lanes_of_block[b] = collect(setup, static_cast<std::uint32_t>(b), arena);
            candidates.fetch_add(arena.search.pairs().size(), std::memory_order_relaxed);
        }
    });
    candidates_ = candidates;
    for (std::size_t b = 0; b < blocks; ++b) {
        pair_first_[b + 1] += pair_first_[b];
        obstacle_first_[b + 1] += obstacle_first_[b];
    }
    pairs_.resize(pair_first_[blocks]);
    obstacles_.resize(obstacle_first_[blocks]);
    lanes_.resize(obstacles_.size() * kLanes);
    touching.resize(pairs_.size() + obstacles_.size());
    const Former former = sort_carried(bodies, workers);
    workers.run(jobs, [&](int, std::size_t job) {
        for (std::size_t b = job * kBlocksPerJob; b < std::min(blocks, (job + 1) * kBlocksPerJob); ++b)
            fill(setup, static_cast<std::uint32_t>(b), lanes_of_block[b], arenas[arena_of_block[b]], former);
    });
}

// Pass one over a block: its lanes go to the arena, their numbers to the block's entries. Returns the pairs' lanes.
const BodyPair* Contacts::collect(const Setup& setup, std::uint32_t block, Arena& arena) {
    const Bodies& bodies = setup.bodies;
    arena.search.search(setup.grid, bodies, block, setup.reach_m);
    const std::span<const std::uint32_t> slots = arena.search.slots();
    const std::uint32_t nobody = motionless_slot(bodies, block);

    const auto pairs = arena.search.pairs();
    arena.block_lanes.assign(pairs.size() + pairs.size() / 4 + kLanes * kContactColours, {nobody, nobody});
    // A crowd of overflowing pairs may need more lanes than were made room for.
    const auto room = [&](std::size_t needed) {
        if (arena.block_lanes.size() < needed) arena.block_lanes.resize(needed, {nobody, nobody});
    };
    const std::size_t lanes = arena.colour_lanes(slots.size(), pairs, [&](std::size_t lane, std::size_t pair) {
        room(lane + kLanes);
        arena.block_lanes[lane] = {slots[pairs[pair].first], slots[pairs[pair].second]};
    });
    room(lanes);
    BodyPair* const found = arena.lanes.append(lanes);
    std::copy_n(arena.block_lanes.begin(), lanes, found);
    pair_first_[block + 1] = static_cast<std::uint32_t>(lanes / kLanes);
    collect_obstacles(setup, block, arena);
    return found;
}

void Contacts::collect_obstacles(const Setup& setup, std::uint32_t block, Arena& arena) {
    obstacle_arena_first_[block] = static_cast<std::uint32_t>(arena.obstacle_lanes.size());
    if (setup.obstacles.count() == 0) return;
    const Bodies& bodies = setup.bodies;
    const std::uint32_t nobody = motionless_slot(bodies, block);
    const Block& own = setup.grid.blocks()[block];
    std::vector<BodyPair> touches;
    std::vector<ObstacleLane> met;
    for (std::uint32_t slot = own.first; slot < own.first + own.count; ++slot) {
        if (bodies.nature[slot].flags & kFixed) continue;
        const Place& p = bodies.place[slot];
        for (std::uint32_t obstacle = 0; obstacle < setup.obstacles.count(); ++obstacle) {
            if (!setup.obstacles.may_reach(obstacle, {p.x, p.y, p.z}, p.radius, setup.reach_m)) continue;
            for (int part = 0; part < setup.obstacles.parts(obstacle); ++part) {
                touches.push_back({slot - own.first, kNoSlot});
                met.push_back({obstacle, static_cast<std::uint32_t>(part)});
            }
        }
    }
    if (touches.empty()) return;
    const std::size_t obstacle_first = arena.obstacle_lanes.size();
    const auto widen = [&](std::size_t needed) {
        if (arena.obstacle_lanes.size() >= obstacle_first + needed) return;
        arena.obstacle_lanes.resize(obstacle_first + needed, {0, 0});
        arena.obstacle_bodies.resize(obstacle_first + needed, {nobody, nobody});
    };
    const std::size_t obstacle_lanes = arena.colour_lanes(own.count, touches, [&](std::size_t lane, std::size_t i) {
        widen(lane + kLanes);
        arena.obstacle_lanes[obstacle_first + lane] = met[i];
        arena.obstacle_bodies[obstacle_first + lane] = {own.first + touches[i].first, nobody};
    });
    widen(obstacle_lanes);
    arena.obstacle_lanes.resize(obstacle_first + obstacle_lanes);
    arena.obstacle_bodies.resize(obstacle_first + obstacle_lanes);
    obstacle_first_[block + 1] = static_cast<std::uint32_t>(obstacle_lanes / kLanes);
}

// Pass two: the batches, with what they were before.
void Contacts::fill(const Setup& setup, std::uint32_t block, const BodyPair* pair, const Arena& arena, const Former& former) {
    const Bodies& bodies = setup.bodies;
    const auto friction = [&](std::uint8_t one, std::uint8_t other) {
        return std::sqrt(setup.materials[one].friction * setup.materials[other].friction);
    };
    const auto begin = [](Batch& batch) {
        const Lanes nothing = lanes(0);
        batch.nx = batch.ny = batch.nz = batch.friction = batch.normal_impulse = batch.tx = batch.ty = batch.tz = nothing;
        batch.gap = lanes(kNoContactGap);
    };
    const auto recall = [&](Batch& batch, std::uint8_t& touch, int i, std::uint32_t a, std::uint32_t partner) {
        const CarriedContact* was = former.find(bodies, std::min(a, partner), std::max(a, partner));
        if (!was) return;
        const float sign = a < partner ? 1.0f : -1.0f;
        batch.normal_impulse[i] = was->normal_impulse;
        batch.tx[i] = sign * was->tangent[0], batch.ty[i] = sign * was->tangent[1], batch.tz[i] = sign * was->tangent[2];
        touch = static_cast<std::uint8_t>(touch | int{was->touching} << i);
    };
    for (std::uint32_t n = pair_first_[block]; n < pair_first_[block + 1]; ++n) {
        Batch& batch = pairs_[n];
        begin(batch);
        touching[n] = 0;
        for (int i = 0; i < kLanes; ++i, ++pair) {
            batch.a[i] = pair->first, batch.b[i] = pair->second;
            if (pair->first >= bodies.count()) continue;
            const Nature &a = bodies.nature[pair->first], &b = bodies.nature[pair->second];
            batch.friction[i] = friction(a.material, b.material);
            recall(batch, touching[n], i, a.id, b.id);
        }
    }
    std::size_t at = obstacle_arena_first_[block];
    for (std::uint32_t n = obstacle_first_[block]; n < obstacle_first_[block + 1]; ++n) {
        Batch& batch = obstacles_[n];
        std::uint8_t& touch = touching[pairs_.size() + n];
        begin(batch);
        touch = 0;
        for (int i = 0; i < kLanes; ++i, ++at) {
            const BodyPair body = arena.obstacle_bodies[at];
            const ObstacleLane lane = arena.obstacle_lanes[at];
            lanes_[n * kLanes + static_cast<std::size_t>(i)] = lane;
            batch.a[i] = body.first, batch.b[i] = body.second;
            if (body.first >= bodies.count()) continue;
            const Nature& a = bodies.nature[body.first];
            batch.friction[i] = friction(a.material, setup.obstacles.material(lane.obstacle));
            recall(batch, touch, i, a.id, obstacle_code(lane));
        }
    }
}

void Contacts::forget(Workers& workers) {
    constexpr std::size_t kBatchesPerJob = 4096;
    for (auto* batches : {&pairs_, &obstacles_})
        workers.run(jobs_for(batches->size(), kBatchesPerJob), [&](int, std::size_t job) {
            const Lanes nothing = lanes(0);
            for (std::size_t n = job * kBatchesPerJob; n < std::min(batches->size(), (job + 1) * kBatchesPerJob); ++n) {
                Batch& batch = (*batches)[n];
                batch.normal_impulse = batch.tx = batch.ty = batch.tz = nothing;
            }
        });
}

void Contacts::need_adhesion() {
    if (adhesion.size() != pairs_.size()) adhesion.assign(pairs_.size(), lanes(0));
}

void Contacts::need_bounces(const Setup& setup) {
    if (bounces.size() == pairs_.size() + obstacles_.size()) return;
    bounces.assign(pairs_.size() + obstacles_.size(), {lanes(0), lanes(0), lanes(0)});
    const Bodies& bodies = setup.bodies;
    const auto restitution = [&](std::uint8_t one, std::uint8_t other) {
        return std::max(setup.materials[one].restitution, setup.materials[other].restitution);
    };
    for (std::size_t n = 0; n < bounces.size(); ++n) {
        const bool is_pair = n < pairs_.size();
        const Batch& batch = is_pair ? pairs_[n] : obstacles_[n - pairs_.size()];
        for (int i = 0; i < kLanes; ++i) {
            if (batch.a[i] >= bodies.count()) continue;
            const std::uint8_t other =
                is_pair ? bodies.nature[batch.b[i]].material
                        : setup.obstacles.material(lanes_[(n - pairs_.size()) * kLanes + static_cast<std::size_t>(i)].obstacle);
            bounces[n].restitution[i] = restitution(bodies.nature[batch.a[i]].material, other);
        }
    }
}

std::size_t Contacts::bytes() const {
    return (pairs_.capacity() + obstacles_.capacity()) * sizeof(Batch) + lanes_.capacity() * sizeof(ObstacleLane) + touching.capacity() +
           adhesion.capacity() * sizeof(Lanes) + bounces.capacity() * sizeof(Bounce) +
           (pair_first_.capacity() + obstacle_first_.capacity()) * sizeof(std::uint32_t) +
           obstacle_arena_first_.capacity() * sizeof(std::uint32_t);
}

}  // namespace meld::physics
