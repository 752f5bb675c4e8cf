// The batches of a block in a snapshot. They go as they lie, because the order in which a block is swept depends on how its list was made.
// The address of a body is its place in the blocks around, which is the same on every subdomain. What follows from positions is not
// written: the gap and normal of most pairs.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <limits>

#include "physics/solver/body_addresses.h"
#include "physics/solver/contacts.h"
#include "physics/solver/kernels.h"
#include "physics/solver/saved_bodies.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// The lanes of a batch, as bits: those with bodies; of these those that touch, whose impulses are not zero, whose zeros have signs, whose
// gap and normal do not follow from the positions, and whose bodies are fast.
struct SavedBatch {
    std::uint8_t used = 0, touching = 0, pressed = 0, signs = 0, apart = 0, fast = 0;
};

template <class F>
void each_lane(unsigned bits, const F& f) {
    for (; bits != 0; bits &= bits - 1) f(std::countr_zero(bits));
}

using Four = std::array<float, 4>;

Four place_of(const Batch& batch, int i) { return {batch.nx[i], batch.ny[i], batch.nz[i], batch.gap[i]}; }
Four impulse_of(const Batch& batch, int i) { return {batch.normal_impulse[i], batch.tx[i], batch.ty[i], batch.tz[i]}; }
void set_place(Batch& batch, int i, const Four& place) {
    batch.nx[i] = place[0], batch.ny[i] = place[1], batch.nz[i] = place[2], batch.gap[i] = place[3];
}
void set_impulse(Batch& batch, int i, const Four& impulse) {
    batch.normal_impulse[i] = impulse[0], batch.tx[i] = impulse[1], batch.ty[i] = impulse[2], batch.tz[i] = impulse[3];
}
bool same_bits(const Four& one, const Four& other) { return std::memcmp(&one, &other, sizeof one) == 0; }

// Which impulses must be written, and how.
void look_at_impulses(const Batch& batch, SavedBatch& saved) {
    each_lane(saved.used, [&](int i) {
        const Four impulse = impulse_of(batch, i);
        if (same_bits(impulse, {})) return;
        const bool zero = std::all_of(impulse.begin(), impulse.end(), [](float x) { return x == 0; });
        (zero ? saved.signs : saved.pressed) |= static_cast<std::uint8_t>(1u << i);
    });
}

void save_impulses(std::span<const Batch> batches, const std::vector<SavedBatch>& saved, ByteWriter& out) {
    for (std::size_t n = 0; n < saved.size(); ++n) {
        each_lane(saved[n].pressed, [&](int i) { out.write(impulse_of(batches[n], i)); });
        each_lane(saved[n].signs, [&](int i) {
            std::uint8_t signs = 0;
            for (int k = 0; const float x : impulse_of(batches[n], i)) signs |= static_cast<std::uint8_t>((std::signbit(x) ? 1 : 0) << k++);
            out.write(signs);
        });
    }
}

void load_impulses(std::span<Batch> batches, const std::vector<SavedBatch>& saved, ByteReader& in) {
    for (std::size_t n = 0; n < saved.size(); ++n) {
        batches[n].normal_impulse = batches[n].tx = batches[n].ty = batches[n].tz = lanes(0);
        each_lane(saved[n].pressed, [&](int i) { set_impulse(batches[n], i, in.read<Four>()); });
        each_lane(saved[n].signs, [&](int i) {
            const auto signs = in.read<std::uint8_t>();
            Four impulse{};
            for (int k = 0; float& x : impulse) x = (signs >> k++ & 1) != 0 ? -0.0f : 0.0f;
            set_impulse(batches[n], i, impulse);
        });
    }
}

std::vector<SavedBatch> read_batches(ByteReader& in, std::size_t count) {
    std::vector<SavedBatch> saved(count);
    for (SavedBatch& batch : saved) batch = in.read<SavedBatch>();
    return saved;
}

// What a block needs room for.
struct Counts {
    std::uint32_t pairs = 0, obstacles = 0;
};

}  // namespace

