#include "tests/reference/evaluator/ticks.h"

#include <algorithm>
#include <set>
#include <utility>

#include "tests/reference/evaluator/apart.h"
#include "tests/reference/evaluator/solver.h"

namespace meld::reference {

using check::Clause;
using check::Predicate;
using check::Rule;
using check::Stratum;
using check::VariableId;
using check::WorldSource;

namespace {

constexpr int kMaxFirings = 3000;

bool finds_facts(const Clause& c) { return c.kind == Clause::Kind::Atom || c.kind == Clause::Kind::Delta; }

// What tells one way to satisfy a body from the others: the facts that it has found, and the places of elements in lists. What is
// computed of them is no part of it.
void add_found(const Scene& scene, const std::vector<Clause>& body, const Environment& env, Row& out) {
    for (const Clause& c : body) {
        if (c.kind == Clause::Kind::Element) out.push_back(*env[c.position.index()]);
        if (!finds_facts(c)) continue;
        for (const check::Term& t : c.atom.arguments) out.push_back(*evaluate(scene, t, env));
    }
}

// It is a number that the compiler knows, or depends on how long a tick is.
std::int64_t evaluate_delay(const Scene& scene, const check::Term& delay) { return evaluate(scene, delay, {})->integer(); }

}  // namespace

Ticks::Ticks(const Program& program, std::uint64_t seed) : program_(program), seed_(seed), certain_(program.predicates.count(), true) {
    find_certain();
    tell_apart();
    for (const PredicateId p : program.predicates.ids())
        if (program.predicates[p].returns.valid()) returned_[program.predicates[p].returns] = p;
}

Ticks::Catom Ticks::empty() const {
    const std::size_t n = program_.predicates.count();
    return {.given = Facts(n), .views = Facts(n), .before = Facts(n), .linear = std::vector<Bag>(n)};
}

// ---- which views are certain

// Some atom is neither at the execution site nor at a catom that a link of the body joins to it directly; or it is a world fact of a
// neighbour, which travels like any other.
bool Ticks::looks_far(const Rule& rule) const {
    std::set<VariableId> near{rule.site};
    check::each_atom(rule.body, [&](const check::Atom& a, bool) {
        if (!program_.predicates[a.predicate].route || !a.arguments[1].is_variable()) return;
        if (a.arguments[0].variable == rule.site) near.insert(a.arguments[1].variable);
        if (a.arguments[1].variable == rule.site) near.insert(a.arguments[0].variable);
    });
    bool far = false;
    check::each_atom(rule.body, [&](const check::Atom& a, bool) {
        const Predicate& p = program_.predicates[a.predicate];
        const VariableId at = a.arguments[0].variable;
        if (at == rule.site) return;
        const bool back = is_neighbor(p) && a.arguments[1].is_variable() && a.arguments[1].variable == rule.site;
        far = far || !near.contains(at) || (p.world != WorldSource::None && !back);
    });
    return far;
}

void Ticks::find_certain() {
    for (const Stratum& c : program_.strata) {
        bool certain = !(c.recursive && c.links);
        for (const check::RuleId id : c.rules) {
            const Rule& rule = program_.rules[id];
            certain = certain && !looks_far(rule);
            check::each_atom(rule.body, [&](const check::Atom& a, bool) { certain = certain && certain_[a.predicate.index()]; });
        }
        // Nor is what waits for links that are not.
        for (const PredicateId p : c.predicates) {
            const PredicateId link = program_.predicates[p].complete_link;
            certain = certain && (!link.valid() || certain_[link.index()]);
        }
        // Which of equal values a recursive predicate keeps is a matter of ranks.
        for (const PredicateId p : c.predicates) certain = certain && !(c.recursive && left_to_history(program_.predicates[p], c));
        for (const PredicateId p : c.predicates) certain_[p.index()] = certain;
    }
}

// Facts that differ only in what the rule does not look at are derivations of their own.
void Ticks::tell_apart() {
    for (const check::RuleId id : program_.rules.ids()) {
        const Rule& rule = program_.rules[id];
        if (rule.linear || rule.heads[0].delay.op == check::Op::Anonymous || !program_.predicates[rule.heads[0].atom.predicate].needs_all())
            continue;
        counted_.emplace(id, told_apart(rule));
    }
}

// ---- facts from outside

void Ticks::give(PredicateId p, Row row) {
    Catom& catom = catoms_.try_emplace(row[0].integer(), empty()).first->second;
    if (program_.predicates[p].linear())
        catom.linear[p.index()].insert(std::move(row));
    else
        catom.given[p.index()].insert(std::move(row));
}

void Ticks::know(std::int64_t id) {
    known_.insert(id);
    nodes_.insert(std::ranges::lower_bound(nodes_, id), id);
    next_node_ = nodes_.back() + 1;
}

void Ticks::take(PredicateId p, const Row& row) { catoms_.at(row[0].integer()).given[p.index()].erase(row); }

// ---- the tick

void Ticks::step(const Scene& now) {
    std::erase_if(catoms_, [&](const auto& entry) { return !now.links.contains(entry.first); });
    messages_.clear();
    born_.clear();
    Scene scene = now;
    for (const auto& [id, links] : now.links) {
        Chance chance{.seed = seed_, .catom = static_cast<std::uint64_t>(id), .tick = static_cast<std::uint64_t>(now.tick)};
        const auto place = std::ranges::lower_bound(nodes_, id) - nodes_.begin();
        chance.first_node = static_cast<std::uint64_t>(next_node_ + place);
        chance.nodes_apart = nodes_.size();
        scene.chance = &chance;
        // A newborn shows nothing yet, and has its axioms once, in the order of the text.
        const bool born = !shown_.contains(id);
        Catom& catom = catoms_.try_emplace(id, empty()).first->second;
        catom.before = catom.views;
        for (const Rule& rule : program_.rules)
            if (born && rule.initial_fact) fire(rule, scene, visible(scene, id, catom), id, catom);
        evaluate(scene, id, catom);
    }
    shown_.clear();
    for (const auto& [id, catom] : catoms_) shown_[id] = catom.views;
    links_before_ = now.links;
    if (ways_ == Ways::Routes) ways_before_ = now.links;
    known_.clear();
    for (const auto& [id, links] : now.links) known_.insert(id);
    for (Message& m : messages_) deliver(Message(m));
    bear();
}

// A node is there from the next tick on, and all others know it then. Numbers that were taken for a node without facts stay unused.
void Ticks::bear() {
    for (const auto& [id, maker] : born_) {
        Catom& catom = catoms_.try_emplace(id, empty()).first->second;
        for (Later& fact : first_facts_[id]) catom.waiting.insert(std::move(fact));
        nodes_.push_back(id);
        known_.insert(id);
    }
    next_node_ = std::max(next_node_, greatest_node_ + 1);
    first_facts_.clear();
}

void Ticks::evaluate(const Scene& scene, std::int64_t id, Catom& catom) {
    for (Message& m : std::exchange(catom.passing, {}))
        if (m.far)
            send_far(scene, id, catom, std::move(m));
        else
            send(scene, id, std::move(m));
    for (int firings = 0; !failed_; ++firings) {
        if (firings > kMaxFirings) ran_away_ = true;
        settle(scene, id, catom);
        if (receive_one(scene.tick, catom)) continue;
        failed_ = failed_ || would_read_undefined(catom);
        const Facts seen = visible(scene, id, catom);
        const bool fired = !ran_away_ && std::any_of(program_.rules.begin(), program_.rules.end(), [&](const Rule& rule) {
            return rule.linear && !rule.initial_fact && fire(rule, scene, seen, id, catom);
        });
        if (!fired) return;
    }
}

// ---- facts on their way

void Ticks::put(const Scene& scene, std::int64_t id, Catom& catom, Made&& made) {
    if (program_.predicates[made.predicate].kind == check::PredicateKind::Action) return;
    Later fact{made.delay > 0 ? scene.tick + made.delay : 0, made.predicate, std::move(made.row)};
    if (made.begins) {
        const std::int64_t node = made.way[0];
        born_[node] = id;
        return first_facts_.at(node).push_back(std::move(fact));
    }
    if (made.far && program_.worlds == check::Worlds::Graphs)
        send_far(scene, id, catom, {std::move(made.way), std::move(fact), true});
    else if (!made.way.empty())
        send(scene, id, {std::move(made.way), std::move(fact)});
    else if (fact.due > 0)
        catom.waiting.insert(std::move(fact));
    else
        give(fact.predicate, std::move(fact.row));
}

// Where the link is gone, so is the fact, or it comes back here, with the catom that it was for.
void Ticks::send(const Scene& scene, std::int64_t from, Message&& message) {
    const std::vector<Link>& links = scene.links.at(from);
    const bool there = std::any_of(links.begin(), links.end(), [&](const Link& link) { return link.other == message.way[0]; });
    const auto back = returned_.find(message.fact.predicate);
    if (there) {
        messages_.push_back(std::move(message));
    } else if (back != returned_.end()) {
        message.fact.row.insert(message.fact.row.begin(), value_of(from));
        give(back->second, std::move(message.fact.row));
    }
}

// To the goal in one hop, or to the neighbour that is nearest to it. A sender knows which catoms there were at the end of the last tick: to
// one that has gone since, the fact is dropped.
void Ticks::send_far(const Scene& scene, std::int64_t from, Catom& catom, Message&& message) {
    const std::int64_t goal = message.way.back();
    // It is there from the next tick on, and nobody else knows it yet.
    if (ways_ == Ways::Hop && born_.contains(goal)) return first_facts_.at(goal).push_back(std::move(message.fact));
    const std::int64_t next = ways_ == Ways::Hop && known_.contains(goal) ? goal : next_hop(scene, from, goal);
    if (goal == from) {
        catom.waiting.insert(std::move(message.fact));
    } else if (next != from) {
        message.way = next == goal ? std::vector{goal} : std::vector{next, goal};
        if (scene.links.contains(next)) messages_.push_back(std::move(message));
    } else if (const auto back = returned_.find(message.fact.predicate); back != returned_.end()) {
        message.fact.row.insert(message.fact.row.begin(), value_of(from));
        give(back->second, std::move(message.fact.row));
    }
}

// The neighbour from which the goal is nearest, of equals the least, or the catom itself. Ways are those of the last tick; the first link
// is there now.
std::int64_t Ticks::next_hop(const Scene& scene, std::int64_t from, std::int64_t goal) const {
    if (ways_ == Ways::Hop || !known_.contains(goal)) return from;
    std::map<std::int64_t, int> distance{{goal, 0}};
    std::vector<std::int64_t> todo{goal};
    for (std::size_t i = 0; i < todo.size(); ++i) {
        const auto links = ways_before_.find(todo[i]);
        if (links == ways_before_.end()) continue;
        for (const Link& link : links->second)
            if (distance.emplace(link.other, distance[todo[i]] + 1).second) todo.push_back(link.other);
    }
    std::int64_t next = from;
    std::optional<std::pair<int, std::int64_t>> least;
    for (const Link& link : scene.links.at(from)) {
        const auto its = distance.find(link.other);
        if (its == distance.end() || (least && *least <= std::pair(its->second, link.other))) continue;
        least = {its->second, link.other};
        next = link.other;
    }
    return next;
}

void Ticks::deliver(Message&& message) {
    Catom& to = catoms_.at(message.way[0]);
    message.way.erase(message.way.begin());
    // Before any rule looks, but after the views have been derived.
    if (message.far && message.way.empty()) return void(to.waiting.insert(std::move(message.fact)));
    if (!message.way.empty())
        to.passing.push_back(std::move(message));
    else if (message.fact.due > 0)
        to.waiting.insert(std::move(message.fact));
    else
        give(message.fact.predicate, std::move(message.fact.row));
}

// What is due comes before any rule looks.
bool Ticks::receive_one(std::int64_t now, Catom& catom) {
    if (catom.waiting.empty() || catom.waiting.begin()->due > now) return false;
    Later fact = catom.waiting.extract(catom.waiting.begin()).value();
    give(fact.predicate, std::move(fact.row));
    return true;
}

// ---- views and rules

// What this catom sees: its own facts as they are, its neighbours' as they were.
Facts Ticks::visible(const Scene& scene, std::int64_t id, const Catom& catom) const {
    Facts facts = catom.views;
    for (const Link& link : scene.links.at(id)) {
        const auto shown = shown_.find(link.other);
        if (shown == shown_.end()) continue;
        for (std::size_t p = 0; p < facts.size(); ++p) facts[p].insert(shown->second[p].begin(), shown->second[p].end());
    }
    return facts;
}

void Ticks::settle(const Scene& scene, std::int64_t id, Catom& catom) {
    const Facts before = catom.views;
    catom.views.assign(before.size(), {});
    catom.undefined.clear();
    Facts seen = visible(scene, id, catom);
    for (const Stratum& c : program_.strata) {
        if (!certain_[c.predicates[0].index()]) continue;
        for (bool changing = true; changing;) {
            for (const PredicateId p : c.predicates) catom.undefined.erase(p);
            std::map<PredicateId, std::vector<Derived>> derived;
            for (const PredicateId p : c.predicates)
                for (const Row& row : catom.given[p.index()]) derived[p].push_back({row});
            for (const check::RuleId rule : c.rules) {
                const PredicateId head = program_.rules[rule].heads[0].atom.predicate;
                if (!derive_at(scene, id, catom, rule, seen, derived[head])) catom.undefined.insert(head);
            }
            changing = false;
            for (const PredicateId p : c.predicates) {
                const Predicate& predicate = program_.predicates[p];
                const std::size_t i = p.index();
                Rows rows;
                if (!reduce(scene, seen, predicate, derived[p], left_to_history(predicate, c) ? &before[i] : nullptr, rows))
                    catom.undefined.insert(p);
                if (rows == catom.views[i]) continue;
                changing = c.recursive;
                for (const Row& row : catom.views[i]) seen[i].erase(row);
                seen[i].insert(rows.begin(), rows.end());
                catom.views[i] = std::move(rows);
            }
        }
    }
}

// A delayed fact is there when its derivation has held without a break for so long.
bool Ticks::derive_at(const Scene& scene, std::int64_t id, Catom& catom, check::RuleId rule, const Facts& seen,
                      std::vector<Derived>& rows) {
    const check::Head& head = program_.rules[rule].heads[0];
    const bool delayed = head.delay.op != check::Op::Anonymous, counted = counted_.contains(rule);
    std::map<Row, std::int64_t> since;
    const Rule& derived = counted ? counted_.at(rule) : program_.rules[rule];
    const bool done = derive(derived, {scene, seen, nullptr, &catom.before}, id, [&](Derived made, const Environment& env) {
        if (delayed) {
            Row key = made.row;
            if (counted) add_found(scene, derived.body, env, key);
            const auto held = catom.since[rule].find(key);
            const std::int64_t from = held == catom.since[rule].end() ? scene.tick : held->second;
            since[key] = from;
            if (from + evaluate_delay(scene, head.delay) > scene.tick) return true;
        }
        rows.push_back(std::move(made));
        return true;
    });
    if (delayed) catom.since[rule] = std::move(since);
    return done;
}

// Some linear rule whose linear facts are there reads a view of which a derivation has no value, or one derived from it here.
bool Ticks::would_read_undefined(const Catom& catom) const {
    std::set<PredicateId> unsure = catom.undefined;
    const auto reads = [&](const std::vector<Clause>& body, VariableId site) {
        bool any = false;
        check::each_atom(
            body, [&](const check::Atom& a, bool) { any = any || (a.arguments[0].variable == site && unsure.contains(a.predicate)); });
        return any;
    };
    for (std::size_t before = 0; before != unsure.size();) {
        before = unsure.size();
        for (const Rule& rule : program_.rules)
            if (!rule.linear && reads(rule.body, rule.site)) unsure.insert(rule.heads[0].atom.predicate);
    }
    return !unsure.empty() && std::any_of(program_.rules.begin(), program_.rules.end(), [&](const Rule& rule) {
        if (!rule.linear || rule.initial_fact) return false;
        bool any = reads(rule.body, rule.site);
        check::each_head(rule.heads, [&](const check::Head& h) { any = any || reads(h.body, rule.site); });
        return any && std::all_of(rule.body.begin(), rule.body.end(), [&](const Clause& c) {
                   return c.kind != Clause::Kind::Atom || !program_.predicates[c.atom.predicate].linear() ||
                          !catom.linear[c.atom.predicate.index()].empty();
               });
    });
}

bool Ticks::fire(const Rule& rule, const Scene& scene, const Facts& seen, std::int64_t id, Catom& catom) {
    Application application(rule, {scene, seen, nullptr, &catom.before, &links_before_, rule.site}, catom.linear);
    const bool fired = application.run(id);
    failed_ = failed_ || application.failed;
    for (const std::int64_t node : application.born) {
        first_facts_.try_emplace(node);
        greatest_node_ = std::max(greatest_node_, node);
    }
    for (Made& m : application.made) put(scene, id, catom, std::move(m));
    return fired;
}

// ---- what there is

Facts Ticks::views() const {
    Facts all(program_.predicates.count());
    for (const auto& [id, catom] : catoms_)
        for (std::size_t p = 0; p < all.size(); ++p)
            if (certain_[p]) all[p].insert(catom.views[p].begin(), catom.views[p].end());
    return all;
}

Facts Ticks::given() const {
    Facts all(program_.predicates.count());
    for (const auto& [id, catom] : catoms_)
        for (std::size_t p = 0; p < all.size(); ++p) all[p].insert(catom.given[p].begin(), catom.given[p].end());
    return all;
}

Facts Ticks::arriving() const {
    Facts all(program_.predicates.count());
    for (const Message& m : messages_)
        if (m.way.size() == 1 && m.fact.due == 0 && !m.far) all[m.fact.predicate.index()].insert(m.fact.row);
    return all;
}

std::vector<Bag> Ticks::linear() const {
    std::vector<Bag> all(program_.predicates.count());
    for (const auto& [id, catom] : catoms_)
        for (std::size_t p = 0; p < all.size(); ++p) all[p].insert(catom.linear[p].begin(), catom.linear[p].end());
    return all;
}

}  // namespace meld::reference
