// The share of one process in a run, as modules see it: they read all of it and change it only by the operations here.
//
// Its state is stored in three places, and a module's own state in a fourth: which catoms there are (Membership), what they hold
// (FactStore), and the state of the run (Status). Data that exists only within a tick belongs to Tick (tick.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/program_actions.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/brick_counts.h"
#include "runtime/sim/catoms/fact_store.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/sim/catoms/status.h"
#include "runtime/sim/core/refusals.h"
#include "runtime/sim/network/network.h"
#include "runtime/sim/network/routes.h"
#include "runtime/sim/network/turns.h"
#include "runtime/world/description/world.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/shapes/joint_look.h"
#include "runtime/world/shapes/rounded_body.h"

namespace meld::sim {

class Subdomain {
  public:
    Subdomain(const ModuleInfo& module, const world::World& world, const world::Target& target, comm::Communicator& comm, int threads);
    Subdomain(const Subdomain&) = delete;
    Subdomain& operator=(const Subdomain&) = delete;

    // Places the catoms of this process and its ghosts, and gives them their ids and the world's facts. Every process calls it. `counted`:
    // by count_together(), if the run has done so.
    Result<void> populate(std::optional<BrickCounts> counted = {});

    // ---- constant for the run
    const ModuleInfo& module;
    const tuple::ProgramActions program_actions;
    const world::World& world;
    comm::Communicator& comm;
    Workers workers;
    bool alone() const { return comm.processes() == 1; }

    // ---- for reading
  private:
    Membership members_;
    FactStore facts_;
    Status status_;
    Refusals refusals_;
    std::optional<Network> network_;  // None: ideal, and all catoms act in every tick.
    std::optional<Turns> turns_;      // None: catoms act in every tick, or by themselves.
    std::optional<Routes> routes_;    // None: all facts go over links that their rules name.

  public:
    const world::Ensemble& ensemble = members_.ensemble;
    const world::Lattice& lattice = members_.ensemble.lattice();
    const tuple::Columns& columns = facts_.columns;
    const Totals& totals = status_.totals;
    const Refusals& refusals = refusals_;  // Of this process.
    const std::optional<partition::Partition>& partition = members_.partition;
    const std::optional<partition::Halo>& halo = members_.halo;