void Contacts::save(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block, ByteWriter& out) const {
    BodyAddresses addresses(grid, block);
    const auto stays = [&](std::uint32_t slot) { return slot < bodies.count() && (bodies.properties[slot].flags & kRemoved) == 0; };
    const std::span<const Batch> pairs = this->pairs(block), obstacles = obstacle_contacts(block);
    out.write(Counts{static_cast<std::uint32_t>(pairs.size()), static_cast<std::uint32_t>(obstacles.size())});

    std::vector<Batch> from_places(pairs.begin(), pairs.end());
    refresh_pairs(from_places, bodies.place.data(), std::numeric_limits<float>::infinity());
    std::vector<SavedBatch> saved(pairs.size());
    for (std::size_t n = 0; n < pairs.size(); ++n) {
        const Batch& batch = pairs[n];
        for (int i = 0; i < kLanes; ++i) {
            if (!stays(batch.a[i]) || !stays(batch.b[i])) continue;
            const auto bit = static_cast<std::uint8_t>(1u << i);
            saved[n].used |= bit;
            if (!same_bits(place_of(batch, i), place_of(from_places[n], i))) saved[n].apart |= bit;
        }
        saved[n].touching = pair_touches(block)[n] & saved[n].used;
        look_at_impulses(batch, saved[n]);
    }
    for (const std::uint32_t lane : fast_lanes(block))
        saved[lane / kLanes].fast |= static_cast<std::uint8_t>((1u << lane % kLanes) & saved[lane / kLanes].used);
    for (const SavedBatch& batch : saved) out.write(batch);
    for (std::size_t n = 0; n < saved.size(); ++n) {
        each_lane(saved[n].used, [&](int i) {
            out.write(addresses.address(pairs[n].a[i]));
            out.write(addresses.address(pairs[n].b[i]));
        });
        each_lane(saved[n].apart, [&](int i) { out.write(place_of(pairs[n], i)); });
    }
    save_impulses(pairs, saved, out);

    // A normal towards an obstacle depends on the one before.
    saved.assign(obstacles.size(), {});
    const ObstacleLane* lanes_of = obstacle_lanes(block);
    for (std::size_t n = 0; n < obstacles.size(); ++n) {
        for (int i = 0; i < kLanes; ++i)
            if (stays(obstacles[n].a[i])) saved[n].used |= static_cast<std::uint8_t>(1u << i);
        saved[n].touching = obstacle_touches(block)[n] & saved[n].used;
        look_at_impulses(obstacles[n], saved[n]);
    }
    for (const SavedBatch& batch : saved) out.write(batch);
    for (std::size_t n = 0; n < saved.size(); ++n)
        each_lane(saved[n].used, [&](int i) {
            out.write(addresses.address(obstacles[n].a[i]));
            out.write(lanes_of[n * kLanes + static_cast<std::size_t>(i)]);
            out.write(place_of(obstacles[n], i));
        });
    save_impulses(obstacles, saved, out);
}

Result<void> Contacts::load(const Setup& setup, std::span<const std::span<const std::byte>> of_block, Workers& workers) {
    const std::size_t blocks = setup.grid.blocks().size();
    MELD_EXPECT(of_block.size() == blocks, "{} of {} blocks", of_block.size(), blocks);
    const std::size_t per_chunk = batches_per_chunk(setup.bodies, workers);
    pairs_ = Layout(), obstacles_ = Layout();
    pairs_.of_block.resize(blocks), obstacles_.of_block.resize(blocks);
    fast_lanes_.assign(blocks, {});
    for (std::size_t b = 0; b < blocks; ++b) {
        if (of_block[b].empty()) continue;
        ByteReader in(of_block[b], "the contacts of a snapshot", ByteReader::Origin::Outside);
        const auto counts = in.read<Counts>();
        if ((std::size_t{counts.pairs} + counts.obstacles) * sizeof(SavedBatch) > in.left())
            return damaged_snapshot("ends in the midst of its contacts");
        pairs_.of_block[b] = room(pairs_.chunks, counts.pairs, Kind::Pairs, per_chunk);
        obstacles_.of_block[b] = room(obstacles_.chunks, counts.obstacles, Kind::Obstacles, per_chunk);
    }
    pairs_.number(), obstacles_.number();
    std::atomic<std::size_t> candidates{0}, wrong{0};
    workers.run(blocks, [&](int, std::size_t b) {
        if (of_block[b].empty()) return;
        const auto block = static_cast<std::uint32_t>(b);
        ByteReader in(of_block[b], "the contacts of a snapshot", ByteReader::Origin::Outside);
        in.read<Counts>();
        if (!load_pairs(setup, block, in) || !load_obstacles(setup, block, in) || in.failed() || !in.done()) ++wrong;
        sort_kinds(pairs_.of_block[b], setup);
        sort_kinds(obstacles_.of_block[b], setup);
        std::size_t here = 0;
        for (const Batch& batch : pairs(b))
            for (int i = 0; i < kLanes; ++i) here += batch.a[i] < setup.bodies.count() ? 1 : 0;
        candidates += here;
    });
    candidates_ = candidates;
    if (wrong > 0) return damaged_snapshot("has invalid contacts");
    return {};
}

