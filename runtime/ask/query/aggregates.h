// The aggregates of bodies over matches, by the classes of runtime/module/kernel/aggregates.h that modules use.
#pragma once

#include <memory>
#include <optional>

#include "compiler/check/program/program.h"
#include "runtime/ask/query/terms.h"

namespace meld::inspect {

class Accumulator {
  public:
    virtual ~Accumulator() = default;
    // Values stay in scratch memory until the result has been taken.
    virtual void add(Value value) = 0;
    // Nothing: an aggregate that has no value if nothing matches.
    virtual std::optional<Value> result() = 0;
    // What the value of one match is to be converted to.
    const check::Type& value_type() const { return value_type_; }

  protected:
    explicit Accumulator(check::Type value_type) : value_type_(std::move(value_type)) {}

  private:
    check::Type value_type_;
};

// For an aggregate of a body with this result.
std::unique_ptr<Accumulator> accumulator(const Program& program, Terms& terms, const check::Clause& clause, const check::Type& result,
                                         Values& variables);

}  // namespace meld::inspect
