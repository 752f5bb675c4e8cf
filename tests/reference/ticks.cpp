#include "ticks.h"

#include <algorithm>
#include <set>

#include "model.h"

namespace meld::reference {

using check::Clause;
using check::Component;
using check::Head;
using check::Predicate;
using check::Rule;
using check::VariableId;
using check::WorldSource;

namespace {

constexpr int kMaxFirings = 3000;

bool is_neighbor(const Predicate& p) { return p.world == WorldSource::Neighbor || p.world == WorldSource::NeighborPort; }

// What one application of a linear rule does, gathered before any of it is done.
class Application {
  public:
    Application(const Rule& rule, const Scene& scene, const Facts& facts, std::vector<Bag>& linear)
        : program_(*scene.program), rule_(rule), scene_(scene), facts_(facts), linear_(linear) {}

    struct Made {
        PredicateId predicate;
        Row row;
    };
    std::vector<Made> made;
    bool failed = false;

    // Consumes what the first way to satisfy the body takes; false where there is none.
    bool run(std::int64_t home) {
        Environment env(rule_.variables.count());
        env[rule_.home.index()] = value_of(home);
        if (!consume_first(rule_.body, env)) return false;
        heads(rule_.heads, env);
        return true;
    }

  private:
    // Leaves the first way in env.
    bool consume_first(const std::vector<Clause>& body, Environment& env) {
        Solver solver(scene_, facts_, &linear_);
        Environment first;
        std::vector<Taken> taken;
        const bool any = solver.solve(body, env, [&] {
            first = env;
            taken = solver.taken();
            return true;
        });
        failed = failed || solver.failed();
        if (!any || failed) return false;
        env = std::move(first);
        for (const Taken& t : taken) {
            Bag& bag = linear_[t.predicate.index()];
            bag.erase(bag.find(t.row));
        }
        return true;
    }

    void heads(const std::vector<Head>& all, const Environment& env) {
        for (const Head& h : all) {
            if (h.kind == Head::Kind::Comprehension) {
                comprehension(h, env);
            } else {
                std::optional<Row> row = head_row(scene_, h.atom, env);
                failed = failed || !row;
                if (row) made.push_back({h.atom.predicate, std::move(*row)});
            }
        }
    }

    // One that consumes goes on as long as something is left; another acts for every way there is.
    void comprehension(const Head& h, const Environment& env) {
        bool consumes = false;
        check::each_atom(h.body, [&](const check::Atom& a, bool negated) { consumes = consumes || (!negated && !a.read_only && program_.predicates[a.predicate].linear()); });
        if (consumes) {
            for (Environment inner = env; consume_first(h.body, inner) && !failed; inner = env) heads(h.heads, inner);
            return;
        }
        Solver solver(scene_, facts_, &linear_);
        Environment inner = env;
        solver.solve(h.body, inner, [&] {
            heads(h.heads, inner);
            return false;
        });
        failed = failed || solver.failed();
    }

