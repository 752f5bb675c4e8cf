// The order in which a body is satisfied: a list of steps, each of which has only a few ways to go on from what the steps before have
// bound. Chosen once for each body, by which variables are bound when it begins.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/ask/facts/program.h"

namespace meld::inspect {

using Bound = std::vector<bool>;  // By variable.

// What an argument of a fact does.
struct Argument {
    enum class Use {
        Skip,     // Anything will do.
        Bind,     // Its variable gets the value.
        Compare,  // It must be the value of this term, which is known.
    } use = Use::Skip;
    const check::Term* term = nullptr;
    check::Type type;
};

struct Step {
    enum class Kind {
        // Facts: at the catom that is known; of all catoms; at the catoms that a link joins to one that is known; those that agree with
        // what is known, by an index.
        Here,
        Each,
        Back,
        Indexed,
        Test,
        Bind,       // A variable gets the value of a term.
        TakeApart,  // The parts of a value that is known; some of them may be known too.
        Element,
        Not,
        Aggregate,
    } kind = Kind::Test;
    const check::Clause* clause = nullptr;
    std::size_t number = 0;  // Of the clause in its body.
    Source source = {};
    std::vector<Argument> arguments = {};  // The catom first. TakeApart: the parts.
    std::vector<std::size_t> key = {};     // Indexed: the arguments that are known.
    // Bind: what gets which value; TakeApart: the whole. Element and Aggregate: whether their variable is known already.
    check::VariableId variable = {};
    const check::Term* term = nullptr;
    bool known = false;
    std::vector<Step> inner = {};
    std::vector<std::shared_ptr<const check::Term>> keep = {};  // Terms that are in no body.
};

// `bound` says which variables have a value before the first step, and after the last one; it grows by those that the steps need for
// themselves. `once`: the steps are taken once, so an index for the first of them would not pay.
//
// The body itself is satisfied in whichever order: a way of which something has no value is none. A part of it has no value if anything
// that it comes to has none (docs/design.md, "Undefined derivations"), so it follows the order in which rules look at facts: conditions as
// soon as they can be tested, facts in the order of the text as soon as their catom is known, then aggregates, then what must not hold.
std::vector<Step> order(const Program& program, const check::Rule& rule, const std::vector<check::Clause>& body, Bound& bound,
                        bool once = true);

}  // namespace meld::inspect