    // As the compiled module sees it; arrays after refresh().
    const SubdomainView& view() const { return abi_; }
    std::int64_t tick() const { return abi_.now; }
    // The arrays of the ensemble as compiled modules read them; after refresh().
    const Geometry& geometry() const { return abi_.geometry; }
    bool owned(Catom catom) const { return members_.owned(catom); }
    // The process that owns this catom.
    int owner_of(Catom catom) const { return members_.owner_of(catom); }
    // Above the numbers of all catoms that the ensemble has ever had; on lattices their count.
    std::uint64_t next_id() const { return members_.next_id; }
    // Whether there is or was a catom with this number.
    bool has_been(std::uint64_t id) const { return members_.nodes ? members_.nodes->find(id).has_value() : id < next_id(); }
    // Only in a graph world.
    const Nodes& nodes() const { return *members_.nodes; }
    // How many there were when the ensemble was made: @world.
    std::int64_t world_catoms() const { return abi_.world_catoms; }
    // The actions of the last tick, by the ids of their catoms.
    const std::vector<eval::Action>& actions() const { return facts_.evaluator.actions(); }
    // Linear facts that catoms of this process were sent in the last tick, by their rules and by modules; and those by modules among them,
    // with the same arguments. Nothing right after a snapshot has been restored.
    eval::Sent sent() const { return facts_.evaluator.all_sent(geometry()); }
    const std::vector<eval::Message>& sent_by_modules() const { return facts_.evaluator.requests().messages(); }
    // Those that catoms of this process sent to nodes without a link.
    const std::vector<eval::FarMessage>& sent_far() const { return facts_.evaluator.far_messages(); }
    // The catoms of this process that were evaluated in the last tick: nothing but what was sent to a catom has changed at others.
    // visit(catom, dirty), ascending, with why each of them was.
    template <class Visit>
    void each_evaluated(const Visit& visit) const {
        facts_.evaluator.each_evaluated(visit);
    }
    void add_changed(const std::vector<bool>& which, std::vector<u32>& catoms) const { facts_.evaluator.add_changed(which, catoms); }
    // Whoever follows learns from now on which catoms of this process, or ghosts, may have changed since it looked last.
    Touched& follow(Follows what = Follows::WhatIsSeen) { return facts_.follow(what); }
    // What a module keeps for a catom has changed.
    void touch(Catom catom) { facts_.touch(catom); }
    ActionKind kind_of(const eval::Action& action) const { return program_actions.kind_of(action.predicate); }
    const eval::Agenda& agenda() const { return facts_.evaluator.agenda(); }
    // Of the last tick on this process.
    const eval::Statistics& own_statistics() const { return facts_.evaluator.statistics(); }
    const eval::Timers& timers() const { return facts_.evaluator.timers(); }
    const eval::Tombstones& tombstones() const { return facts_.evaluator.tombstones(); }
    const Status& status() const { return status_; }
    // What is counted over the run; null: nothing.
    const eval::Counts* counts() const { return facts_.evaluator.counts(); }
    void count_evaluations() { facts_.evaluator.count_evaluations(); }
    // From now on the firings of these linear rules, by their numbers, are kept for a tick; and those of the last tick on this process.
    void tell_firings(std::vector<bool> rules) { facts_.evaluator.tell_firings(std::move(rules)); }
    std::vector<eval::Firing> firings() const { return facts_.evaluator.firings(); }
    // Where the time goes, from now on; the log lives as long as this.
    void measure(TickLog& log) {
        log_ = &log;
        facts_.evaluator.measure(log);
    }
    TickLog* log() { return log_; }
    // CPU time by rules; null: the module does not count.
    const eval::CpuSeconds* end_measuring() {
        log_ = nullptr;
        return facts_.evaluator.end_measuring();
    }
    // A catom's diameter, in units of the world's.
    bool has_diameters() const { return diameter_of_ != nullptr; }
    double diameter(Catom catom) const { return diameter_of_ ? diameter_of_(catom) : 1; }
    // What a catom looks like, where some are no spheres; and how it is turned, which is also known where joints hold spheres.
    bool has_rounded() const { return some_rounded_; }
    bool has_turns() const { return rounded_of_ != nullptr; }
    world::RoundedBody rounded(Catom catom) const { return rounded_of_ ? rounded_of_(catom) : world::RoundedBody(); }
    // What joints there are now, where the world has some.
    bool has_joints() const { return joints_ != nullptr; }
    std::vector<world::JointLook> joints() const { return joints_ ? joints_() : std::vector<world::JointLook>(); }
    std::size_t bytes() const {
        return members_.bytes() + facts_.bytes() + (network_ ? network_->bytes() : 0) + (routes_ ? routes_->bytes() : 0) + motion_bytes_;
    }
    // All processes learn which nodes and links there are now, if facts find their ways by them. Every process calls it, when all catoms
    // are there and at the end of each tick.
    void share_routes();
    // While the run goes on from tick to tick and nobody looks at facts in between, what catoms tell all their neighbours need not be
    // delivered before it is read; and it is delivered, before somebody looks after all.
    void leave_broadcasts(bool leave) { facts_.evaluator.leave_broadcasts(leave); }
    void deliver_broadcasts() { facts_.deliver_broadcasts(geometry()); }
    // Updates the arrays that the compiled module reads, after catoms or bricks have been added or removed.
    void refresh();