    const Program& program_;
    const Rule& rule_;
    const Scene& scene_;
    const Facts& facts_;
    std::vector<Bag>& linear_;
};

}  // namespace

Ticks::Ticks(const Program& program) : program_(program), certain_(program.predicates.count(), true) { find_certain(); }

Ticks::Catom Ticks::empty() const {
    const std::size_t n = program_.predicates.count();
    return {.given = Facts(n), .views = Facts(n), .linear = std::vector<Bag>(n)};
}

// ---- which views are certain

// Some atom is neither at the home nor at a catom that a link of the body joins to it directly; or it is a world fact of a
// neighbour, which travels like any other.
bool Ticks::looks_far(const Rule& rule) const {
    std::set<VariableId> near{rule.home};
    check::each_atom(rule.body, [&](const check::Atom& a, bool) {
        if (!program_.predicates[a.predicate].route || !a.arguments[1].is_variable()) return;
        if (a.arguments[0].variable == rule.home) near.insert(a.arguments[1].variable);
        if (a.arguments[1].variable == rule.home) near.insert(a.arguments[0].variable);
    });
    bool far = false;
    check::each_atom(rule.body, [&](const check::Atom& a, bool) {
        const Predicate& p = program_.predicates[a.predicate];
        const VariableId at = a.arguments[0].variable;
        if (at == rule.home) return;
        const bool back = is_neighbor(p) && a.arguments[1].is_variable() && a.arguments[1].variable == rule.home;
        far = far || !near.contains(at) || (p.world != WorldSource::None && !back);
    });
    return far;
}

void Ticks::find_certain() {
    for (const Component& c : program_.components) {
        bool certain = !(c.recursive && c.links);
        for (const check::RuleId id : c.rules) {
            const Rule& rule = program_.rules[id];
            certain = certain && !looks_far(rule);
            check::each_atom(rule.body, [&](const check::Atom& a, bool) { certain = certain && certain_[a.predicate.index()]; });
        }
        // Which of equal values a recursive predicate keeps is a matter of ranks.
        for (const PredicateId p : c.predicates) certain = certain && !(c.recursive && left_to_history(program_.predicates[p], c));
        for (const PredicateId p : c.predicates) certain_[p.index()] = certain;
    }
}

// ---- facts from outside

void Ticks::give(PredicateId p, Row row) {
    Catom& catom = catoms_.try_emplace(row[0].integer(), empty()).first->second;
    if (program_.predicates[p].linear()) catom.linear[p.index()].insert(std::move(row));
    else catom.given[p.index()].insert(std::move(row));
}

void Ticks::take(PredicateId p, const Row& row) { catoms_.at(row[0].integer()).given[p.index()].erase(row); }

// ---- the tick

void Ticks::step(const Scene& scene) {
    std::erase_if(catoms_, [&](const auto& entry) { return !scene.links.contains(entry.first); });
    messages_.clear();
    for (const auto& [id, links] : scene.links) {
        // A newborn shows nothing yet, and has its axioms once, in the order of the text.
        const bool born = !shown_.contains(id);
        Catom& catom = catoms_.try_emplace(id, empty()).first->second;
        if (born)
            for (const Rule& rule : program_.rules)
                if (rule.birth) fire(rule, scene, id, catom);
    }
    for (auto& [id, catom] : catoms_) evaluate(scene, id, catom);
    shown_.clear();
    for (const auto& [id, catom] : catoms_) shown_[id] = catom.views;
    for (const Message& m : messages_) {
        Catom& to = catoms_.at(m.to);
        if (program_.predicates[m.predicate].linear()) to.linear[m.predicate.index()].insert(m.row);
        else to.given[m.predicate.index()].insert(m.row);
    }
}

void Ticks::evaluate(const Scene& scene, std::int64_t id, Catom& catom) {
    for (int firings = 0; !failed_; ++firings) {
        if (firings > kMaxFirings) ran_away_ = true;
        settle(scene, id, catom);
        const bool fired = !ran_away_ && std::any_of(program_.rules.begin(), program_.rules.end(), [&](const Rule& rule) { return rule.linear && !rule.birth && fire(rule, scene, id, catom); });
        if (!fired) return;
    }
}

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
    Facts seen = visible(scene, id, catom);
    for (const Component& c : program_.components) {
        if (!certain_[c.predicates[0].index()]) continue;
        for (bool changing = true; changing && !failed_;) {
            std::map<PredicateId, std::vector<Row>> derived;
            for (const PredicateId p : c.predicates) derived[p].assign(catom.given[p.index()].begin(), catom.given[p.index()].end());
            for (const check::RuleId rule : c.rules) {
                std::vector<Row>& rows = derived[program_.rules[rule].heads[0].atom.predicate];
                failed_ = !derive(program_.rules[rule], scene, seen, id, [&](Row row) {
                    rows.push_back(std::move(row));
                    return true;
                }) || failed_;
            }
            changing = false;
            for (const PredicateId p : c.predicates) {
                const Predicate& predicate = program_.predicates[p];
                const std::size_t i = p.index();
                Rows rows;
                failed_ = !reduce(predicate, derived[p], left_to_history(predicate, c) ? &before[i] : nullptr, rows) || failed_;
                if (rows == catom.views[i]) continue;
                changing = c.recursive;
                for (const Row& row : catom.views[i]) seen[i].erase(row);
                seen[i].insert(rows.begin(), rows.end());
                catom.views[i] = std::move(rows);
            }
        }
    }
}

// Heads come into being when the whole rule has been applied: none of its comprehensions sees them.
bool Ticks::fire(const Rule& rule, const Scene& scene, std::int64_t id, Catom& catom) {
    const Facts seen = visible(scene, id, catom);
    Application application(rule, scene, seen, catom.linear);
    const bool fired = application.run(id);
    failed_ = failed_ || application.failed;
    if (!fired) return false;
    for (Application::Made& m : application.made) {
        const std::int64_t to = m.row[0].integer();
        const Predicate& p = program_.predicates[m.predicate];
        if (p.kind == check::PredicateKind::Action) continue;
        if (to == id) {
            give(m.predicate, std::move(m.row));
            continue;
        }
        const std::vector<Link>& links = scene.links.at(id);
        const bool there = std::any_of(links.begin(), links.end(), [&](const Link& link) { return link.other == to; });
        if (there) messages_.push_back({to, m.predicate, std::move(m.row)});
    }
    return true;
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
    for (const Message& m : messages_) all[m.predicate.index()].insert(m.row);
    return all;
}

std::vector<Bag> Ticks::linear() const {
    std::vector<Bag> all(program_.predicates.count());
    for (const auto& [id, catom] : catoms_)
        for (std::size_t p = 0; p < all.size(); ++p) all[p].insert(catom.linear[p].begin(), catom.linear[p].end());
    return all;
}

}  // namespace meld::reference
