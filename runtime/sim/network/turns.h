// Clocks that give turns: in a tick only some of the catoms that have work act, chosen by their priorities.
//
// `priority`: those that come before all their neighbours that have work, so neighbours never act in the same tick. `sequential`: the one
// that comes before all others. A catom comes before another if its priority is greater, then if it has waited longer, then if its number
// is smaller. The priorities are those of Linear Meld (Cruz, Rocha, Goldstein: "Declarative coordination of graph-based parallel
// programs", PPoPP 2016): rules change them with the actions of the performer Clock (runtime/module/abi/actions.def), which take effect
// at once, whether or not their catom has a turn.
//
// How long a catom waits has no bound. So nothing that a group has lost is trusted again after a number of ticks (docs/design.md, "Ranks
// and quarantine"), but when no catom has work: then each fact that holds is supported by others of lower rank, and none depends on what
// is gone.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/program_actions.h"
#include "runtime/sim/catoms/fact_store.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/world/description/network.h"

namespace meld::sim {

class Turns {
  public:
    // The latency by which quarantines go: longer than a run.
    static constexpr std::uint32_t kUntilRest = std::uint32_t{1} << 31;

    Turns(world::ClockKind kind, const Membership& members, FactStore& facts, comm::Communicator& comm)
        : kind_(kind), members_(members), facts_(facts), comm_(comm) {}

    // At the beginning of a tick, on every process: what the actions of the last tick say of priorities.
    void take(const tuple::ProgramActions& program, const std::vector<eval::Action>& actions);
    // In a tick, on every process, when all that has come is on the agenda: who acts. `silent`: a catom that hangs.
    // Cost: the agenda and its links; what catoms with ghosts as neighbours say of themselves goes to all processes.
    void choose(i64 now, const std::function<bool(Catom)>& silent);
    // Whether an owned catom acts in this tick.
    bool acts(Catom catom) const { return catom < acts_.size() && acts_[catom]; }

    // The number of a catom that has gone, or begins anew.
    void forget(std::uint64_t id) { known_.erase(id); }

    // Of one that migrates.
    void pack(std::uint64_t id, ByteWriter& out) const;
    void unpack(std::uint64_t id, ByteReader& in);
    // Of this process's catoms, for a snapshot; and back for those that `find` finds here.
    void save(ByteWriter& out) const;
    void load(const std::function<std::optional<u32>(u64)>& find, ByteReader& in);

  private:
    static constexpr double kLeast = -std::numeric_limits<double>::infinity();
    struct Node {
        double lasting = kLeast;  // The default priority.
        double now = kLeast;      // While `passing`, what counts instead, until it has acted and has no more work.
        bool passing = false;
        bool acted = false;  // In the last tick.
        bool works = false;  // Only while choose() looks.
        i64 since = kIdle;   // The tick from which on it has had work.
        double priority() const { return passing ? now : lasting; }
        bool plain() const { return lasting == kLeast && !passing && since == kIdle && !acted; }
    };
    static constexpr i64 kIdle = -1;
    // Of a catom that has work.
    struct Claim {
        double priority;
        i64 since;
        std::uint64_t id;
        // A total order.
        bool before(const Claim& other) const;
    };
    struct Change {
        std::uint64_t from, of;
        ActionKind kind;
        double value;
    };

    void apply(const Change& change);
    // The claims of this process's catoms, by their indices, ascending.
    std::vector<std::pair<Catom, Claim>> claims(i64 now, const std::function<bool(Catom)>& silent);
    void choose_among_neighbours(const std::vector<std::pair<Catom, Claim>>& mine);
    void choose_one(const std::vector<std::pair<Catom, Claim>>& mine);

    world::ClockKind kind_;
    const Membership& members_;
    FactStore& facts_;
    comm::Communicator& comm_;
    std::unordered_map<std::uint64_t, Node> known_;  // Those that are not plain.
    std::vector<bool> acts_;
    std::vector<Catom> acting_;  // Those that it names.
    std::vector<u32> claim_of_;  // By catom, only while choose_among_neighbours() looks.
};

}  // namespace meld::sim