bool Contacts::load_pairs(const Setup& setup, std::uint32_t block, ByteReader& in) {
    const Bodies& bodies = setup.bodies;
    const BodyAddresses addresses(setup.grid, block);
    const std::uint32_t nobody = motionless_slot(bodies, block);
    const std::span<Batch> batches = pairs(block);
    const std::vector<SavedBatch> saved = read_batches(in, batches.size());
    bool fine = true;
    std::vector<Four> apart;
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Batch& batch = batches[n];
        begin(batch);
        pair_touches(block)[n] = saved[n].touching;
        for (int i = 0; i < kLanes; ++i) {
            batch.a[i] = batch.b[i] = nobody;
            if ((saved[n].used >> i & 1) == 0) continue;
            const std::uint32_t a = addresses.slot(in.read<std::uint32_t>()), b = addresses.slot(in.read<std::uint32_t>());
            if (a == kNoSlot || b == kNoSlot || a == b) {
                fine = false;
                continue;
            }
            batch.a[i] = a, batch.b[i] = b;
            batch.friction[i] =
                common_friction(setup.materials[bodies.properties[a].material], setup.materials[bodies.properties[b].material]);
            if ((saved[n].fast >> i & 1) != 0)
                fast_lanes_[block].push_back(static_cast<std::uint32_t>(n * kLanes + static_cast<std::size_t>(i)));
        }
        each_lane(saved[n].apart, [&](int) { apart.push_back(in.read<Four>()); });
    }
    refresh_pairs(batches, bodies.place.data(), std::numeric_limits<float>::infinity());
    auto next = apart.begin();
    for (std::size_t n = 0; n < batches.size(); ++n) each_lane(saved[n].apart, [&](int i) { set_place(batches[n], i, *next++); });
    load_impulses(batches, saved, in);
    return fine;
}

bool Contacts::load_obstacles(const Setup& setup, std::uint32_t block, ByteReader& in) {
    const Bodies& bodies = setup.bodies;
    const BodyAddresses addresses(setup.grid, block);
    const std::uint32_t nobody = motionless_slot(bodies, block);
    const std::span<Batch> batches = obstacle_contacts(block);
    const BlockBatches stretch = obstacles_.of_block[block];
    const std::vector<SavedBatch> saved = read_batches(in, batches.size());
    for (std::size_t n = 0; n < batches.size(); ++n) {
        Batch& batch = batches[n];
        begin(batch);
        stretch.touching[n] = saved[n].touching;
        for (int i = 0; i < kLanes; ++i) {
            ObstacleLane& lane = stretch.lanes[n * kLanes + static_cast<std::size_t>(i)];
            batch.a[i] = batch.b[i] = nobody, lane = {0, 0};
            if ((saved[n].used >> i & 1) == 0) continue;
            const std::uint32_t a = addresses.slot(in.read<std::uint32_t>());
            lane = in.read<ObstacleLane>();
            if (a == kNoSlot || lane.obstacle >= setup.obstacles.count() || lane.part >= kMaxSurfaceContacts) return false;
            batch.a[i] = a, batch.b[i] = slot_of_obstacle(bodies, setup.obstacles, setup.grid.blocks().size(), block, lane.obstacle);
            batch.friction[i] =
                common_friction(setup.materials[bodies.properties[a].material], setup.materials[setup.obstacles.material(lane.obstacle)]);
            set_place(batch, i, in.read<Four>());
        }
    }
    load_impulses(batches, saved, in);
    return true;
}

}  // namespace meld::physics