    // ---- facts from outside
    // Marks the catom if they change anything; neighbours see what its rules derive from them.
    bool give(u32 predicate, Catom catom, const Value* arguments) { return facts_.give(predicate, catom, arguments); }
    bool take(u32 predicate, Catom catom, const Value* arguments) { return facts_.take(predicate, catom, arguments); }
    // The same from all workers at once, for different catoms; the caller marks them. The last of these replaces a fact of numbers.
    bool give_shared(u32 predicate, Catom catom, const Value* arguments, int worker) {
        return facts_.give_shared(predicate, catom, arguments, worker);
    }
    bool take_shared(u32 predicate, Catom catom, const Value* arguments, int worker) {
        return facts_.take_shared(predicate, catom, arguments, worker);
    }
    // Marks catoms to which it has given the predicate, or from which it has taken it.
    void mark_given(u32 predicate, std::span<const Catom> catoms) { facts_.mark_given(predicate, catoms); }
    // It is the turn of these catoms of a group of the agenda, a bit each: in their next evaluation they have the fact that is given by
    // turns. From several workers at once, for groups of different blocks.
    void give_turn(u32 group, u64 catoms) { facts_.evaluator.agenda().mark_group(group, catoms, kDirtyTurn); }
    // Evaluator::tell_still_activated.
    void tell_still_activated(eval::Evaluator::StillActivated call) { facts_.evaluator.tell_still_activated(std::move(call)); }
    void give_numbers(u32 predicate, Catom catom, const tuple::Numbers& numbers, int worker) {
        tuple::give_numbers(module, facts_.columns, predicate, catom, numbers, worker);
        facts_.touch_shared(catom);
    }
    void mark(Catom catom, u64 bits) { facts_.mark(catom, bits); }
    // The same from all workers at once.
    void mark_shared(Catom catom, u64 bits) { facts_.mark_shared(catom, bits); }
    // Marks the catoms next to a cell, or to a catom.
    void mark_around(Cell cell, u64 bits);
    void mark_neighbours(Catom catom, u64 bits);
    // Calls visit(Catom) for the neighbours of a catom, in the order of its ports. Some may be ghosts.
    template <class Visit>
    void each_neighbour(Catom catom, const Visit& visit) const {
        ensemble.each_neighbour(catom, visit);
    }

    // ---- catoms on a lattice. Adding and removing them marks links around the cell. Arrays may move.
    Catom add_catom(std::uint64_t id, Cell cell, CatomState state);
    void remove_catom(Catom catom);
    // Within this process; the catom keeps its index.
    void move_catom(Catom catom, Cell to);
    // An amoebot occupies these cells now, or this one, which others do not; it may be a ghost.
    void reshape_catom(Catom catom, Cell head, Cell tail);
    // The same when all is as it was saved: nobody is marked.
    void restore_tail(Catom catom, Cell tail) { members_.ensemble.reshape(catom, ensemble.cell(catom), tail); }
    // Ids for new catoms, this many on all processes together; returns the first.
    std::uint64_t take_ids(std::uint64_t count);

    // ---- catoms that fail (runtime/sim/core/failures/catom_failures.h)
    // It hangs: it is not evaluated any more.
    void fall_silent(std::uint64_t id);
    // It no longer does, if it did.
    void wake_up(std::uint64_t id);
    bool is_silent(Catom catom) const { return !status_.hung.empty() && hangs(ensemble.id(catom)); }
    // A catom, owned or ghost, loses all that it has, and its links begin anew, in a world of links. Its neighbours are marked.
    void restart(Catom catom);

    // ---- catoms at arbitrary positions. A ghost has an owner, and is removed when nothing of this process touches it any more.
    Catom add_freely(std::uint64_t id, const world::Vec3& position, CatomState state, int owner);
    void remove_freely(Catom catom);
    void set_owner(Catom catom, int owner) { members_.set_owner(catom, owner); }
    // Returns whether it has entered or left the target. From all workers at once, for different catoms.
    bool place(Catom catom, const world::Vec3& position) {
        facts_.touch_shared(catom);
        return members_.ensemble.place(catom, position);
    }
    // Two catoms become or stop being neighbours over their ports; they are marked.
    void link(Catom a, int port_of_a, Catom b, int port_of_b);
    void unlink(Catom a, Catom b);
    // A link that a catom brings from its former process.
    void restore_link(Catom a, int port_of_a, Catom b, int port_of_b) { members_.ensemble.link(a, port_of_a, b, port_of_b); }
    // The positions that programs have sensed.
    bool senses_positions() const { return members_.senses_positions(); }
    world::Vec3 sensed_position(Catom catom) const { return members_.sensed_position(catom); }
    void sense_position(Catom catom, const world::Vec3& position) { members_.sense_position(catom, position); }
    // The cell in which a catom starts; until motion has started, which then drops them.
    Cell start_cell(Catom catom) const { return members_.start_cell(catom); }
    void forget_start_cells() { members_.forget_start_cells(); }

