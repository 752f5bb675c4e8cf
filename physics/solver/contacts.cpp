// Laying out the batches: find each block's pairs, colour them greedily so that a batch's lanes share no body, and give persisting contacts
// their impulses.
#include "physics/solver/contacts.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <iterator>
#include <unordered_map>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kBlocksPerJob = 4;
constexpr int kContactColours = 64;
// Of batches: plain, joint and mixed (contacts.h).
constexpr std::size_t kBatchKinds = 3;
// Pairs are coloured in segments of about two layers of a packed block, so that a sweep climbs a pile instead of crossing all of it colour
// by colour: a fifth less residual for 2 % more lanes.
constexpr std::size_t kSegmentPairs = 384;

std::size_t jobs_for(std::size_t count, std::size_t per_job) { return (count + per_job - 1) / per_job; }

// Gives a lane the impulses it had before, if it existed; `sign` is -1 if its body a is not the one with the lower id.
void recall(const CachedContact* was, Batch& batch, std::uint8_t& touching, int i, float sign) {
    if (!was) return;
    batch.normal_impulse[i] = was->normal_impulse;
    batch.tx[i] = sign * was->tangent[0], batch.ty[i] = sign * was->tangent[1], batch.tz[i] = sign * was->tangent[2];
    touching = static_cast<std::uint8_t>(touching | (was->touching() ? 1 : 0) << i);
}

}  // namespace

// One worker's workspace, and the batches it has laid out.
struct Contacts::Arena {
    PairSearch search;
    // Of the present block.
    std::vector<BodyPair> lanes;
    std::vector<BodyPair> obstacle_pairs;
    std::vector<std::uint32_t> obstacle_slots;
    std::vector<ObstacleLane> obstacles_met, obstacle_lanes;

    // With composites: the pairs of each kind of batches, and what no two lanes of a batch may share, below `keys`: a body that is no
    // member, or a composite.
    struct Chosen {
        BodyPair slots;
        bool fast;
    };
    std::array<std::vector<Chosen>, kBatchKinds> chosen;
    std::array<std::vector<BodyPair>, kBatchKinds> keys_of;
    std::size_t keys = 0;
    // Pairs of the present block.
    std::size_t laid_out = 0;
    std::unordered_map<std::uint32_t, std::uint32_t> key_of_composite;
    std::uint32_t key(std::uint32_t composite) {
        const auto [at, made] = key_of_composite.try_emplace(composite, static_cast<std::uint32_t>(keys));
        if (made) ++keys;
        return at->second;
    }
    void choose(const Bodies& bodies, const Composites& composites);

    std::vector<std::uint64_t> used;
    std::vector<std::uint8_t> colour;
    std::vector<std::uint32_t> overflow;

    std::size_t per_chunk = 0;
    std::vector<Chunk> pair_chunks, obstacle_chunks;

