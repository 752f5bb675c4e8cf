#include "tests/reference/evaluator/model.h"

#include <algorithm>
#include <map>

namespace meld::reference {

using check::Aggregate;
using check::Predicate;
using check::Rule;
using check::Stratum;

namespace {

// More rounds than the longest way through any world of a test.
constexpr int kMaxRounds = 600;
// Derivations of a round.
constexpr std::size_t kMaxDerivations = 1'000'000;

bool add_up(const std::vector<Row>& group, std::size_t at, Value& out) {
    out = group[0][at];
    for (std::size_t i = 1; i < group.size(); ++i) {
        const std::optional<Value> sum = added(out, group[i][at]);
        if (!sum) return false;
        out = *sum;
    }
    return is_finite(out);
}

// All values in order, one behind the other.
Value appended(const std::vector<Row>& group, std::size_t at) {
    Value out = group[0][at];
    for (std::size_t i = 1; i < group.size(); ++i) {
        const Value& next = group[i][at];
        if (out.is_text()) {
            out = {out.text() + next.text()};
            continue;
        }
        Values all = out.items();
        all.insert(all.end(), next.items().begin(), next.items().end());
        out = value_of(std::move(all));
    }
    return out;
}
Value united(const std::vector<Row>& group, std::size_t at) {
    Values all = appended(group, at).items();
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return value_of(std::move(all));
}
bool folded(const Scene& scene, const Predicate& p, const std::vector<Row>& group, Value& out) {
    out = group[0][p.aggregate_at];
    for (std::size_t i = 1; i < group.size(); ++i) {
        const std::optional<Value> next = call(scene, p.fold, {out, group[i][p.aggregate_at]});
        if (!next) return false;
        out = *next;
    }
    return true;
}

// The neighbours whose contributions a group at this catom must have.
std::set<std::int64_t> waited_for(const Scene& scene, const Facts& facts, const Predicate& p, std::int64_t site) {
    std::set<std::int64_t> out;
    if (!p.complete_link.valid()) return out;
    const bool touching = scene.program->predicates[p.complete_link].world != check::WorldSource::None;
    for (const Link& link : scene.links.at(site)) {
        const auto [from, to] = p.complete_outgoing ? std::pair(site, link.other) : std::pair(link.other, site);
        const Rows& routes = facts[p.complete_link.index()];
        const auto first = routes.lower_bound(Row{value_of(from), value_of(to)});
        if (touching || (first != routes.end() && (*first)[0].integer() == from && (*first)[1].integer() == to)) out.insert(link.other);
    }
    return out;
}

// The best of a group: the value, then the choice of history, then the least payload.
Row best(const Predicate& p, const std::vector<Row>& group, const Rows* chosen) {
    const std::size_t at = p.aggregate_at;
    std::vector<Row> equals;
    for (const Row& row : group) {
        const bool better = !equals.empty() &&
                            (keeps_least(p.aggregate) ? row[at] < equals[0][at] : keeps_greatest(p.aggregate) && row[at] > equals[0][at]);
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

bool left_to_history(const Predicate& p, const Stratum& c) {
    const bool payload = p.aggregate_at + 1 < p.arguments.size();
    return p.aggregate == Aggregate::First || (keeps_best(p.aggregate) && payload && c.recursive);
}

bool reduce(const Scene& scene, const Facts& facts, const Predicate& p, const std::vector<Derived>& derived, const Rows* chosen,
            Rows& out) {
    out.clear();
    bool all_defined = true;
    if (p.aggregate == Aggregate::None) {
        for (const Derived& d : derived) out.insert(d.row);
        return true;
    }
    std::map<Row, std::vector<Row>> groups;
    std::map<Row, std::set<std::int64_t>> heard;
    for (const Derived& d : derived) {
        const Row key(d.row.begin(), d.row.begin() + static_cast<std::ptrdiff_t>(p.aggregate_at));
        groups[key].push_back(d.row);
        heard[key].insert(d.from.begin(), d.from.end());
    }
    for (auto& [key, group] : groups) {
        if (p.complete_link.valid()) {
            const std::set<std::int64_t> needed = waited_for(scene, facts, p, key[0].integer());
            if (!std::includes(heard[key].begin(), heard[key].end(), needed.begin(), needed.end())) continue;
        }
        if (p.aggregate == Aggregate::Append || p.aggregate == Aggregate::Custom) std::sort(group.begin(), group.end());
        Row result = key;
        result.emplace_back();
        switch (p.aggregate) {
            case Aggregate::Sum:
                if (!add_up(group, p.aggregate_at, result.back())) {
                    all_defined = false;
                    continue;
                }
                break;
            case Aggregate::Count:
                result.back() = value_of(static_cast<std::int64_t>(group.size()));
                break;
            case Aggregate::SetUnion:
                result.back() = united(group, p.aggregate_at);
                break;
            case Aggregate::Append:
                result.back() = appended(group, p.aggregate_at);
                break;
            case Aggregate::Custom:
                if (!folded(scene, p, group, result.back())) {
                    all_defined = false;
                    continue;
                }
                break;
            case Aggregate::Avg: {
                Values values;
                for (const Row& row : group) values.push_back(row[p.aggregate_at]);
                result.back() = value_of(mean(values));
                break;
            }
            case Aggregate::MinK:
            case Aggregate::MaxK: {
                const std::optional<Value> limit = evaluate(scene, p.parameter, {});
                if (!limit) {
                    all_defined = false;
                    continue;
                }
                result.back() =
                    value_of(best_of(appended(group, p.aggregate_at).items(), limit->integer(), p.aggregate == Aggregate::MinK));
                break;
            }
            case Aggregate::Collect:
                return false;
            default:
                result = best(p, group, chosen);
        }
        out.insert(std::move(result));
    }
    return all_defined;
}

std::optional<Row> head_row(const Scene& scene, const check::Atom& head, const Environment& env) {
    const Predicate& p = scene.program->predicates[head.predicate];
    Row row;
    for (std::size_t i = 0; i < head.arguments.size(); ++i) {
        const bool counted = p.aggregate == Aggregate::Count && p.aggregate_at == i;
        const std::optional<Value> value = counted ? value_of(std::int64_t{1}) : evaluate(scene, head.arguments[i], env);
        if (!value || !is_finite(*value)) return std::nullopt;
        row.push_back(*value);
    }
    return row;
}

bool derive(const Rule& rule, const Sight& sight, std::int64_t site, const std::function<bool(Derived, const Environment&)>& visit) {
    Solver solver(sight);
    Environment env(rule.variables.count());
    env[rule.site.index()] = value_of(site);
    bool failed = false;
    solver.solve(rule.body, env, [&] {
        std::optional<Row> row = head_row(sight.scene, rule.heads[0].atom, env);
        failed = failed || !row;
        if (!row) return false;
        Derived made{.row = std::move(*row)};
        for (const check::VariableId v : rule.contributors) made.from.insert(env[v.index()]->integer());
        return !visit(std::move(made), env);
    });
    return !failed && !solver.failed();
}

Model make_model(const Scene& scene, const Facts& given, const Facts& chosen) {
    const Program& program = *scene.program;
    Model m;
    m.facts.resize(program.predicates.count());
    for (const Stratum& c : program.strata) {
        bool changing = true, failed = false;
        for (int round = 0; changing; ++round) {
            if (round > kMaxRounds) {
                m.settled = false;
                return m;
            }
            failed = false;
            std::map<PredicateId, std::vector<Derived>> derived;
            std::size_t count = 0;
            // What does not count derivations keeps each fact once.
            std::map<PredicateId, Rows> seen;
            for (const PredicateId p : c.predicates)
                for (const Row& row : given[p.index()]) derived[p].push_back({row});
            for (const check::RuleId id : c.rules) {
                const Rule& rule = program.rules[id];
                const PredicateId head = rule.heads[0].atom.predicate;
                const bool once = !program.predicates[head].needs_all();
                for (const auto& [site, links] : scene.links) {
                    const bool done = derive(rule, {scene, m.facts}, site, [&](Derived made, const Environment&) {
                        if (!once || seen[head].insert(made.row).second) derived[head].push_back(std::move(made));
                        return ++count <= kMaxDerivations;
                    });
                    m.too_large = count > kMaxDerivations;
                    failed = failed || !done;
                    if (m.too_large) return m;
                }
            }
            changing = false;
            for (const PredicateId p : c.predicates) {
                Rows rows;
                const Predicate& predicate = program.predicates[p];
                failed =
                    !reduce(scene, m.facts, predicate, derived[p], left_to_history(predicate, c) ? &chosen[p.index()] : nullptr, rows) ||
                    failed;
                changing = changing || rows != m.facts[p.index()];
                m.facts[p.index()] = std::move(rows);
            }
            changing = changing && c.recursive;
        }
        m.failed = m.failed || failed;
    }
    return m;
}

}  // namespace meld::reference
