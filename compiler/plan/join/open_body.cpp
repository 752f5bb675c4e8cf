#include "compiler/plan/join/open_body.h"

#include <algorithm>

#include "runtime/base/assert.h"

namespace meld::plan {

using namespace check;

namespace {

// The variables by which a clause is tied to negations and aggregates beside it: of these themselves, only their results.
template <class Visit>
void each_shared_variable(const Clause& clause, const Visit& visit) {
    if (clause.kind == Clause::Kind::Aggregate)
        visit(clause.variable);
    else if (clause.kind != Clause::Kind::Not)
        each_variable(clause, visit);
}

void add_once(std::vector<PredicateId>& names, PredicateId name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
}

}  // namespace

OpenBody::OpenBody(std::vector<Clause> body, const AccessPlanner& accesses, Reading reading, const Known& known, const Variables& outside)
    : accesses_(accesses),
      reading_(reading),
      outside_(outside),
      clauses_(std::move(body)),
      closed_(clauses_.size()),
      costs_(clauses_.size()),
      left_(clauses_.size()) {
    for (std::size_t i = 0; i < clauses_.size(); ++i) {
        each_variable(clauses_[i], [&](VariableId v) {
            std::vector<std::size_t>& users = variables_[v].users;
            if (users.empty() || users.back() != i) users.push_back(i);
        });
        each_shared_variable(clauses_[i], [&](VariableId v) { ++variables_[v].sharers; });
        look_again(i, known);
    }
    for (auto& [id, variable] : variables_) {
        variable.value = known.values.contains(id);
        variable.place = known.places.contains(id);
    }
}

void OpenBody::look_again(std::size_t i, const Known& known) {
    if (closed_[i]) return;
    if (!AccessPlanner::reads(clauses_[i])) {
        may_be_ready_.insert(i);
        return;
    }
    if (costs_[i]) readable_.erase({*costs_[i], i});
    const std::optional<Access> access = accesses_.access(clauses_[i], known);
    costs_[i] = access ? std::optional(reading_ == Reading::Cheapest ? access->cost : 0) : std::nullopt;
    if (costs_[i]) readable_.insert({*costs_[i], i});
}

std::optional<std::size_t> OpenBody::next_without_read() {
    if (may_be_ready_.empty()) return std::nullopt;
    return may_be_ready_.extract(may_be_ready_.begin()).value();
}

std::optional<std::size_t> OpenBody::next_read() const {
    if (readable_.empty()) return std::nullopt;
    return readable_.begin()->second;
}

Choice OpenBody::choice(std::size_t next, const Known& known) const {
    const std::optional<Access> access = accesses_.access(clauses_[next], known);
    MELD_EXPECT(access.has_value(), "clause {} cannot be read yet", next);
    Choice out{.reason = reading_ == Reading::AsWritten ? Reason::Written : access->reason, .known = access->known};
    for (std::size_t i = first_left_; i < next; ++i) {
        if (closed_[i] || !AccessPlanner::reads(clauses_[i])) continue;
        const bool is_element = clauses_[i].kind == Clause::Kind::Element;
        add_once(costs_[i] ? out.dearer : out.waiting, is_element ? PredicateId() : clauses_[i].atom.predicate);
    }
    return out;
}

Variables OpenBody::shared_by(const Clause& clause) const {
    Variables out;
    each_variable(clause, [&](VariableId v) {
        if (outside_.contains(v) || variables_.at(v).sharers > 0) out.insert(v);
    });
    return out;
}

void OpenBody::close(std::size_t i, const Known& known) {
    MELD_EXPECT(!closed_[i], "clause {} is closed", i);
    closed_[i] = true;
    --left_;
    while (first_left_ < closed_.size() && closed_[first_left_]) ++first_left_;
    may_be_ready_.erase(i);
    if (costs_[i]) readable_.erase({*costs_[i], i});
    std::set<std::size_t> again;
    each_shared_variable(clauses_[i], [&](VariableId v) {
        Variable& variable = variables_.at(v);
        if (--variable.sharers == 0) again.insert(variable.users.begin(), variable.users.end());
    });
    each_variable(clauses_[i], [&](VariableId v) {
        Variable& variable = variables_.at(v);
        const bool value = known.values.contains(v), place = known.places.contains(v);
        if (value == variable.value && place == variable.place) return;
        variable.value = value;
        variable.place = place;
        again.insert(variable.users.begin(), variable.users.end());
    });
    for (const std::size_t other : again) look_again(other, known);
}

std::vector<Clause> OpenBody::rest() && {
    std::vector<Clause> out;
    for (std::size_t i = 0; i < clauses_.size(); ++i)
        if (!closed_[i]) out.push_back(std::move(clauses_[i]));
    return out;
}

}  // namespace meld::plan
