#include "runtime/ask/why/explainer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "compiler/syntax/stable_name.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::inspect {

using check::Clause;
using check::Op;
using check::PredicateId;
using check::Rule;
using check::Term;
using check::Type;
using check::VariableId;

// ---- text, and values that last

std::string Explainer::value_text(const Type& type, Value v) { return tuple::print_value(terms_.types.of(type), v); }

std::string Explainer::text(const Known& fact) {
    const check::Predicate& p = predicate(fact.predicate);
    std::string arguments = fact.catom ? fmt::format("@{}", *fact.catom) : "_";
    for (std::size_t i = 0; i < fact.arguments.size(); ++i)
        arguments += ", " + (fact.arguments[i] ? value_text(p.arguments[i + 1].type, *fact.arguments[i]) : "_");
    return syntax::print_fact(p.name, arguments);
}

Value Explainer::keep(const Type& type, Value v) {
    if (!type.compound()) return v;
    ByteWriter packed;
    tuple::pack(terms_.types.of(type), v, packed);
    ByteReader in(packed.view(), "an explanation");
    return tuple::unpack(terms_.types.of(type), in, lists_);
}

Known Explainer::keep(PredicateId id, const Fact& fact, std::size_t age) {
    const check::Predicate& p = predicate(id);
    Known known{.predicate = id, .catom = fact.catom, .rank = fact.rank, .age = age};
    for (std::size_t i = 1; i < p.arguments.size(); ++i) known.arguments.emplace_back(keep(p.arguments[i].type, fact.arguments[i - 1]));
    return known;
}

Rule Explainer::named(const PartialMatch& match, const Values& values, const Bound& bound) {
    Rule out = match.rule;
    for (const VariableId v : out.variables.ids())
        if (bound[v.index()]) out.variables[v].name = value_text(out.variables[v].type, values[v.index()]);
    return out;
}

std::string Explainer::print(const Rule& named, const std::vector<Clause>& clauses) const {
    std::string out;
    for (const Clause& c : clauses) out += (out.empty() ? "" : ", ") + print(named, c);
    return out;
}

Explanation::Way Explainer::way_of(const Rule& rule) const {
    return {.rule = rule.name, .text = rule.text, .file = rule.file, .line = rule.line};
}

std::vector<std::pair<std::string, std::string>> Explainer::with(const PartialMatch& match, const Values& values, const Bound& bound) {
    std::vector<std::pair<std::string, std::string>> out;
    const check::Rule& rule = *match.of;
    for (const VariableId v : rule.variables.ids())
        if (bound[v.index()] && !rule.variables[v].name.starts_with('_'))
            out.emplace_back(rule.variables[v].name, value_text(rule.variables[v].type, values[v.index()]));
    return out;
}

// ---- what is asked

Result<Known> Explainer::asked() {
    const Rule& question = program_.question();
    const check::Atom* atom = nullptr;
    const auto refuse = [] {
        return fail("this is not one fact", "Write a predicate with its arguments, _ where anything will do: 'dist(@42, 7)'");
    };
    for (const Clause& c : question.body) {
        if (c.kind == Clause::Kind::Test) continue;
        if (c.kind != Clause::Kind::Atom || atom != nullptr) return refuse();
        atom = &c.atom;
    }
    if (atom == nullptr) return refuse();
    const check::Predicate& p = predicate(atom->predicate);
    Values none(question.variables.count());
    // A value stands in the atom itself, or in an equality with its variable.
    const auto value_of = [&](const Term& argument, const Type& type) -> std::optional<Value> {
        const Term* term = &argument;
        if (argument.is_variable()) {
            term = nullptr;
            for (const Clause& c : question.body) {
                if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
                for (const std::size_t side : {0u, 1u})
                    if (c.test.operands[side].is_variable() && c.test.operands[side].variable == argument.variable)
                        term = &c.test.operands[1 - side];
            }
        }
        if (term == nullptr || term->op == Op::Anonymous) return std::nullopt;
        bool ground = true;
        check::each_variable(*term, [&](VariableId) { ground = false; });
        if (!ground) return std::nullopt;
        const Value v = terms_.value_as(*term, type, none);
        if (!terms_.scratch.went_well()) return std::nullopt;
        return keep(type, v);
    };
    Known known{.predicate = atom->predicate};
    if (const auto v = value_of(atom->arguments[0], Type::Node)) known.catom = v->catom;
    for (std::size_t i = 1; i < atom->arguments.size(); ++i) known.arguments.push_back(value_of(atom->arguments[i], p.arguments[i].type));
    return known;
}

