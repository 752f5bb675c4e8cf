// Contacts in batches of eight lanes. The batches are laid out when the candidate list is made and then stay: a batch's lanes
// share no body, its impulses stay in place from tick to tick, and candidates that do not touch are lanes whose gap is wide.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/chunks.h"
#include "physics/bodies/composites.h"
#include "physics/bodies/lanes.h"
#include "physics/bodies/material.h"
#include "physics/collision/block_grid.h"
#include "physics/collision/obstacles.h"
#include "physics/collision/pair_search.h"
#include "physics/solver/warm_start_cache.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"

namespace meld::physics {

// Eight contacts between bodies `a` and `b`, given by slots. The normal points from a to b; impulses act on b, and reversed on
// a, in N s. Lanes without a contact name twice the block's motionless entry. Bodies of a batch are all different, but for that entry.
struct alignas(32) Batch {
    std::uint32_t a[kLanes];
    std::uint32_t b[kLanes];
    Lanes nx, ny, nz;
    Lanes gap;
    Lanes friction;
    Lanes normal_impulse;
    Lanes tx, ty, tz;
};

// The gap of a lane without a contact, m: wide enough to have no effect, small enough that its products stay finite.
inline constexpr float kNoContactGap = 1e6f;

// The slot of a block's motionless entry.
inline std::uint32_t motionless_slot(const Bodies& bodies, std::uint32_t block) {
    return static_cast<std::uint32_t>(bodies.count()) + block;
}

// The slot that a body's contact with an obstacle has as its second body: the block's motionless entry; of an obstacle with a belt, an
// entry of the block that has it as surface velocity. Where the obstacle moves, it is an entry of the lane instead, which follows the
// others (motions/obstacle_lanes.cpp).
inline std::uint32_t slot_of_obstacle(const Bodies& bodies, const Obstacles& obstacles, std::size_t blocks, std::uint32_t block,
                                      std::uint32_t obstacle) {
    return motionless_slot(bodies, block) + static_cast<std::uint32_t>(blocks * obstacles.belt(obstacle));
}

// A batch without bodies yet: gaps are wide, and nothing presses.
inline void begin(Batch& batch) {
    const Lanes nothing = lanes(0);
    batch.nx = batch.ny = batch.nz = batch.friction = batch.normal_impulse = batch.tx = batch.ty = batch.tz = nothing;
    batch.gap = lanes(kNoContactGap);
}

// Beside a batch where bodies can bounce: the share of the approach speed with which they separate, and the impulses of the
// bounces in this tick, N s.
struct alignas(32) Bounce {
    Lanes restitution;
    Lanes impulse;
};

// What a lane of an obstacle batch touches: the obstacle, and which of several contacts with it.
struct ObstacleLane {
    std::uint32_t obstacle;
    std::uint32_t part;
};

// The code of an obstacle's contact as a partner; body ids are lower.
constexpr std::uint32_t obstacle_code(ObstacleLane lane) {
    MELD_EXPECT(lane.part < kMaxSurfaceContacts && lane.obstacle < (1u << 29), "obstacle {}, contact {}", lane.obstacle, lane.part);
    return 0x80000000u | lane.obstacle << 2 | lane.part;
}

constexpr std::uint32_t obstacle_of_code(std::uint32_t code) {
    MELD_EXPECT(code >= kMaxBodies, "{} is a body", code);
    return (code & 0x7fffffffu) >> 2;
}

class Contacts {
  public:
    struct Setup {
        const BlockGrid& grid;
        Bodies& bodies;
        const Obstacles& obstacles;
        std::span<const Material> materials;
        PairSearch::Reach reach;
        // Obstacles are searched as far as a body may travel in this time, in addition.
        double ahead_s = 0;
        // Contacts of their members lie in batches of their own; null or empty: there are none.
        const Composites* composites = nullptr;
        // Some bodies have shapes: their contacts are elsewhere (shape_contacts.h).
        bool has_shapes = false;
    };
    // Takes impulses and touch flags out of the batches and frees the batches; `lay_out` puts them into the new ones. Returns the contacts
    // that touched a body flagged kRemoved, or between two bodies that are indifferent to each other now, which end here.
    std::vector<CachedContact> take_out(const Bodies& bodies, const Composites& composites, Workers& workers);
    // Lays out the batches of the pairs that the grid finds in the blocks for which `wanted` is true (null: all). Adds the motionless
    // entries to the bodies.
    void lay_out(const Setup& setup, const std::vector<bool>* wanted, Workers& workers);
    // Between take_out and lay_out: the cached contacts that other subdomains need.
    std::vector<CachedContact> cached_of(const std::vector<bool>& ids_wanted) const;
    void add_cached(std::vector<CachedContact> contacts);
    // In a snapshot (saved_contacts.cpp): the batches of a block, as they lie, without lanes of bodies flagged kRemoved, which end in the
    // next list; and back, each block from its bytes. The bodies are those of the grid then. Errors: they name what is not there.
    void save(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block, ByteWriter& out) const;
    Result<void> load(const Setup& setup, std::span<const std::span<const std::byte>> of_block, Workers& workers);
    // Adds the motionless entries, one a block, and behind them those of obstacles with belts, one a block for each.
    static void add_motionless(Bodies& bodies, const Obstacles& obstacles, std::size_t blocks);
    // Forgets impulses and touches, for a state that did not follow from the last one.
    void forget(Workers& workers);

