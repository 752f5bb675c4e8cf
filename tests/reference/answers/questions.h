// Random questions about a run, and what the reference evaluator answers.
#pragma once

#include <optional>
#include <string>

#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/table.h"
#include "tests/reference/evaluator/model.h"
#include "tests/reference/programs/body.h"

namespace meld::reference {

// A body of one of the program's rules, or one that joins facts of any catoms by their values, without a link. Nothing: there is none.
std::optional<std::string> make_question(Random& random, const Draft& draft, const check::Program& program);

// The rows that answer the question of a program in this state; linear facts are read and stay.
Rows answer(const inspect::Program& asked, const Scene& scene, const Facts& facts, const std::vector<Bag>& linear);
Rows rows_of(const inspect::Table& table);

}  // namespace meld::reference
