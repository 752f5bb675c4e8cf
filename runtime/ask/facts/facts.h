// The facts of a run in one state, between two ticks, as questions need them: those of a predicate at a catom, or all of it.
#pragma once

#include <functional>
#include <optional>

#include "runtime/ask/facts/program.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

struct Fact {
    u64 catom = 0;                     // Its number.
    const Value* arguments = nullptr;  // After the catom. Lists among them are valid as long as the visit, others' as long as the facts.
    u32 rank = kAbsent;                // Where the predicate has ranks.
};

// False: enough has been seen. Not copied: std::ref() keeps it cheap.
using Visit = std::function<bool(const Fact&)>;

class Facts {
  public:
    virtual ~Facts() = default;

    // The facts at a catom, in the order in which its rules read them. False if the visit has said so.
    virtual bool at(const Source& source, u64 catom, const Visit& visit) = 0;
    // The facts at a catom as a neighbour has read them in the last evaluation: what had come to it over their link.
    virtual bool heard(const Source& source, u64 catom, [[maybe_unused]] u64 by, const Visit& visit) { return at(source, catom, visit); }
    // All facts, by the numbers of their catoms, and at each as above.
    virtual bool each(const Source& source, const Visit& visit) = 0;
    // Whether each() visits all of them now, so that what is made of them may be kept.
    virtual bool has_all(const Source&) const { return true; }
    // Those of `neighbor` whose second argument is this catom: links followed from their end.
    virtual bool back(const Source& source, u64 to, const Visit& visit) = 0;
    // Whether there is such a catom.
    virtual bool exists(u64 catom) = 0;
    // What a group of a predicate with ranks has lost, if that may still delay a value; groups are named by a hash, as modules make it.
    virtual std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) = 0;
};

}  // namespace meld::inspect
