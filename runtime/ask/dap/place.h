// Where the run stands, as a client sees it: a call stack, its scopes, and the values in them. It is made anew after each move.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/dap/derivation.h"
#include "runtime/ask/dap/rules.h"
#include "runtime/ask/dap/run.h"
#include "runtime/ask/dap/variables.h"

namespace meld::dap {

class Place {
  public:
    // Both outlive this. Frames without a rule are shown in the program's file, if it is one.
    Place(Run& run, const Rules& rules, std::string program) : run_(run), rules_(rules), program_(std::move(program)) {}

    // The catom whose facts are shown.
    std::uint64_t catom() const { return catom_; }
    void choose(std::uint64_t catom);

    // The run is about to move, so that the facts that come at the catom can be told from those that were there; and it has moved, with
    // this answer.
    void leave();
    void arrive(const Json& moved);
    std::int64_t tick() const { return tick_; }
    // The stack is that of this answer to `why`.
    void explain(const Json& why);

    // The answers to stackTrace, scopes and variables. Errors: there is no such frame or number; the run has ended.
    Result<Json> stack(std::size_t start, std::size_t levels);
    Result<Json> scopes(std::int64_t frame);
    Result<Variables> variables(std::int64_t reference) const { return table_.list(reference); }
    VariableTable& table() { return table_; }

    // The facts of the catom, all or those of a predicate, as the session answers.
    Result<Json> facts(const std::string& predicate = {});

  private:
    struct Frame {
        std::string name = {};
        const Rule* rule = nullptr;
        std::optional<std::size_t> node = {};  // Of the derivation.
        Variables bindings = {};
    };
    void forget();
    void build();
    void add_stop(const Json& stop);
    void add_derivation();
    std::string new_fact();
    Result<Variables> run_variables();
    Result<Variables> catom_scope();

    Run& run_;
    const Rules& rules_;
    std::string program_;
    std::uint64_t catom_ = 0;
    std::int64_t tick_ = 0, from_ = 0;
    Json stops_ = Json::array();
    Json before_ = nullptr;   // The catom's facts before the move.
    bool explained_ = false;  // Somebody has asked why.
    bool built_ = false;
    std::vector<Frame> frames_;
    std::optional<Derivation> derivation_;
    VariableTable table_;
};

}  // namespace meld::dap