bool Explainer::asks_more() {
    const Rule& question = program_.question();
    // A catom that is named twice is one variable, whose value a test says.
    const auto named = [&](const Term& variable) {
        return std::ranges::any_of(question.body, [&](const Clause& c) {
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) return false;
            return std::ranges::any_of(std::array{0u, 1u}, [&](std::size_t side) {
                const Term& other = c.test.operands[1 - side];
                return c.test.operands[side].is_variable() && c.test.operands[side].variable == variable.variable && other.op == Op::Node;
            });
        });
    };
    std::set<VariableId> open;
    for (const Clause& c : question.body)
        if (c.kind == Clause::Kind::Atom)
            for (const Term& t : c.atom.arguments)
                if (t.is_variable() && !open.insert(t.variable).second && !named(t)) return true;
    // Each says the value of one that had none.
    const auto says_value = [&](const Term& variable, const Term& value) {
        bool ground = variable.is_variable();
        check::each_variable(value, [&](VariableId) { ground = false; });
        return ground && open.erase(variable.variable) > 0;
    };
    return std::ranges::any_of(question.body, [&](const Clause& c) {
        if (c.kind != Clause::Kind::Test) return false;
        if (c.test.op != Op::Equal) return true;
        return !says_value(c.test.operands[0], c.test.operands[1]) && !says_value(c.test.operands[1], c.test.operands[0]);
    });
}

Result<void> Explainer::each_match(const std::function<bool(const Known&)>& visit) {
    const Rule& question = program_.question();
    const auto atom = std::ranges::find(question.body, Clause::Kind::Atom, &Clause::kind);
    MELD_EXPECT(atom != question.body.end());
    const auto number = static_cast<std::size_t>(atom - question.body.begin());
    return solver_.search(question, question.body, {}, {},
                          [&](const Solution& found) { return visit(keep(atom->atom.predicate, *found.facts[number], 0)); });
}

std::optional<u32> Explainer::holds(const Known& fact) { return holds_in(program_.source(fact.predicate), fact); }

std::optional<u32> Explainer::holds_in(const Source& source, const Known& fact) {
    const check::Predicate& p = predicate(fact.predicate);
    std::optional<u32> rank;
    facts(fact.age).at(source, *fact.catom, [&](const Fact& f) {
        for (std::size_t i = 0; i < fact.arguments.size(); ++i)
            if (fact.arguments[i] && !terms_.equal(p.arguments[i + 1].type, f.arguments[i], *fact.arguments[i])) return true;
        rank = f.rank;
        return false;
    });
    return rank;
}

// ---- rules

std::vector<const Rule*> Explainer::views(PredicateId id) const {
    std::vector<const Rule*> out;
    for (const Rule& rule : checked().rules)
        if (!rule.linear && rule.heads.size() == 1 && rule.heads[0].kind == check::Head::Kind::Fact && rule.heads[0].atom.predicate == id)
            out.push_back(&rule);
    return out;
}

std::vector<const Rule*> Explainer::linear_rules(PredicateId id) const {
    std::vector<const Rule*> out;
    for (const Rule& rule : checked().rules) {
        bool makes = false;
        if (rule.linear)
            check::each_head(rule.heads,
                             [&](const check::Head& h) { makes = makes || (h.kind == check::Head::Kind::Fact && h.atom.predicate == id); });
        if (makes) out.push_back(&rule);
    }
    return out;
}

// ---- states

