// The share of one process in a divided world. Blocks have owners; a subdomain holds the bodies of its own blocks and, as ghosts, those of
// all blocks around them. The owner of a block solves its pairs. The others receive the results after every coloured stage, and because no
// two blocks of a colour touch the same body, the results are those of the undivided world, bit for bit.
//
// A tick, the same on all subdomains (here `part`; the caller decides how the bytes are sent):
//
//     if (any part: part.recomposes()) {
//         for (destination, bytes : part.pack_members(of all parts: part.members_held())) send;
//         for each received: part.unpack_members(bytes);
//         part.recompose(workers);
//     }
//     if (any part: part.recomposes() or part.must_rebuild(dt, substeps)) {
//         part.set_velocities(of all parts, added: part.velocities(), dt, substeps);
//         for (destination, bytes : part.pack_bodies(workers)) send;    for each received: part.unpack_bodies(bytes);
//         part.unpacked();
//     }
//     for (stage : part.stages(dt, substeps)) {
//         part.run(stage, workers);
//         if (stage.must_agree()) {
//             part.agree_on_bounces(of all parts: part.bouncing_blocks());
//             leave out the next stage.left_out(all parts: part.bouncing_colours(), joined) stages;
//         }
//         if (stage.must_exchange()) { for (destination, bytes : part.pack(stage)) send;    for each received: part.unpack(stage, bytes); }
//     }                                                (a stage that has_rounds() is run and exchanged part.rounds() times)
//     part.finish();
//
// A subdomain that has a body of a mechanism, its own or a ghost, has all bodies that joints hold to it, as ghosts, wherever they are, and
// the joints. It solves the mechanism as all others do that have it: from the same velocities, with the same bits.
//
// Where some have joints and others are parts of composites (Scene::have_all_joined), all subdomains have all of both.
//
// The same is true of composites. All subdomains know all connections; a scene that is shared (Scene::share) makes and breaks
// connections of bodies that it has not. When that changes composites, those that have some of the bodies of a new one get the others
// before the step. Each block that has contacts of a composite has its copy of it (composite_rows.h), and after each sweep, all who have
// the composite learn the velocities of all copies and take their mean in the order of the blocks. Composites that collide with
// restitution do so block after block, in the order of the blocks, whoever owns them. What contacts do to members whose loads somebody
// wants, all who have the composite learn at the end of the step, and add it up in that order.
//
// The settings name the least and the largest radius, and the least thickness if bodies have shapes. Feature tables, materials and
// obstacles are added on all subdomains alike, and every action on a body is repeated on each subdomain that has it. So are all joints, and
// before them the bodies that they hold, as ghosts where they are not the subdomain's own.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "physics/bodies/stage.h"
#include "physics/collision/block_grid.h"
#include "physics/collision/broadphase.h"
#include "physics/joints/joints.h"
#include "physics/scene/scene.h"
#include "physics/solver/composite_copies.h"
#include "physics/statics/loads.h"
#include "runtime/base/bytes.h"

namespace meld::physics {

class BlockEngine;

class Subdomain {
  public:
    using Bytes = std::span<const std::byte>;
    // The bytes to send to each subdomain, by its number.
    using Messages = std::map<int, ByteWriter>;
    using OwnerOf = std::function<int(BlockCoordinates)>;

    // The scene has the engine Blocks and outlives the subdomain, the one with the number `self` of `parts`. `owner` returns the same on
    // all subdomains and may change between ticks, before a rebuild.
    Subdomain(Scene& scene, OwnerOf owner, int self, int parts);

    // Connections have changed since the last step: whether composites do that have bodies here. Which parts have some body of each new
    // one; the bodies that these do not have yet; then the change, on all parts alike.
    bool recomposes();
    ByteWriter members_held() const;
    using OfParts = std::vector<std::vector<std::byte>>;
    Messages pack_members(const OfParts& held);
    Result<void> unpack_members(Bytes bytes);
    void recompose(Workers& workers);

    bool must_rebuild(double dt_s, int substeps) const;
    // The velocities of our bodies; then, before any other step of a rebuild, those of the bodies of all subdomains.
    Velocities velocities() const;
    void set_velocities(const Velocities& all, double dt_s, int substeps);
    // The bodies that others need, with the warm-start impulses of their contacts; ghosts are dropped, and bodies in blocks of others
    // become theirs.
    Messages pack_bodies(Workers& workers);
    // The bodies that pack_bodies found in blocks of others, with their new owners; sorted.
    const std::vector<std::pair<BodyId, int>>& departed() const { return departed_; }
    Result<void> unpack_bodies(Bytes bytes);
    void unpacked();
    // After Scene::loaded: the bodies of our blocks and, as ghosts, those around them came from a snapshot.
    void loaded();

    // Of a snapshot with joints or composites, before Scene::loaded, when the rest of all subdomains and the homes are there: each
    // subdomain learns where their bodies are, and gets those that it needs. `also`: more pairs of bodies that are needed where one of
    // them is.
    struct JoinedBody {
        BodyId id;
        std::uint32_t fixed;
        Home home;
    };
    using Pairs = std::span<const std::pair<BodyId, BodyId>>;
    bool has_joined() const;
    std::vector<JoinedBody> joined_bodies(Pairs also) const;
    void learn_joined(std::span<const JoinedBody> all, Pairs also);
    Messages pack_joined() const;
    Result<void> unpack_joined(Bytes bytes);

