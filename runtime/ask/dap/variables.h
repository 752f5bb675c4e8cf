// What a client can unfold: values that are made when somebody looks at them, by numbers that are good until the run moves.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "runtime/ask/dap/message.h"

namespace meld::dap {

struct Variable {
    std::string name = {}, value = {};
    std::string type = {};        // Shown when somebody points at it; may be empty.
    std::string expression = {};  // To be watched; empty: there is none.
    std::int64_t reference = 0;   // Of what is in it; 0: nothing.
    std::uint64_t count = 0;      // How many, if they are a long list.
    bool changeable = false;
};
using Variables = std::vector<Variable>;

class VariableTable {
  public:
    using Make = std::function<Result<Variables>()>;

    // A number that stands for what this makes.
    std::int64_t add(Make make) {
        makers_.push_back(std::move(make));
        return first_ + static_cast<std::int64_t>(makers_.size()) - 1;
    }
    // Numbers that were given so far mean nothing from now on.
    void clear() {
        first_ += static_cast<std::int64_t>(makers_.size());
        makers_.clear();
    }
    // Errors: the number means nothing (any more); those of what makes it.
    Result<Variables> list(std::int64_t reference) const;

  private:
    std::vector<Make> makers_;
    std::int64_t first_ = 1;
};

// The rows of an answer to `query`: each with its values, and below a long list the number of those that are left out.
Variables rows_of(const Json& answer, VariableTable& table);
// The answer in a line: yes, no, the one value that there is, or the number of rows.
std::string summary_of(const Json& answer);
// The facts of an answer to `facts`, by predicate.
Variables facts_by_predicate(const Json& answer, VariableTable& table);
// Where a catom is and what it touches.
Variables catom_variables(const Json& catom, VariableTable& table);

// As the protocol writes it.
Json to_json(const Variable& variable);
// Those from `start` on, at most `count`; 0: all.
Json to_json(const Variables& variables, std::uint64_t start, std::uint64_t count);

// "dist" of "dist(@4, 1).".
std::string predicate_of(const std::string& fact);

}  // namespace meld::dap