namespace {

// Facts of a state, with those of fronts in place of their best.
class WithFronts : public Facts {
  public:
    WithFronts(Facts& facts, const std::map<u32, u32>& fronts) : facts_(facts), fronts_(fronts) {}
    bool at(const Source& source, u64 catom, const Visit& visit) override { return facts_.at(front_of(source), catom, visit); }
    bool heard(const Source& source, u64 catom, u64 by, const Visit& visit) override {
        return facts_.heard(front_of(source), catom, by, visit);
    }
    bool each(const Source& source, const Visit& visit) override { return facts_.each(front_of(source), visit); }
    bool back(const Source& source, u64 to, const Visit& visit) override { return facts_.back(source, to, visit); }
    bool exists(u64 catom) override { return facts_.exists(catom); }
    std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) override { return facts_.loss(source, catom, group); }

  private:
    Source front_of(Source source) const {
        const auto found = fronts_.find(source.predicate);
        if (source.kind == Source::Kind::Stored && found != fronts_.end()) source.predicate = found->second;
        return source;
    }
    Facts& facts_;
    const std::map<u32, u32>& fronts_;
};

// Facts of a catom and its neighbours, as it has heard those of the latter.
class AsHeard : public Facts {
  public:
    AsHeard(Facts& facts, const Source& links, u64 by) : facts_(facts), links_(links), by_(by) {}
    bool at(const Source& source, u64 catom, const Visit& visit) override {
        return catom == by_ ? facts_.at(source, catom, visit) : facts_.heard(source, catom, by_, visit);
    }
    bool each(const Source& source, const Visit& visit) override {
        std::set<u64> catoms{by_};
        facts_.at(links_, by_, [&](const Fact& link) { return catoms.insert(link.arguments[0].catom), true; });
        return std::ranges::all_of(catoms, [&](u64 catom) { return at(source, catom, visit); });
    }
    bool back(const Source& source, u64 to, const Visit& visit) override { return facts_.back(source, to, visit); }
    bool exists(u64 catom) override { return facts_.exists(catom); }
    std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) override { return facts_.loss(source, catom, group); }

  private:
    Facts& facts_;
    const Source links_;
    const u64 by_;
};

// What a catom has read of others before the first tick: no catom had told anything.
class NoFacts : public Facts {
  public:
    bool at(const Source&, u64, const Visit&) override { return true; }
    bool each(const Source&, const Visit&) override { return true; }
    bool back(const Source&, u64, const Visit&) override { return true; }
    bool exists(u64) override { return false; }
    std::optional<Tombstone> loss(const Source&, u64, u64) override { return std::nullopt; }
};

}  // namespace

Explainer::Explainer(const Program& program, const States& states, Terms& terms)
    : program_(program), states_(states), terms_(terms), solver_(program, *states.facts[0], terms), existence_(program) {
    find_fronts();
    if (existence_.any())
        for (Facts* facts : states_.facts) groups_.push_back(existence_.groups_of(*facts));
}

void Explainer::find_fronts() {
    for (const PredicateId p : checked().predicates.ids())
        if (const Source front = ranked_source(p); front != program_.source(p)) fronts_[program_.source(p).predicate] = front.predicate;
    if (fronts_.empty()) return;
    for (Facts* facts : states_.facts) with_fronts_.push_back(std::make_unique<WithFronts>(*facts, fronts_));
}

std::map<VariableId, std::size_t> Explainer::distances(const PartialMatch& match) const {
    std::map<VariableId, std::size_t> out;
    if (match.rule.site.valid()) out[match.rule.site] = 0;
    for (bool changed = true; changed;) {
        changed = false;
        check::each_atom(match.body, [&](const check::Atom& a, bool) {
            const check::Predicate& p = predicate(a.predicate);
            if (!(p.route || meld::is_link(p.world)) || a.arguments.size() < 2 || !a.arguments[1].is_variable()) return;
            for (const std::size_t side : {0u, 1u}) {
                const auto known = out.find(a.arguments[side].variable);
                if (known == out.end()) continue;
                const auto [other, is_new] = out.try_emplace(a.arguments[1 - side].variable, known->second + 1);
                if (is_new || other->second <= known->second + 1) {
                    changed = changed || is_new;
                    continue;
                }
                other->second = known->second + 1;
                changed = true;
            }
        });
    }
    return out;
}

