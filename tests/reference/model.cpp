#include "model.h"

#include <algorithm>
#include <map>

namespace meld::reference {

using check::Aggregate;
using check::Component;
using check::Predicate;
using check::Rule;

namespace {

// More rounds than the longest way through any world of a test.
constexpr int kMaxRounds = 600;
// Derivations of a round.
constexpr std::size_t kMaxDerivations = 1'000'000;

bool add_up(const std::vector<Row>& group, std::size_t at, Value& out) {
    out = group[0][at];
    for (std::size_t i = 1; i < group.size(); ++i) {
        if (out.is_real()) {
            out = value_of(out.real() + group[i][at].real());
        } else {
            std::int64_t sum = 0;
            if (__builtin_add_overflow(out.integer(), group[i][at].integer(), &sum)) return false;
            out = value_of(sum);
        }
    }
    return true;
}

// The best of a group: the value, then the choice of history, then the least of what rides along.
Row best(const Predicate& p, const std::vector<Row>& group, const Rows* chosen) {
    const std::size_t at = p.aggregate_at;
    std::vector<Row> equals;
    for (const Row& row : group) {
        const bool better = !equals.empty() && (p.aggregate == Aggregate::Min ? row[at] < equals[0][at] : p.aggregate == Aggregate::Max && row[at] > equals[0][at]);
        const bool equal = equals.empty() || p.aggregate == Aggregate::First || row[at] == equals[0][at];
        if (better) equals.clear();
        if (better || equal) equals.push_back(row);
    }
    if (chosen != nullptr)
        for (const Row& row : equals)
            if (chosen->contains(row)) return row;
    return *std::min_element(equals.begin(), equals.end());
}

}  // namespace

bool left_to_history(const Predicate& p, const Component& c) {
    const bool rides = p.aggregate_at + 1 < p.arguments.size();
    return p.aggregate == Aggregate::First || ((p.aggregate == Aggregate::Min || p.aggregate == Aggregate::Max) && rides && c.recursive);
}

bool reduce(const Predicate& p, const std::vector<Row>& derived, const Rows* chosen, Rows& out) {
    out.clear();
    if (p.aggregate == Aggregate::None) {
        out.insert(derived.begin(), derived.end());
        return true;
    }
    std::map<Row, std::vector<Row>> groups;
    for (const Row& row : derived) groups[Row(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(p.aggregate_at))].push_back(row);
    for (const auto& [key, group] : groups) {
        Row result = key;
        result.emplace_back();
        switch (p.aggregate) {
            case Aggregate::Sum:
                if (!add_up(group, p.aggregate_at, result.back())) return false;
                break;
            case Aggregate::Count: result.back() = value_of(static_cast<std::int64_t>(group.size())); break;
            case Aggregate::SetUnion:
            case Aggregate::Append:
            case Aggregate::Collect:
            case Aggregate::Custom: return false;
            default: result = best(p, group, chosen);
        }
        out.insert(std::move(result));
    }
    return true;
}

std::optional<Row> head_row(const Scene& scene, const check::Atom& head, const Environment& env) {
    const Predicate& p = scene.program->predicates[head.predicate];
    Row row;
    for (std::size_t i = 0; i < head.arguments.size(); ++i) {
        const bool counted = p.aggregate == Aggregate::Count && p.aggregate_at == i;
        const std::optional<Value> value = counted ? value_of(std::int64_t{1}) : evaluate(scene, head.arguments[i], env);
        if (!value || (value->is_real() && value->real() != value->real())) return std::nullopt;
        row.push_back(*value);
    }
    return row;
}

bool derive(const Rule& rule, const Sight& sight, std::int64_t home, const std::function<bool(Row, const Environment&)>& visit) {
    Solver solver(sight);
    Environment env(rule.variables.count());
    env[rule.home.index()] = value_of(home);
    bool failed = false;
    solver.solve(rule.body, env, [&] {
        std::optional<Row> row = head_row(sight.scene, rule.heads[0].atom, env);
        failed = failed || !row;
        return failed || !visit(std::move(*row), env);
    });
    return !failed && !solver.failed();
}

Model make_model(const Scene& scene, const Facts& given, const Facts& chosen) {
    const Program& program = *scene.program;
    Model m;
    m.facts.resize(program.predicates.count());
    for (const Component& c : program.components) {
        bool changing = true;
        for (int round = 0; changing; ++round) {
            if (round > kMaxRounds) {
                m.settled = false;
                return m;
            }
            std::map<PredicateId, std::vector<Row>> derived;
            std::size_t count = 0;
            // What does not count derivations keeps each fact once.
            std::map<PredicateId, Rows> seen;
            for (const PredicateId p : c.predicates) derived[p].assign(given[p.index()].begin(), given[p.index()].end());
            for (const check::RuleId id : c.rules) {
                const Rule& rule = program.rules[id];
                const PredicateId head = rule.heads[0].atom.predicate;
                const bool once = !check::folds(program.predicates[head].aggregate);
                for (const auto& [home, links] : scene.links) {
                    const bool done = derive(rule, {scene, m.facts}, home, [&](Row row, const Environment&) {
                        if (!once || seen[head].insert(row).second) derived[head].push_back(std::move(row));
                        return ++count <= kMaxDerivations;
                    });
                    m.too_large = count > kMaxDerivations;
                    m.failed = !done;
                    if (m.failed || m.too_large) return m;
                }
            }
            changing = false;
            for (const PredicateId p : c.predicates) {
                Rows rows;
                const Predicate& predicate = program.predicates[p];
                m.failed = !reduce(predicate, derived[p], left_to_history(predicate, c) ? &chosen[p.index()] : nullptr, rows) || m.failed;
                changing = changing || rows != m.facts[p.index()];
                m.facts[p.index()] = std::move(rows);
            }
            changing = changing && c.recursive;
        }
    }
    return m;
}

}  // namespace meld::reference
