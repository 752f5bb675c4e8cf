// Computes terms of a checked program as its module does, by the same functions of the kernel.
#pragma once

#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/ask/facts/program.h"
#include "runtime/ask/facts/types.h"
#include "runtime/ask/query/scratch_memory.h"

namespace meld::inspect {

// Values of variables, by their ids.
using Values = std::vector<Value>;

class Terms {
  public:
    // All outlive it. The view is that of the run.
    Terms(const Program& program, const SubdomainView& view) : scratch(view), program_(program), view_(view) {}

    // Values live in scratch memory, in static memory or in the facts they come from. Where one has no value, Scratch::trap is set, as
    // Scratch::went_well() tells.
    Value value(const check::Term& term, Values& variables);
    // As a value of this type: an int may stand for a float.
    Value value_as(const check::Term& term, const check::Type& type, Values& variables);
    // The same as an element of a list or the value of a variable: a float is a number, and zero has one sign.
    Value element(const check::Term& term, const check::Type& type, Values& variables);
    Value call(check::FunctionId function, std::vector<Value> arguments);
    static Value converted(Value v, const check::Type& from, const check::Type& to) {
        return from.kind == check::Type::Kind::Int && to.kind == check::Type::Kind::Float ? Value{.real = static_cast<double>(v.integer)}
                                                                                          : v;
    }

    // By content.
    bool equal(const check::Type& type, Value a, Value b);

    Scratch scratch;
    Types types;

  private:
    // One function a family of operators (compiler/check/program/op_info.h).
    Value leaf(const check::Term& term, Values& variables);
    Value compound(const check::Term& term, Values& variables);
    Value control(const check::Term& term, Values& variables);
    Value call(const check::Term& term, Values& variables);
    Value asked_of_run(const check::Term& term, Values& variables);
    Value number(const check::Term& term, Values& variables);
    Value constant(const check::Term& term);
    Value arithmetic(const check::Term& term, Values& variables);
    bool comparison(const check::Term& term, Values& variables);
    Value make(const check::Term& term, Values& variables);
    Value library(const check::Term& term, Values& variables);
    Value run(check::FunctionId function, Values& frame);

    const Program& program_;
    const SubdomainView& view_;
    u64 calls_ = 0;  // Since the outermost call began.
};

}  // namespace meld::inspect
