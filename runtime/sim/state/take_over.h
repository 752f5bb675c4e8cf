// Takes the facts of a snapshot over into a run of another program, or of the same with other constants. Facts that were given, sensed or
// made by linear rules are taken over where the predicate is declared as it was; what rules derive is derived anew, from the first tick on.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/schema.h"
#include "runtime/sim/catoms/fact_store.h"

namespace meld::sim {

// What became of the facts, by the names of predicates: numbers of facts on all processes.
struct TakenOver {
    std::map<std::string, std::uint64_t> taken_over, dropped;
    std::vector<std::string> derived_anew;
};

class TakeOver {
  public:
    TakeOver(tuple::Schema was, const ModuleInfo& now, FactStore& facts);

    // As FactStore::load() and load_passing() read them. Only catoms that are owned here get facts.
    void load(std::span<const tuple::SavedCatom> catoms, ByteReader& in);
    void load_passing(const std::function<std::optional<u32>(u64)>& find, ByteReader& in);
    // The same on all processes, each of which calls it at the end. Errors: there are facts of a predicate that is declared otherwise now.
    Result<TakenOver> outcome(comm::Communicator& comm) const;

  private:
    // A predicate of the old program that holds facts, and where they go.
    struct Way {
        u32 from = 0;
        std::optional<u32> to = {};
        bool done = false;         // An action: what holds has been carried out.
        std::string name = {};     // As people know it.
        std::string changed = {};  // How it is declared now, if that is not as it was.
        std::uint64_t facts = 0;   // On this process.
    };
    void find_ways();
    Way way_of_given(u32 from) const;
    Way way_of_action(u32 from) const;
    std::optional<u32> same_action(u32 from) const;
    std::optional<u32> find(const PredicateInfo& p) const;
    const PredicateInfo* other_arity(const PredicateInfo& p) const;

    tuple::Schema was_;
    const ModuleInfo& now_;
    FactStore& facts_;
    std::vector<Way> ways_;
    std::vector<std::optional<u32>> actions_;    // What those that are on their way are now, by predicate.
    std::map<u32, std::uint64_t> lost_actions_;  // Those on their way that the program does not know, by predicate.
};

}  // namespace meld::sim