    std::vector<Stage> stages(double dt_s, int substeps);
    Result<void> run(const Stage& stage, Workers& workers);
    // After a stage that must_agree(); see Stage::left_out.
    std::uint8_t bouncing_colours() const;
    // Whether any part has composites: only then, the blocks in which they bounce now.
    bool shares_composites() const;
    ByteWriter bouncing_blocks() const;
    void agree_on_bounces(const OfParts& blocks);
    int rounds() const { return static_cast<int>(rounds_.size()); }
    // What the stage changed in bodies that others hold: velocities (28 bytes a body, 24 a copy of a composite), feature wrenches, or which
    // blocks rest, and which of them joints and composites link.
    Messages pack(const Stage& stage) const;
    void unpack(const Stage& stage, Bytes bytes);
    StepReport finish();
    // What Scene::sum_normal_forces has summed for bodies of others, to be sent to their owners, who add it to their own sums.
    Messages pack_sums(std::span<const ExactSum> of_slot) const;
    void unpack_sums(std::span<ExactSum> of_slot, Bytes bytes) const;

    // The owner of a body in one of our blocks or next to them, since the last rebuild.
    int owner_of(BodyId body) const;
    // The other subdomains that have such a body, as its owner or as a ghost. Ascending.
    const std::vector<int>& holders_of(BodyId body) const;
    // The work that our bodies cause, by the block that each is in now, as the coming rebuild will divide space; a block may occur several
    // times. Bodies that sleep or are fixed weigh little.
    std::vector<std::pair<BlockCoordinates, std::uint32_t>> weights() const;
    // The side of a block in the coming rebuild.
    double block_m() const;

    // Our blocks next to blocks of others.
    std::vector<BlockCoordinates> border_blocks() const;

    // Subdomains other than ours that hold a block. Ascending.
    std::vector<int> holders(BlockCoordinates block) const;

  private:
    // The index of the block in which a body was at the last rebuild.
    std::uint32_t block_with(BodyId body) const;
    // For a block that contains one of our bodies: its owner and the subdomains that hold it.
    struct Standing {
        BlockCoordinates block;
        int owner;
        bool near_us;
        std::vector<int> holders;
    };
    Standing standing(BlockCoordinates block) const;
    // All subdomains that hold a block. Ascending.
    std::vector<int> holding(BlockCoordinates block) const;
    // By body with joints, those that have it: they hold a block of some body of its mechanisms, or of the pair. Ascending.
    using Holding = std::unordered_map<BodyId, std::vector<int>>;
    Holding holding_joined(const Joints::Groups& groups, Pairs also, const std::function<BlockCoordinates(BodyId)>& block_of) const;
    // Takes out the joints that are not needed here any more; returns those that others need and do not have.
    std::map<int, std::vector<Joint>> hand_over_joints(const Joints::Groups& groups, const Holding& holding);
    // Where all have all of them (Scene::have_all_joined).
    Holding held_by_all(Pairs also) const;
    std::vector<int> everybody() const;
    void keep_joints(const std::vector<bool>& kept);
    // The same of composites (subdomain_composites.cpp): by destination, their places among all; and which of them stay here.
    std::map<int, std::vector<std::uint32_t>> hand_over_composites(const Holding& holding, std::vector<bool>& kept) const;
    void pack_composites(const std::vector<std::uint32_t>& composites, ByteWriter& out) const;
    void unpack_composites(ByteReader& in);
    void drop_composites(const std::vector<bool>& kept);
    // The other subdomains that have had a body since the last step.
    std::vector<int> had(BodyId body) const;
    void plan_copies();
    void add_copies();
    void pack_links(Messages& messages) const;
    void unpack_links(ByteReader& in);
    void pack_copies(Messages& messages) const;
    void unpack_copies(ByteReader& in);
    void begin_round(int round);
    void pack_bounces(const Stage& stage, Messages& messages) const;
    void unpack_bounces(ByteReader& in);
    void pack_loads(Messages& messages) const;
    void unpack_loads(ByteReader& in);
    // After a rebuild: by colour and destination, the slots that our blocks of the colour touch and that the destination holds.
    void plan_exchange();

    Scene& scene_;
    World& world_;
    BlockEngine& engine_;
    OwnerOf owner_;
    int self_, parts_;
    StepTimes times_{1, 1};
    std::array<std::map<int, std::vector<std::uint32_t>>, kColours> touched_;
    std::map<int, std::vector<std::uint32_t>> border_;
    std::vector<std::vector<int>> holders_of_block_;
    std::vector<std::pair<BodyId, int>> departed_;
    // By body with joints: the other subdomains that have it. Before the first rebuild all have all, which is here only if they always do.
    Holding joined_holders_;
    bool all_have_joints_ = true;
    // While a snapshot is loaded.
    Holding loading_joined_;

    // Whether composites that have bodies here change; and that still ticks of this step have been counted.
    bool changes_here_ = false, counted_ = false;
    // Of composites on their way here: what their loads are found from.
    Loads::OfComposites of_composites_;
    // Copies of composites of our blocks, by the subdomains that have the composite; those elsewhere, in the order in which others send
    // them, and by subdomain the first of them and their number.
    std::map<int, std::vector<PlaceOfCopy>> copies_to_;
    std::vector<CopyName> names_elsewhere_;
    std::vector<PlaceOfCopy> copies_elsewhere_;
    std::map<int, std::pair<std::size_t, std::size_t>> copies_from_;
    bool copies_are_new_ = false;
    // Blocks in which composites bounce, in order, those of one subdomain after the other.
    struct Round {
        int part;
        std::vector<std::uint64_t> blocks;
    };
    std::vector<Round> rounds_;
};

}  // namespace meld::physics
