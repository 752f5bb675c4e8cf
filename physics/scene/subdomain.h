// One process's part of a divided world. Blocks have owners; a part holds the bodies of its own blocks and, as ghosts, those of
// all blocks around them. A block's pairs are solved by its owner. Others hear of it after every coloured stage, and because no
// two blocks of a colour touch the same body, the numbers are those of the undivided world, bit for bit.
//
// A tick, the same on all parts (who carries the bytes is not decided here):
//
//     if (any part: part.must_rebuild(dt, substeps)) {
//         part.set_velocities(of all parts, added: part.velocities(), dt, substeps);
//         for (destination, bytes : part.pack_bodies(workers)) send;    for each received: part.unpack_bodies(bytes);
//         part.unpacked();
//     }
//     for (stage : part.stages(dt, substeps)) {
//         part.run(stage, workers);
//         if (stage.must_agree()) leave out the next stage.left_out(all parts: part.bouncing_colours(), joined) stages;
//         if (stage.must_exchange()) { for (destination, bytes : part.pack(stage)) send;    for each received: part.unpack(stage, bytes); }
//     }
//     part.finish();
//
// The settings name the least and the largest radius; feature tables, materials and obstacles are added alike on all parts, and
// what acts on a body is done on every part that has it.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "physics/block_grid.h"
#include "physics/broadphase.h"
#include "physics/scene/scene.h"
#include "physics/stage.h"
#include "runtime/base/bytes.h"

namespace meld::physics {

class BlockEngine;

class Subdomain {
  public:
    using Bytes = std::span<const std::byte>;
    // What was written for each part, by its number.
    using Messages = std::map<int, ByteWriter>;
    using OwnerOf = std::function<int(BlockCoordinates)>;

    // The scene has the engine Blocks and outlives the part. `owner` says the same on all parts and may change between ticks,
    // before a rebuild.
    Subdomain(Scene& scene, OwnerOf owner, int self);

    bool must_rebuild(double dt_s, int substeps) const;
    // The velocities of our bodies; then, before anything else of a rebuild, those of all parts' bodies.
    Velocities velocities() const;
    void set_velocities(const Velocities& all, double dt_s, int substeps);
    // Bodies that others need, with the memory of their contacts; ghosts go, bodies in blocks of others become theirs.
    Messages pack_bodies(Workers& workers);
    // Of the bodies that pack_bodies found in blocks of others, and whose they are now; sorted.
    const std::vector<std::pair<BodyId, int>>& departed() const { return departed_; }
    Result<void> unpack_bodies(Bytes bytes);
    void unpacked();

    std::vector<Stage> stages(double dt_s, int substeps);
    Result<void> run(const Stage& stage, Workers& workers);
    // After a stage that must_agree(); see Stage::left_out.
    std::uint8_t bouncing_colours() const;
    // What the stage changed of bodies that others hold: velocities (28 bytes a body), pulls, or which blocks rest.
    Messages pack(const Stage& stage) const;
    void unpack(const Stage& stage, Bytes bytes);
    StepReport finish();
    // What Scene::sum_normal_forces has summed up for bodies of others, to be sent to their owners, who add it to theirs.
    Messages pack_sums(std::span<const ExactSum> of_slot) const;
    void unpack_sums(std::span<ExactSum> of_slot, Bytes bytes) const;

    // Whose a body is that is ours or next to ours, since the last rebuild.
    int owner_of(BodyId body) const;
    // The other parts that have such a body, as its owner or as a ghost. Ascending.
    const std::vector<int>& holders_of(BodyId body) const { return holders_of_block_[block_with(body)]; }
    // What our bodies weigh in work, by the block that each is in now, as the coming rebuild will cut space; a block may come
    // several times. Bodies that sleep or are fixed weigh little.
    std::vector<std::pair<BlockCoordinates, std::uint32_t>> weights() const;
    // The side of a block in the coming rebuild.
    double block_m() const;

    // Our blocks next to others' blocks.
    std::vector<BlockCoordinates> border_blocks() const;

  private:
    // Parts other than ours that hold a block.
    std::vector<int> holders(BlockCoordinates block) const;
    // The index of the block in which a body was at the last rebuild.
    std::size_t block_with(BodyId body) const;
    // For a block that a body of ours is in: who owns and who holds it.
    struct Standing {
        BlockCoordinates block;
        int owner;
        bool near_us;
        std::vector<int> holders;
    };
    Standing standing(BlockCoordinates block) const;
    // After a rebuild: by colour and destination, the slots that our blocks of the colour touch and the destination holds.
    void plan_exchange();

    Scene& scene_;
    World& world_;
    BlockEngine& engine_;
    OwnerOf owner_;
    int self_;
    StepTimes times_{1, 1};
    std::array<std::map<int, std::vector<std::uint32_t>>, kColours> touched_;
    std::map<int, std::vector<std::uint32_t>> border_;
    std::vector<std::vector<int>> holders_of_block_;
    std::vector<std::pair<BodyId, int>> departed_;
};

}  // namespace meld::physics
