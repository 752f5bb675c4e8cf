// Computes terms before the program runs: the values of constants.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "compiler/check/program/arithmetic.h"
#include "compiler/check/program/program.h"

namespace meld::check {

class Folder {
  public:
    // `constant` returns the value of another constant, or none if it has none before the run.
    Folder(const Program& program, std::function<std::optional<Term>(ConstantId)> constant)
        : program_(program), constant_(std::move(constant)) {}

    // The term as literals; none if only the run can compute it, or if computing fails.
    std::optional<Term> fold(const Term& term);
    // The error and its place; empty if there was none.
    const std::string& wrong() const { return wrong_; }
    Span wrong_at() const { return wrong_at_; }

  private:
    std::optional<Term> value(const Term& t);
    std::optional<Term> call(const Term& t);
    std::optional<Term> arithmetic(const Term& t, const Term& a, const Term& b);
    std::optional<Term> whole(const Term& t, const Computed<std::int64_t>& result);
    std::optional<Term> real(const Term& t, const Computed<double>& result);
    std::optional<Term> compound(const Term& t);
    std::nullopt_t fails(const Term& t, const std::string& why);

    const Program& program_;
    std::function<std::optional<Term>(ConstantId)> constant_;
    std::map<VariableId, Term> variables_;
    std::size_t steps_ = 0;
    std::size_t depth_ = 0;
    std::string wrong_;
    Span wrong_at_ = {};
};

}  // namespace meld::check