    std::span<const Batch> pairs(std::size_t block) const { return const_cast<Contacts*>(this)->pairs(block); }
    std::span<Batch> pairs(std::size_t block) { return pairs_.batches(block); }
    std::span<const Batch> obstacle_contacts(std::size_t block) const { return const_cast<Contacts*>(this)->obstacle_contacts(block); }
    std::span<Batch> obstacle_contacts(std::size_t block) { return obstacles_.batches(block); }
    // A block's batches are of three kinds, in this order: those without members of composites that move freely; pairs of two such members;
    // and those of a member (body a) with another body or an obstacle.
    std::span<Batch> plain_pairs(std::size_t block) { return pairs_.batches(block).first(pairs_.at(block).plain); }
    std::span<Batch> joint_pairs(std::size_t block) {
        return pairs_.batches(block).subspan(pairs_.at(block).plain, pairs_.at(block).joint);
    }
    std::span<Batch> mixed_pairs(std::size_t block) {
        return pairs_.batches(block).subspan(pairs_.at(block).plain + pairs_.at(block).joint);
    }
    std::span<Batch> plain_obstacles(std::size_t block) { return obstacles_.batches(block).first(obstacles_.at(block).plain); }
    std::span<Batch> mixed_obstacles(std::size_t block) { return obstacles_.batches(block).subspan(obstacles_.at(block).plain); }
    // The lanes of a block's pair batches, eight per batch, that hold pairs of fast bodies.
    std::span<const std::uint32_t> fast_lanes(std::size_t block) const {
        return block < fast_lanes_.size() ? std::span(fast_lanes_[block]) : std::span<const std::uint32_t>();
    }
    // Eight per batch with obstacles.
    const ObstacleLane* obstacle_lanes(std::size_t block) const { return obstacles_.at(block).lanes; }
    // One byte per batch, one bit per lane: whether it touches.
    std::uint8_t* pair_touches(std::size_t block) const { return pairs_.at(block).touching; }
    std::uint8_t* obstacle_touches(std::size_t block) const { return obstacles_.at(block).touching; }
    // The index of a block's first batch, counting through all blocks.
    std::uint32_t first_pair_batch(std::size_t block) const { return pairs_.at(block).first; }
    std::uint32_t first_obstacle_batch(std::size_t block) const { return obstacles_.at(block).first; }
    std::size_t pair_batch_count() const { return pairs_.count; }
    std::size_t obstacle_batch_count() const { return obstacles_.count; }
    std::size_t candidate_count() const { return candidates_; }

    // For pair batches, empty unless some body has latches: the holding impulse of a lane per second, N.
    Buffer<Lanes> adhesion;

