// Motion on a lattice: create, destroy, give, moveTo, slide, turn, moveAround and move as proposals, arbitrated so that the outcome depends
// neither on processes nor on threads (docs/motion.md, "Conflicts"). Amoebots expand, contract, push and pull in the same way.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "runtime/module/abi/actions.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/migration.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/lattice/activation.h"
#include "runtime/sim/lattice/possible_moves.h"

namespace meld::sim {

class LatticeMotion : public SimModule, public SaysWhatChanges {
  public:
    explicit LatticeMotion(const world::World& world);
    Result<void> start(Subdomain& subdomain) override;
    Result<void> step(Subdomain& subdomain) override;
    Result<void> lose(Subdomain& subdomain, std::span<const Killed> killed) override;
    void restarted(Subdomain& subdomain, std::span<const Catom> catoms) override;
    void struck(Subdomain& subdomain) override;
    Result<void> resume(Subdomain& subdomain) override;
    Result<void> saveable() const override { return {}; }
    // Amoebots have turns.
    bool touches_what_it_keeps() const override { return !world_.has_amoebots(); }
    // Amoebots are activated in every tick.
    bool leaves_facts_alone(const Subdomain& subdomain) const override { return !subdomain.world.has_amoebots(); }
    bool divides_anew() const override { return true; }
    void leave(Subdomain& subdomain, std::span<const Catom> catoms) override;
    // The units that catoms hold; in which tick anything moved last.
    void save_catoms(const Subdomain& subdomain, std::span<const Catom> catoms, ByteWriter& out) const override;
    void load_catoms(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in) override;
    void save_rest(const Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(Subdomain& subdomain, ByteReader& in) override;
    Result<void> resumed(Subdomain& subdomain) override;
    void finish(Subdomain& subdomain) override;
    std::string status() const override;
    std::string outcome() const override;

    // A proposal of one catom. Everything it would affect is a claim on a cell; it is granted if it is the smallest by (kind, id,
    // direction) on each of them; kinds have the order of the table runtime/module/abi/actions.def. With keep_connected it also rests on
    // the catoms that keep the ensemble together: none of them may leave its cell in that tick, and others may rest on them too.
    struct Proposal {
        ActionKind kind = ActionKind::Create;
        std::uint32_t first_claim = 0, claim_count = 0;  // In Proposals::claims.
        std::uint32_t first_rest = 0, rest_count = 0;    // In Proposals::rests.
        std::int32_t direction = 0;
        std::uint64_t id = 0;     // The id of the mover.
        Catom mover = 0;          // Its index on its own process.
        Catom receiver = 0;       // The same of the catom that receives units.
        Cell from = {}, to = {};  // Its cell; the cell of the new position, of the new catom, or of the receiver.
        // The cell that is empty afterwards, if it leaves one. Of amoebots: where its tail will be; the head of whom it pushes or pulls.
        Cell left = {}, tail = {}, partner = {};
        auto order() const { return std::tuple(kind, id, direction); }
    };
    // A claim is on an empty cell, or on the catom in a cell: it acts, stands still, receives, or is removed. Keys of cells have 63 bits.
    static constexpr CellKey kBody = CellKey{1} << 63;
    struct Proposals {
        std::vector<Proposal> list;
        std::vector<CellKey> claims, rests;
        std::span<const CellKey> rests_of(const Proposal& p) const { return std::span(rests).subspan(p.first_rest, p.rest_count); }
    };
    // What became of each moveTo on several processes, before conflicts are decided.
    struct Teleports {
        using Request = std::pair<std::uint64_t, std::int32_t>;  // The mover's id, and the number of the moveTo among its own.
        std::set<Request> vetoed;
        std::map<std::uint64_t, std::int32_t> kept;  // Of each mover the first to an empty cell.
        // Why a proposal that was not granted was not.
        Refusal why_not(const Proposal& p) const;
    };

  private:
    struct Known {  // Predicates of the program, or none.
        std::optional<u32> holds, failed, created;
    };
    // The effect of the granted proposals on a cell, sent to every process that knows it. What a catom of this process or a ghost gets or
    // gives is in units_passed_ here, since that is most.
    struct Change {
        // Applied in this order: what amoebots give up is empty before others take it.
        enum class Kind : std::uint8_t { Remove, Move, Shrink, Grow, Add, Hold } kind = Kind::Remove;
        bool newborn = false;   // Add
        std::int32_t held = 0;  // Add: its units at first; Hold: the change.
        Cell cell = {};         // Move, Shrink, Grow: the old cell.
        Cell to = {};           // Move, Shrink, Grow: the new cell; Move only for the process that owns both.
        Cell tail = {};         // Shrink, Grow, Add: of an amoebot.
        std::uint8_t turn = 0;  // Add: of an amoebot, Activation::turn().
        Migrant who = {};       // Add
        // Shrink, Grow within one process: who it is; none if whoever is in the cell has to be looked up.
        std::optional<Catom> catom = {};
    };

    struct Passed {
        Catom catom = 0;
        std::int32_t units = 0;
    };

    // proposals.cpp
    Proposals collect(Subdomain& subdomain);
    // Each returns why it cannot be proposed.
    using Objection = std::optional<Refusal>;
    Objection propose(Subdomain& subdomain, const eval::Action& action, Proposal& out, std::vector<CellKey>& claims) const;
    Objection propose_give(const Subdomain& subdomain, const eval::Action& action, Proposal& out, std::vector<CellKey>& claims) const;
    Objection propose_move(Subdomain& subdomain, const eval::Action& action, Proposal& out, std::vector<CellKey>& claims) const;
    Objection propose_around(Subdomain& subdomain, const eval::Action& action, Proposal& out, std::vector<CellKey>& claims) const;
    bool full(const Subdomain& subdomain, Cell cell) const { return subdomain.ensemble.at(cell).has_value(); }
    Objection may_leave(const Subdomain& subdomain, Proposal& p, std::vector<CellKey>& rests) const;
    // table_motion.cpp: by the moves of the world.
    Objection propose_by_table(const Subdomain& subdomain, const eval::Action& action, Proposal& out, std::vector<CellKey>& claims) const;
    Objection claim_by_table(const Subdomain& subdomain, Proposal& out, std::vector<CellKey>& claims) const;
    // amoebot_motion.cpp: the proposals of amoebots, and what comes of them.
    Objection propose_amoebot(const Subdomain& subdomain, const eval::Action& action, Proposal& out, std::vector<CellKey>& claims) const;
    Objection propose_handover(const Subdomain& subdomain, Cell cell, Cell given, Proposal& out, std::vector<CellKey>& claims) const;
    void grant_amoebot(Subdomain& subdomain, const Proposal& p);
    void reshape(Subdomain& subdomain, Catom catom, Cell head, Cell tail);
    // Amoebots of other processes that ours push or pull are reshaped by their owners.
    void exchange_partners(Subdomain& subdomain);
    void save_tails(const Subdomain& subdomain, std::span<const Catom> catoms, ByteWriter& out) const;
    void load_tails(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in);
    std::string outcome_of_amoebots() const;

    Proposals share(Subdomain& subdomain, const Proposals& mine, Teleports& teleports) const;
    static std::vector<bool> decide(const Subdomain& subdomain, const Proposals& mine, const Proposals& all);

    Teleports veto_teleports(Subdomain& subdomain, std::vector<Proposal>& all) const;

    // lattice_motion.cpp
    void act(Subdomain& subdomain);
    void refuse(Subdomain& subdomain, Catom catom, ActionKind kind, Refusal why);
    void grant(Subdomain& subdomain, const std::vector<Proposal>& granted);
    std::vector<CellKey> number_creations(Subdomain& subdomain, const std::vector<Proposal>& granted) const;
    void relocate(Subdomain& subdomain, const Proposal& p);
    void announce(Subdomain& subdomain, const Change& change);
    void pass_units(Subdomain& subdomain, Catom catom, Cell cell, std::int32_t units);
    // Queues a change for a process, which may be this one, `me`.
    void tell(int process, int me, const Change& change);
    // A change on its way to another process.
    static void write(ByteWriter& out, const Change& change);
    static Change read(ByteReader& in);
    std::vector<Change> exchange(Subdomain& subdomain);
    void apply(Subdomain& subdomain, std::vector<Change> changes);
    void apply_add(Subdomain& subdomain, const Change& change);
    void apply_units(Subdomain& subdomain);
    void hold(Subdomain& subdomain, Catom catom, std::int32_t units);
    std::map<world::BrickKey, std::uint32_t> target_nearby(const Subdomain& subdomain) const;
    // Adds a catom of ours to the counts below, or subtracts it.
    void account(const Subdomain& subdomain, Catom catom, int sign);

    struct Partner {
        Cell at, head, tail;  // Where its head is, and where head and tail will be.
    };
    struct Moves {
        std::uint64_t expansions = 0, contractions = 0, handovers = 0;
    };

    const world::World& world_;
    // Whose actions are carried out.
    const ActionInfo::Performer here_;
    Activation activation_;                       // Of amoebots.
    Moves moves_;                                 // Of amoebots of this process; after finish(), of all.
    std::vector<ByteWriter> partners_elsewhere_;  // By process.
    const world::Lattice lattice_;                // With its own numbers of ports, which decide between equal ways and requests.
    Known known_;
    PossibleMoves possible_;
    std::vector<std::int32_t> held_;                                  // By catom, ghosts too.
    std::vector<ByteWriter> packets_;                                 // By destination.
    std::vector<Change> mine_;                                        // Changes for this process.
    std::vector<Passed> units_passed_;                                // Of this tick, on this process.
    std::vector<std::int32_t> units_due_;                             // By catom: the sum of those; 0 between ticks.
    std::int64_t outside_ = 0, units_ = 0;                            // Of this process: catoms outside the target, units held.
    std::int64_t all_outside_ = 0, all_units_ = 0, all_missing_ = 0;  // Of all processes, at the end.
    std::int64_t last_change_ = 0;                                    // The tick in which anything moved last.
};

}  // namespace meld::sim