std::size_t Explainer::age_of(const PartialMatch& match, const Clause& clause, bool spread) const {
    if (!spread || clause.kind != Clause::Kind::Atom) return 0;
    const auto all = distances(match);
    const auto of = [&](const Term& t) {
        const auto found = t.is_variable() ? all.find(t.variable) : all.end();
        return found == all.end() ? std::size_t{0} : found->second;
    };
    const std::size_t here = of(clause.atom.arguments[0]);
    // A link is sensed at both of its ends.
    const bool link = meld::is_link(predicate(clause.atom.predicate).world) && clause.atom.arguments[1].is_variable();
    return link ? std::min(here, of(clause.atom.arguments[1])) : here;
}

bool Explainer::told_nothing(std::size_t age) const { return states_.first_tick == 0 && states_.tick <= static_cast<i64>(age); }

Result<bool> Explainer::search(const PartialMatch& match, const Search& how, const Solver::Found& found) {
    std::size_t oldest = how.age;
    std::map<const Clause*, std::size_t> ages;
    static NoFacts nothing;
    std::set<const Clause*> unread, heard;
    const bool hears = how.as_heard && match.rule.site.valid() && match.bound[match.rule.site.index()];
    const auto look = [&](const auto& self, const std::vector<Clause>& body) -> void {
        for (const Clause& c : body) {
            if (c.kind == Clause::Kind::Atom) {
                const std::size_t away = age_of(match, c, how.spread);
                if (hears && age_of(match, c, true) == 1) heard.insert(&c);
                ages[&c] = how.age + std::max(away, how.linear_before ? linear_age(c) : 0);
                if (away > 0 && told_nothing(ages[&c]))
                    unread.insert(&c);
                else
                    oldest = std::max(oldest, ages[&c]);
            }
            self(self, c.inner);
        }
    };
    look(look, match.body);
    if (states_.tick - static_cast<i64>(oldest) < states_.first_tick) {
        before_the_first_ = true;
        return false;
    }
    if (oldest >= states_.facts.size()) {
        wanted_ = std::max(wanted_, oldest);
        return false;
    }
    const SearchOptions options{.allowed = how.allowed,
                                .best = how.best,
                                .further = how.further,
                                .from = [&](const Clause& c) -> Facts& {
                                    if (unread.contains(&c)) return nothing;
                                    const std::size_t age = ages.at(&c);
                                    if (asks_existence(match, c, how.recursion)) return *groups_[age];
                                    const bool front = how.recursion != nullptr && how.recursion->contains(c.atom.predicate);
                                    Facts& all = front && !with_fronts_.empty() ? *with_fronts_[age] : facts(age);
                                    return heard.contains(&c) ? as_heard(all, match.values[match.rule.site.index()].catom) : all;
                                },
                                .readable = readable(match, how)};
    const Solver::Found different = [&](const Solution& solution) {
        return !are_different(match, solution, [&](const Clause& c) -> Facts& { return facts(ages.at(&c)); }) || found(solution);
    };
    const Solver::Found& each = match.of != nullptr && match.of->linear ? different : found;
    if (auto done = solver_.search(match.rule, match.body, match.values, match.bound, each, options); !done)
        return tl::unexpected<Error>(done.error());
    return true;
}

Source Explainer::links() const {
    Source links;
    for (const PredicateId id : checked().predicates.ids())
        if (predicate(id).world == WorldSource::Neighbor) links = program_.source(id);
    return links;
}

Facts& Explainer::as_heard(Facts& facts, u64 by) {
    std::unique_ptr<Facts>& heard = heard_[{&facts, by}];
    if (heard == nullptr) heard = std::make_unique<AsHeard>(facts, links(), by);
    return *heard;
}