    // Makes room for lanes up to this one, without bodies until they are set; grows, because a crowd of overflowing pairs may need more
    // lanes than expected.
    void widen(std::size_t lane, std::uint32_t nobody) {
        if (lanes.size() <= lane) lanes.resize(lane + 1, {nobody, nobody});
    }
    // Assigns each pair of a segment (indices below `bodies`; second may be kNoSlot) the first colour free at both, then puts one colour
    // after the other into whole batches. A pair that finds all colours taken gets a separate batch. Calls place(lane, pair index).
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

// Pairs that nothing can move against each other have no contact. Of the others, a member of a composite comes first.
void Contacts::Arena::choose(const Bodies& bodies, const Composites& composites) {
    for (auto& list : chosen) list.clear();
    for (auto& list : keys_of) list.clear();
    key_of_composite.clear();
    const std::span<const std::uint32_t> slots = search.slots();
    keys = slots.size();
    for (std::size_t i = 0; i < search.pairs().size(); ++i) {
        BodyPair pair = search.pairs()[i];
        const BodyProperties &a = bodies.properties[slots[pair.first]], &b = bodies.properties[slots[pair.second]];
        if (((a.flags | b.flags) & kShaped) != 0 || composites.indifferent(a, b)) continue;
        std::uint32_t first = composites.mover_of(a.id), second = composites.mover_of(b.id);
        if (first == kNoComposite && second != kNoComposite) std::swap(first, second), std::swap(pair.first, pair.second);
        const std::size_t kind = first == kNoComposite ? 0 : second == kNoComposite ? 2 : 1;
        chosen[kind].push_back({{slots[pair.first], slots[pair.second]}, i >= search.first_fast()});
        keys_of[kind].push_back({first == kNoComposite ? pair.first : key(first), second == kNoComposite ? pair.second : key(second)});
    }
}

void Contacts::sort_kinds(BlockBatches& stretch, const Setup& setup) {
    stretch.plain = stretch.count, stretch.joint = 0;
    if (setup.composites == nullptr || setup.composites->empty()) return;
    const Bodies& bodies = setup.bodies;
    const Composites& composites = *setup.composites;
    const auto moved_by_composite = [&](std::uint32_t slot) {
        return slot < bodies.count() && composites.mover_of(bodies.properties[slot].id) != kNoComposite;
    };
    const auto any_lane = [&](std::uint32_t n, const auto& is) {
        const Batch& batch = stretch.batches[n];
        for (int i = 0; i < kLanes; ++i)
            if (is(batch.a[i], batch.b[i])) return true;
        return false;
    };
    std::uint32_t n = 0;
    while (n < stretch.count && !any_lane(n, [&](std::uint32_t a, std::uint32_t) { return moved_by_composite(a); })) ++n;
    stretch.plain = n;
    while (n < stretch.count &&
           !any_lane(n, [&](std::uint32_t a, std::uint32_t b) { return moved_by_composite(a) && !moved_by_composite(b); }))
        ++n;
    stretch.joint = n - stretch.plain;
}

std::size_t Contacts::batches_per_chunk(const Bodies& bodies, const Workers& workers) {
    return std::clamp(bodies.count() / static_cast<std::size_t>(workers.threads()), kFewBatches, kMaxBatchesPerChunk);
}

Contacts::BlockBatches Contacts::room(std::vector<Chunk>& chunks, std::size_t batches, Kind kind, std::size_t per_chunk) {
    if (batches == 0) return {};
    const bool obstacles = kind == Kind::Obstacles;
    if (chunks.empty() || chunks.back().batches.capacity() - chunks.back().batches.size() < batches) {
        // Usually few bodies touch obstacles.
        const bool few = obstacles && chunks.size() + 1 < kChunksOfFew;
        const std::size_t most = std::max(batches, few ? kFewBatches : per_chunk);
        Chunk& chunk = chunks.emplace_back();
        chunk.batches.reserve(most), chunk.touching.reserve(most);
        if (obstacles) chunk.lanes.reserve(kLanes * most);
    }
    Chunk& chunk = chunks.back();
    const std::size_t before = chunk.batches.size(), after = before + batches;
    chunk.batches.resize(after), chunk.touching.resize(after);
    if (obstacles) chunk.lanes.resize(kLanes * after);
    return {.batches = chunk.batches.data() + before,
            .touching = chunk.touching.data() + before,
            .lanes = chunk.lanes.data() + (obstacles ? kLanes * before : 0),
            .count = static_cast<std::uint32_t>(batches)};
}

void Contacts::Layout::number() {
    std::uint32_t first = 0;
    for (BlockBatches& stretch : of_block) stretch.first = first, first += stretch.count;
    count = first;
}

// The reserved end of a chunk is not resident until it is written.
std::size_t Contacts::Layout::bytes() const {
    std::size_t sum = of_block.capacity() * sizeof(BlockBatches);
    for (const Chunk& chunk : chunks)
        sum += chunk.batches.size() * sizeof(Batch) + chunk.touching.size() + chunk.lanes.size() * sizeof(ObstacleLane);
    return sum;
}

void Contacts::add_motionless(Bodies& bodies, const Obstacles& obstacles, std::size_t blocks) {
    const std::span<const Vec3> belts = obstacles.belts();
    const std::size_t count = bodies.count() + blocks * (1 + belts.size());
    bodies.velocity.resize(count);
    bodies.place.resize(count);
    for (std::size_t slot = bodies.count(); slot < count; ++slot) {
        bodies.velocity[slot] = {};
        bodies.place[slot] = {};
    }
    for (std::size_t n = 0; n < belts.size(); ++n)
        for (std::size_t b = 0; b < blocks; ++b) set_single(bodies.velocity[bodies.count() + blocks * (1 + n) + b].surface, belts[n]);
}

void Contacts::lay_out(const Setup& setup, const std::vector<bool>* wanted, Workers& workers) {
    const std::size_t blocks = setup.grid.blocks().size();
    MELD_EXPECT(wanted == nullptr || wanted->size() == blocks, "{} blocks", blocks);
    MELD_EXPECT(!setup.materials.empty());
    Bodies& bodies = setup.bodies;
    add_motionless(bodies, setup.obstacles, blocks);
    WarmStartCache former(cached_, setup.grid, bodies, kBlocksPerJob, workers);
    const auto threads = static_cast<std::size_t>(workers.threads());
    std::vector<Arena> arenas(threads);
    for (Arena& arena : arenas) arena.per_chunk = batches_per_chunk(bodies, workers);
    pairs_ = Layout(), obstacles_ = Layout();
    pairs_.of_block.resize(blocks), obstacles_.of_block.resize(blocks);
    fast_lanes_.clear();
    if (setup.reach.ahead_s > 0) fast_lanes_.resize(blocks);
    std::atomic<std::size_t> candidates{0};
    workers.run(jobs_for(blocks, kBlocksPerJob), [&](int worker, std::size_t job) {
        Arena& arena = arenas[static_cast<std::size_t>(worker)];
        for (std::size_t b = job * kBlocksPerJob; b < std::min(blocks, (job + 1) * kBlocksPerJob); ++b) {
            if (wanted && !(*wanted)[b]) continue;
            lay_out_pairs(setup, static_cast<std::uint32_t>(b), arena, former);
            lay_out_obstacles(setup, static_cast<std::uint32_t>(b), arena, former);
            candidates.fetch_add(arena.laid_out, std::memory_order_relaxed);
        }
        former.done(job);
    });
    candidates_ = candidates;
    pairs_.number(), obstacles_.number();
    MELD_ENSURE(kLanes * pairs_.count >= candidates_, "{} batches for {} pairs", pairs_.count, candidates_);
    for (Arena& arena : arenas) {
        std::move(arena.pair_chunks.begin(), arena.pair_chunks.end(), std::back_inserter(pairs_.chunks));
        std::move(arena.obstacle_chunks.begin(), arena.obstacle_chunks.end(), std::back_inserter(obstacles_.chunks));
    }
}

void Contacts::lay_out_pairs(const Setup& setup, std::uint32_t block, Arena& arena, const WarmStartCache& former) {
    const Bodies& bodies = setup.bodies;
    arena.search.search(setup.grid, bodies, block, setup.reach);
    const std::span<const std::uint32_t> slots = arena.search.slots();
    const std::span<const BodyPair> pairs = arena.search.pairs();
    const std::uint32_t nobody = motionless_slot(bodies, block);
    arena.lanes.assign(pairs.size() + pairs.size() / 4 + kLanes * kContactColours, {nobody, nobody});
    std::size_t lanes = 0;
    // One kind of batches after the other. `keys` are what no two lanes of a batch may share.
    const auto add = [&](std::size_t count, std::span<const BodyPair> keys, const auto& pair_of) {
        const std::size_t begin = lanes;
        arena.laid_out += keys.size();
        lanes += arena.colour_lanes(count, keys, [&](std::size_t lane, std::size_t i) {
            const Arena::Chosen pair = pair_of(i);
            arena.widen(begin + lane + kLanes, nobody);
            arena.lanes[begin + lane] = pair.slots;
            if (pair.fast) fast_lanes_[block].push_back(static_cast<std::uint32_t>(begin + lane));
        });
        return static_cast<std::uint32_t>((lanes - begin) / kLanes);
    };
    arena.laid_out = 0;
    std::uint32_t plain = 0, joint = 0;
    if (setup.composites == nullptr || (setup.composites->empty() && setup.composites->joined().empty() && !setup.has_shapes)) {
        plain = add(slots.size(), pairs, [&](std::size_t i) {
            return Arena::Chosen{{slots[pairs[i].first], slots[pairs[i].second]}, i >= arena.search.first_fast()};
        });
    } else {
        arena.choose(bodies, *setup.composites);
        std::array<std::uint32_t, kBatchKinds> counts{};
        for (std::size_t kind = 0; kind < kBatchKinds; ++kind)
            counts[kind] = add(arena.keys, arena.keys_of[kind], [&](std::size_t i) { return arena.chosen[kind][i]; });
        plain = counts[0], joint = counts[1];
    }
    arena.widen(lanes, nobody);
    const BlockBatches stretch = pairs_.of_block[block] = room(arena.pair_chunks, lanes / kLanes, Kind::Pairs, arena.per_chunk);
    pairs_.of_block[block].plain = plain, pairs_.of_block[block].joint = joint;
    const BodyPair* pair = arena.lanes.data();
    for (std::uint32_t n = 0; n < stretch.count; ++n) {
        Batch& batch = stretch.batches[n];
        begin(batch);
        stretch.touching[n] = 0;
        for (int i = 0; i < kLanes; ++i, ++pair) {
            batch.a[i] = pair->first, batch.b[i] = pair->second;
            if (pair->first >= bodies.count()) continue;
            MELD_ASSERT(pair->second < bodies.count() && pair->first != pair->second, "bodies {} and {}", pair->first, pair->second);
            const BodyProperties &a = bodies.properties[pair->first], &b = bodies.properties[pair->second];
            batch.friction[i] = common_friction(setup.materials[a.material], setup.materials[b.material]);
            const bool a_first = a.id < b.id;
            recall(former.find(a_first ? pair->first : pair->second, std::max(a.id, b.id)), batch, stretch.touching[n], i,
                   a_first ? 1.0f : -1.0f);
        }
    }
}

void Contacts::lay_out_obstacles(const Setup& setup, std::uint32_t block, Arena& arena, const WarmStartCache& former) {
    if (setup.obstacles.count() == 0) return;
    const Bodies& bodies = setup.bodies;
    const std::uint32_t nobody = motionless_slot(bodies, block);
    const Block& own = setup.grid.blocks()[block];
    std::vector<BodyPair>& pairs = arena.obstacle_pairs;
    std::vector<ObstacleLane>& met = arena.obstacles_met;
    arena.lanes.clear(), arena.obstacle_lanes.clear();
    const auto widen = [&](std::size_t lane) {
        arena.widen(lane, nobody);
        if (arena.obstacle_lanes.size() <= lane) arena.obstacle_lanes.resize(lane + 1, {0, 0});
    };
    std::size_t lanes = 0;
    // The contacts of the wanted bodies, in batches after the last. Lanes of one batch have different keys.
    const auto add = [&](const auto& wanted, const auto& key) {
        pairs.clear(), met.clear(), arena.obstacle_slots.clear();
        for (std::uint32_t slot = own.first; slot < own.first + own.count; ++slot) {
            if ((bodies.properties[slot].flags & (kFixed | kShaped)) != 0 || !wanted(slot)) continue;
            const Place& p = bodies.place[slot];
            const double apart_m = setup.reach.apart_m + setup.ahead_s * length(velocity_of(bodies.velocity[slot]));
            for (std::uint32_t obstacle = 0; obstacle < setup.obstacles.count(); ++obstacle) {
                const double reach_m = apart_m + setup.obstacles.way_of_list_m(obstacle, {p.x, p.y, p.z});
                if (!setup.obstacles.may_reach(obstacle, {p.x, p.y, p.z}, p.radius, reach_m)) continue;
                for (int part = 0; part < setup.obstacles.parts(obstacle); ++part) {
                    pairs.push_back({key(slot), kNoSlot});
                    arena.obstacle_slots.push_back(slot);
                    met.push_back({obstacle, static_cast<std::uint32_t>(part)});
                }
            }
        }
        const std::size_t begin = lanes;
        if (pairs.empty()) return;
        lanes += arena.colour_lanes(std::max<std::size_t>(own.count, arena.keys), pairs, [&](std::size_t lane, std::size_t i) {
            widen(begin + lane + kLanes);
            arena.lanes[begin + lane] = {arena.obstacle_slots[i],
                                         slot_of_obstacle(bodies, setup.obstacles, setup.grid.blocks().size(), block, met[i].obstacle)};
            arena.obstacle_lanes[begin + lane] = met[i];
        });
    };
    arena.keys = 0;
    const auto plain_key = [&](std::uint32_t slot) { return slot - own.first; };
    const bool composed = setup.composites != nullptr && !setup.composites->empty();
    const auto mover = [&](std::uint32_t slot) { return setup.composites->mover_of(bodies.properties[slot].id); };
    if (!composed) {
        add([](std::uint32_t) { return true; }, plain_key);
    } else {
        add([&](std::uint32_t slot) { return setup.composites->composite_of(bodies.properties[slot].id) == kNoComposite; }, plain_key);
    }
    const auto plain = static_cast<std::uint32_t>(lanes / kLanes);
    if (composed) {
        arena.key_of_composite.clear();
        add([&](std::uint32_t slot) { return mover(slot) != kNoComposite; }, [&](std::uint32_t slot) { return arena.key(mover(slot)); });
    }
    if (lanes == 0) return;
    widen(lanes);
    const BlockBatches stretch = obstacles_.of_block[block] = room(arena.obstacle_chunks, lanes / kLanes, Kind::Obstacles, arena.per_chunk);
    obstacles_.of_block[block].plain = plain;
    std::size_t at = 0;
    for (std::uint32_t n = 0; n < stretch.count; ++n) {
        Batch& batch = stretch.batches[n];
        begin(batch);
        stretch.touching[n] = 0;
        for (int i = 0; i < kLanes; ++i, ++at) {
            const BodyPair body = arena.lanes[at];
            const ObstacleLane lane = stretch.lanes[at] = arena.obstacle_lanes[at];
            batch.a[i] = body.first, batch.b[i] = body.second;
            if (body.first >= bodies.count()) continue;
            MELD_ASSERT(lane.obstacle < setup.obstacles.count(), "obstacle {} of {}", lane.obstacle, setup.obstacles.count());
            batch.friction[i] = common_friction(setup.materials[bodies.properties[body.first].material],
                                                setup.materials[setup.obstacles.material(lane.obstacle)]);
            recall(former.find(body.first, obstacle_code(lane)), batch, stretch.touching[n], i, 1);
        }
    }
}

void Contacts::forget(Workers& workers) {
    const std::size_t pair_chunks = pairs_.chunks.size();
    workers.run(pair_chunks + obstacles_.chunks.size(), [&](int, std::size_t n) {
        const Lanes nothing = lanes(0);
        for (Batch& batch : (n < pair_chunks ? pairs_.chunks[n] : obstacles_.chunks[n - pair_chunks]).batches)
            batch.normal_impulse = batch.tx = batch.ty = batch.tz = nothing;
    });
}

void Contacts::need_adhesion() {
    MELD_EXPECT(pairs_.of_block.size() == obstacles_.of_block.size());
    if (adhesion.size() != pairs_.count) adhesion.assign(pairs_.count, lanes(0));
}

void Contacts::begin_bounces(const Setup& setup) {
    if (bounces_.size() == pairs_.count + obstacles_.count) {
        for (Bounce& bounce : bounces_) bounce.impulse = lanes(0);
        return;
    }
    bounces_.assign(pairs_.count + obstacles_.count, {lanes(0), lanes(0)});
    const Bodies& bodies = setup.bodies;
    const auto restitution = [&](std::uint32_t slot, std::uint8_t other) {
        return std::max(setup.materials[bodies.properties[slot].material].restitution, setup.materials[other].restitution);
    };
    auto bounce = bounces_.begin();
    const auto each_lane = [&](std::span<const Batch> batches, const auto& other) {
        for (const Batch& batch : batches) {
            for (int i = 0; i < kLanes; ++i)
                if (batch.a[i] < bodies.count()) bounce->restitution[i] = restitution(batch.a[i], other(batch, i));
            ++bounce;
        }
    };
    for (std::size_t block = 0; block < pairs_.of_block.size(); ++block)
        each_lane(pairs(block), [&](const Batch& batch, int i) { return bodies.properties[batch.b[i]].material; });
    for (std::size_t block = 0; block < obstacles_.of_block.size(); ++block) {
        const BlockBatches stretch = obstacles_.at(block);
        each_lane(obstacle_contacts(block), [&](const Batch& batch, int i) {
            return setup.obstacles.material(stretch.lanes[(&batch - stretch.batches) * kLanes + i].obstacle);
        });
    }
}

std::size_t Contacts::bytes() const {
    return pairs_.bytes() + obstacles_.bytes() + adhesion.capacity() * sizeof(Lanes) + bounces_.capacity() * sizeof(Bounce);
}

}  // namespace meld::physics