    void need_adhesion();
    // Creates the bounces if the batches are new, and clears their impulses.
    void begin_bounces(const Setup& setup);
    // The bounces of a block's batches; empty unless some material bounces.
    std::span<Bounce> pair_bounces(std::size_t block) { return bounces_from(first_pair_batch(block), pairs_.at(block).count); }
    std::span<Bounce> obstacle_bounces(std::size_t block) {
        return bounces_from(pairs_.count + first_obstacle_batch(block), obstacles_.at(block).count);
    }
    std::span<const Bounce> pair_bounces(std::size_t block) const { return const_cast<Contacts*>(this)->pair_bounces(block); }
    std::span<const Bounce> obstacle_bounces(std::size_t block) const { return const_cast<Contacts*>(this)->obstacle_bounces(block); }
    std::size_t bytes() const;

  private:
    // Batches of several blocks, laid out one after the other by one worker. They do not move, and are freed together.
    struct Chunk {
        Buffer<Batch> batches;
        Buffer<std::uint8_t> touching;
        // For batches with obstacles.
        Buffer<ObstacleLane> lanes;
    };
    // Where a block's batches lie in a chunk.
    struct BlockBatches {
        Batch* batches = nullptr;
        std::uint8_t* touching = nullptr;
        ObstacleLane* lanes = nullptr;
        std::uint32_t first = 0, count = 0;
        // How many of them are plain, and how many of the rest are of two members.
        std::uint32_t plain = 0, joint = 0;
    };
    // All batches of one kind. A list that was never laid out has no blocks.
    struct Layout {
        std::vector<Chunk> chunks;
        std::vector<BlockBatches> of_block;
        std::size_t count = 0;

        BlockBatches at(std::size_t block) const { return block < of_block.size() ? of_block[block] : BlockBatches(); }
        std::span<Batch> batches(std::size_t block) const { return {at(block).batches, at(block).count}; }
        void number();
        std::size_t bytes() const;
    };
    struct Arena;
    enum class Kind { Pairs, Obstacles };
    // A chunk is freed as a whole: large enough for huge pages, small compared with all contacts.
    static constexpr std::size_t kFewBatches = 256, kChunksOfFew = 8;
    static constexpr std::size_t kMaxBatchesPerChunk = 2 * kLargeBytes / sizeof(Batch);
    static std::size_t batches_per_chunk(const Bodies& bodies, const Workers& workers);
    // Room for the batches of a block in the last chunk, or in a new one of `per_chunk` batches; the first chunks for batches with
    // obstacles are smaller. Those have room for their lanes too.
    static BlockBatches room(std::vector<Chunk>& chunks, std::size_t batches, Kind kind, std::size_t per_chunk);
    // False if they name what is not there.
    bool load_pairs(const Setup& setup, std::uint32_t block, ByteReader& in);
    bool load_obstacles(const Setup& setup, std::uint32_t block, ByteReader& in);
    // Tells the kinds of batches apart by their bodies.
    static void sort_kinds(BlockBatches& stretch, const Setup& setup);
    void lay_out_pairs(const Setup& setup, std::uint32_t block, Arena& arena, const WarmStartCache& former);
    void lay_out_obstacles(const Setup& setup, std::uint32_t block, Arena& arena, const WarmStartCache& former);

    std::span<Bounce> bounces_from(std::size_t first, std::size_t count) {
        if (bounces_.empty()) return {};
        MELD_ASSERT(first + count <= bounces_.size(), "{} + {} of {}", first, count, bounces_.size());
        return std::span(bounces_).subspan(first, count);
    }

    // First those of all pair batches, then those of obstacle batches.
    Buffer<Bounce> bounces_;
    Layout pairs_, obstacles_;
    std::vector<Chunks<CachedContact>> cached_;
    // By block; empty if nothing is fast.
    std::vector<std::vector<std::uint32_t>> fast_lanes_;
    std::size_t candidates_ = 0;
};

}  // namespace meld::physics