std::function<bool(const Clause&, const Fact&)> Explainer::readable(const PartialMatch& match, const Search& how) {
    const auto is_route = [&](const check::Atom& a) { return predicate(a.predicate).route && a.arguments[1].is_variable(); };
    bool any = false;
    check::each_atom(match.body, [&](const check::Atom& a, bool) { any = any || is_route(a); });
    if (!any) return {};
    return [this, all = distances(match), links = links(), age_of_head = how.age, spread = how.spread, is_route](const Clause& c,
                                                                                                                 const Fact& fact) {
        if (!is_route(c.atom)) return true;
        std::array<std::size_t, 2> away;
        for (const std::size_t side : {0u, 1u}) {
            const auto found = all.find(c.atom.arguments[side].variable);
            if (found == all.end()) return true;
            away[side] = found->second;
        }
        const std::size_t age = age_of_head + (spread ? std::min(away[0], away[1]) : 0);
        if (away[0] == away[1] || age >= states_.facts.size()) return true;
        bool linked = false;
        facts(age).at(links, fact.catom, [&](const Fact& link) {
            linked = link.arguments[0].catom == fact.arguments[0].catom;
            return !linked;
        });
        return linked;
    };
}

bool Explainer::are_different(const PartialMatch& match, const Solution& solution, const std::function<Facts&(const Clause&)>& from) {
    const auto same = [&](PredicateId id, const Fact& a, const Fact& b) {
        bool equal = a.catom == b.catom;
        for (std::size_t i = 1; i < predicate(id).arguments.size(); ++i)
            equal = equal && terms_.equal(predicate(id).arguments[i].type, a.arguments[i - 1], b.arguments[i - 1]);
        return equal;
    };
    for (std::size_t i = 0; i < match.of->body.size(); ++i) {
        const Clause& c = match.body[i];
        const PredicateId id = c.atom.predicate;
        if (solution.facts[i] == nullptr || c.atom.read_only || !predicate(id).linear()) continue;
        const Fact& fact = *solution.facts[i];
        // What the rule reads, the body of a head may consume.
        std::size_t consumed = 0, read = 0, in_heads = 0;
        for (std::size_t k = 0; k < match.own; ++k) {
            const Clause& other = match.body[k];
            if (solution.facts[k] == nullptr || other.atom.predicate != id || !same(id, fact, *solution.facts[k])) continue;
            if (other.atom.read_only)
                read = 1;
            else
                ++(k < match.of->body.size() ? consumed : in_heads);
        }
        const std::size_t needed = consumed + std::max(read, in_heads);
        if (needed < 2) continue;
        std::size_t there = 0;
        from(c).at(program_.source(id), fact.catom, [&](const Fact& f) {
            there += same(id, fact, f) ? 1 : 0;
            return there < needed;
        });
        if (there < needed) return false;
    }
    return true;
}

Result<void> Explainer::search_part(const PartialMatch& match, const std::vector<Clause>& part, Values values, Bound bound,
                                    const Search& how, const Solver::Found& found) {
    static NoFacts nothing;
    const SearchOptions options{.best = how.best,
                                .further = how.further,
                                .from = [&](const Clause& c) -> Facts& {
                                    const std::size_t away = age_of(match, c, how.spread);
                                    if (away > 0 && told_nothing(how.age + away)) return nothing;
                                    return facts(std::min(how.age + age_of(match, c, how.spread), states_.facts.size() - 1));
                                },
                                .readable = readable(match, how)};
    bound.resize(match.rule.variables.count());
    values.resize(match.rule.variables.count());
    return solver_.search(match.rule, part, std::move(values), std::move(bound), found, options);
}

// ---- kinds of predicates

std::optional<Source> Explainer::base_of(PredicateId id) const {
    const Source& own = program_.source(id);
    if (own.predicate == kNone32 || own.kind == Source::Kind::World) return std::nullopt;
    const PredicateInfo& info = program_.module().predicates[own.predicate];
    if (info.base == kNone16) return std::nullopt;
    Source base = own;
    base.predicate = info.base;
    return base;
}

bool Explainer::is_base(const Known& fact) {
    const std::optional<Source> base = base_of(fact.predicate);
    return base && holds_in(*base, fact);
}

Source Explainer::ranked_source(PredicateId id) const {
    Source out = program_.source(id);
    const ModuleInfo& module = program_.module();
    const std::string front = predicate(id).name + "@front";
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (module.predicates[i].name == front && module.predicates[i].arity == out.arity) out.predicate = i;
    return out;
}

const check::Stratum* Explainer::recursion_of(PredicateId id) const {
    for (const check::Stratum& s : checked().strata)
        if (s.recursive && s.contains(id)) return &s;
    return nullptr;
}

}  // namespace meld::inspect
