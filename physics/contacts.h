// Contacts in batches of eight lanes. The batches are laid out when the candidate list is made and then stay: a batch's lanes
// share no body, its impulses stay in place from tick to tick, and candidates that do not touch are lanes whose gap is wide.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/block_grid.h"
#include "physics/bodies.h"
#include "physics/chunks.h"
#include "physics/lanes.h"
#include "physics/material.h"
#include "physics/obstacles.h"
#include "physics/pair_search.h"

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

// The gap of a lane without a contact, m: so wide that nothing comes of it, so small that its products stay finite.
inline constexpr float kNoContactGap = 1e6f;

// Beside a batch where bodies can bounce: the share of the approach that is left, the velocity to part with, m/s, 0 where there
// is none, and the largest impulse of the tick.
struct Bounce {
    Lanes restitution;
    Lanes speed;
    Lanes peak;
};

// What a lane of an obstacle batch meets: the obstacle, and which of several contacts with it.
struct ObstacleLane {
    std::uint32_t obstacle;
    std::uint32_t part;
};

// One contact's memory while the batches are laid out anew, as seen from the body with the lower id.
struct CarriedContact {
    std::uint32_t id;
    std::uint32_t partner;
    float normal_impulse;
    float tangent[3];
    bool touching;
};

// The partner's code of an obstacle's contact; body ids are lower.
constexpr std::uint32_t obstacle_code(ObstacleLane lane) { return 0x80000000u | lane.obstacle << 2 | lane.part; }

constexpr std::uint32_t obstacle_of_code(std::uint32_t code) { return (code & 0x7fffffffu) >> 2; }

class Contacts {
  public:
    struct Setup {
        const BlockGrid& grid;
        Bodies& bodies;
        const Obstacles& obstacles;
        std::span<const Material> materials;
        double reach_m;
    };
    // Takes impulses and touch out of the batches, to be given back by `lay_out`; the batches are gone then. Returns the contacts
    // that touched a body flagged kRemoved, which end here.
    std::vector<CarriedContact> carry(const Bodies& bodies, Workers& workers);
    // Lays out the batches of the pairs that the grid finds in the blocks for which `wanted` says so (null: all). The bodies get
    // their motionless entries.
    void lay_out(const Setup& setup, const std::vector<bool>* wanted, Workers& workers);
    // Between the two: the memory that other parts of the world need.
    std::vector<CarriedContact> carried_of(const std::vector<bool>& ids_wanted) const;
    void add_carried(std::vector<CarriedContact> contacts);
    // Forgets impulses and touch, for a state that did not come of the last one.
    void forget(Workers& workers);

    std::span<const Batch> pairs(std::size_t block) const { return const_cast<Contacts*>(this)->pairs(block); }
    std::span<Batch> pairs(std::size_t block) { return {pairs_.data() + pair_first_[block], pairs_.data() + pair_first_[block + 1]}; }
    std::span<const Batch> obstacle_contacts(std::size_t block) const { return const_cast<Contacts*>(this)->obstacle_contacts(block); }
    std::span<Batch> obstacle_contacts(std::size_t block) {
        return {obstacles_.data() + obstacle_first_[block], obstacles_.data() + obstacle_first_[block + 1]};
    }
    std::span<const ObstacleLane> obstacle_lanes(std::size_t block) const {
        return {lanes_.data() + kLanes * obstacle_first_[block], lanes_.data() + kLanes * obstacle_first_[block + 1]};
    }
    std::uint32_t first_pair_batch(std::size_t block) const { return pair_first_[block]; }
    std::uint32_t first_obstacle_batch(std::size_t block) const { return obstacle_first_[block]; }
    std::size_t pair_batch_count() const { return pairs_.size(); }
    std::size_t obstacle_batch_count() const { return obstacles_.size(); }
    std::size_t candidate_count() const { return candidates_; }

    // A bit a lane: whether it touches. One byte a batch, first all pair batches, then those with obstacles.
    Buffer<std::uint8_t> touching;
    // Of pair batches, empty unless some body has latches: the holding impulse of a lane per second, N.
    Buffer<Lanes> adhesion;
    // Empty unless some material bounces; in the order of `touching`.
    Buffer<Bounce> bounces;

    void need_adhesion();
    void need_bounces(const Setup& setup);
    std::size_t bytes() const;

  private:
    struct Arena;
    struct Former;
    Former sort_carried(const Bodies& bodies, Workers& workers);
    const BodyPair* collect(const Setup& setup, std::uint32_t block, Arena& arena);
    void collect_obstacles(const Setup& setup, std::uint32_t block, Arena& arena);
    void fill(const Setup& setup, std::uint32_t block, const BodyPair* pair, const Arena& arena, const Former& former);

    Buffer<Batch> pairs_, obstacles_;
    Buffer<ObstacleLane> lanes_;
    std::vector<std::uint32_t> pair_first_, obstacle_first_;
    // By block, while the batches are laid out: where its lanes with obstacles begin among those of its worker.
    std::vector<std::uint32_t> obstacle_arena_first_;
    std::vector<Chunks<CarriedContact>> carried_;
    std::size_t candidates_ = 0;
};

}  // namespace meld::physics