    // A node of a graph, of this process or another, is at another place, on all processes. The caller marks it.
    void move_node(graph::Node node, const world::Vec3& to);

    // ---- catoms that migrate
    // What another process needs of a catom (runtime/sim/core/migration.h): everything if it will own it, the exports if it will have a
    // ghost.
    void pack_catom(Catom catom, CatomState there, ByteWriter& out) const;
    // The bytes must have been packed for the state that the catom has here.
    void unpack_catom(Catom catom, ByteReader& in);

    // ---- notices from modules
    // Facts or links have changed in a tick that may still fail: then they are no longer those of the last tick.
    void note_change() { status_.note_change(); }
    // Something moves by itself, so the run continues although no program has anything to do.
    void set_moving(bool moving) { status_.moving = moving; }
    // An action of the last tick is not carried out; the count is part of the summary.
    void refuse(ActionKind action, Refusal why, std::uint64_t count = 1) { refusals_.add(action, why, count); }
    void request_stop() { status_.stop_requested = true; }
    // The run ends with the tick that has just been: all processes say so in it.
    void end_here() { status_.ends_here = true; }
    // Whoever stopped it wants it to go on.
    void take_back_stop() { status_.stop_requested = status_.totals.stop = false; }
    // The world has got an event of a later tick.
    void expect_event() { status_.totals.waiting = true; }
    void request_save(bool wanted) { status_.save_requested = wanted; }
    // Derivations of views that have no value are errors at once.
    void set_strict(bool strict) { abi_.strict = strict; }
    void set_diameters(std::function<double(Catom)> of) { diameter_of_ = std::move(of); }
    void set_rounded(std::function<world::RoundedBody(Catom)> of, bool some_rounded) {
        rounded_of_ = std::move(of);
        some_rounded_ = some_rounded;
    }
    void set_joints(std::function<std::vector<world::JointLook>()> all) { joints_ = std::move(all); }
    // Catoms at arbitrary positions are saved by their homes: places on the curve that orders bricks, which processes own as they own
    // bricks of a lattice.
    void set_homes(std::function<world::BrickKey(Catom)> of) { home_of_ = std::move(of); }
    void set_motion_bytes(std::size_t bytes) { motion_bytes_ = bytes; }

  private:
    bool hangs(std::uint64_t id) const;
    friend class CatomView;
    friend class Births;
    friend class Setup;
    friend class GivenFacts;
    friend class CatomFailures;
    friend class LinkFailures;
    friend class UnmatchedLinks;
    friend class Programs;
    friend class Exchange;
    friend class Tick;
    friend class ChangedChunks;
    friend class Saver;
    friend class Loader;
    friend class HandOver;

    SubdomainView abi_;                                    // As the compiled module sees it.
    std::function<double(Catom)> diameter_of_;             // Empty if all have the world's.
    std::function<world::RoundedBody(Catom)> rounded_of_;  // Empty if all are spheres, and nothing depends on how they are turned.
    bool some_rounded_ = false;
    std::function<std::vector<world::JointLook>()> joints_;  // Empty if there are none.
    std::function<world::BrickKey(Catom)> home_of_;          // Empty on a lattice.
    std::size_t motion_bytes_ = 0;                           // The memory of the motion module.
    TickLog* log_ = nullptr;
};

}  // namespace meld::sim
