#include "runtime/ask/why/why.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "runtime/ask/why/alternatives.h"
#include "runtime/ask/why/delayed_derivations.h"
#include "runtime/ask/why/earlier_states.h"
#include "runtime/ask/why/fact_origins.h"
#include "runtime/ask/why/lower_ranks.h"
#include "runtime/ask/why/read_facts.h"

namespace meld::inspect {

namespace {

using check::Clause;
using check::PredicateId;
using check::PredicateKind;
using check::Rule;
using Node = Explanation::Node;
using Part = Explanation::Part;
using Way = Explanation::Way;

// Roots with `all`.
constexpr std::size_t kMostRoots = 1000;
constexpr std::size_t kNoDepth = 0;
constexpr const char* kUnranked = "ranks do not say here what rests on what";

class Why {
  public:
    Why(Explainer& explainer, const WhyOptions& options) : e_(explainer), options_(options), lower_(explainer) {}

    Result<Explanation> run(const std::string& asked) {
        out_.tick = e_.states().tick;
        out_.asked = asked;
        if (auto one = e_.asked(); !one) return tl::unexpected<Error>(one.error());
        std::set<std::string> seen;
        const Result<void> matched = e_.each_match([&](const Known& fact) {
            if (!seen.insert(e_.text(fact)).second) return true;
            if (out_.roots.size() == kMostRoots)
                ++out_.more;
            else
                out_.roots.push_back(add(fact, 0));
            return options_.all;
        });
        if (!matched) return tl::unexpected<Error>(matched.error());
        for (std::size_t i = 0; i < facts_.size(); ++i)
            if (auto done = explain(i); !done) return tl::unexpected<Error>(done.error());
        out_.mark_circles();
        return std::move(out_);
    }

    // How a body is met, with this catom as that of its first fact; its last parts only say which way it is.
    Result<Explanation> run_body(const std::string& asked, u64 catom, std::size_t last_parts) {
        out_.tick = e_.states().tick;
        out_.asked = asked;
        out_.nodes.push_back({.is = Node::Is::Derived, .fact = asked, .tick = out_.tick});
        out_.roots = {0};
        facts_.push_back({});
        const PartialMatch body = at_catom(e_.program().question(), catom, last_parts);
        Result<void> within;
        bool found = false, lacks = false;
        // As in derive().
        for (const bool spread : {false, true}) {
            if (found || (spread && e_.states().settled)) continue;
            const Explainer::Search search{.spread = spread};
            const Result<bool> done = e_.search(body, search, [&](const Solution& solution) {
                auto way = way_of(0, body, search, solution);
                if (!way) {
                    within = tl::unexpected<Error>(way.error());
                    return false;
                }
                way->text.clear();
                node(0).fact = e_.print(e_.named(body, solution.values, bound_by(body)),
                                        {body.body.begin(), body.body.begin() + static_cast<std::ptrdiff_t>(body.own)});
                node(0).ways.push_back(std::move(*way));
                found = true;
                return false;
            });
            if (!done) return tl::unexpected<Error>(done.error());
            if (!within) return tl::unexpected<Error>(within.error());
            lacks = lacks || !*done;
        }
        if (!found) static_cast<void>(unknown(0, lacks));
        for (std::size_t i = 1; i < facts_.size(); ++i)
            if (auto done = explain(i); !done) return tl::unexpected<Error>(done.error());
        out_.mark_circles();
        return std::move(out_);
    }

  private:
    struct Asked {
        Known fact;
        std::size_t depth;
    };

    // Whether ranks are compared.
    enum class Ranks { Compared, Ignored };

    std::size_t add(const Known& fact, std::size_t depth) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        const bool sensed = p.world != WorldSource::None;
        const std::string text = e_.text(fact);
        const auto [known, is_new] = numbers_.try_emplace({text, fact.age}, facts_.size());
        if (!is_new) return known->second;
        Known kept = fact;
        std::string note;
        const Source ranked = e_.ranked_source(fact.predicate);
        if (!fact.whole()) {
            if (!e_.holds(fact)) note = "it has a value, and which one still waits for a quarantine";
        } else if (ranked != e_.program().source(fact.predicate)) {
            if (const auto rank = e_.holds_in(ranked, fact)) kept.rank = *rank;
            if (!e_.holds(fact)) note = "a value that a better one has replaced, and on which others still rest";
        }
        out_.nodes.push_back({.is = sensed ? Node::Is::Sensed : Node::Is::Unknown,
                              .fact = text,
                              .tick = e_.states().tick - static_cast<i64>(fact.age),
                              .rank = kept.rank,
                              .note = note});
        facts_.push_back({kept, depth});
        return known->second;
    }
    Node& node(std::size_t i) { return out_.nodes[i]; }

    Result<void> explain(std::size_t i) {
        const Known fact = facts_[i].fact;
        const check::Predicate& p = e_.predicate(fact.predicate);
        if (p.world != WorldSource::None) return {};
        if (p.sensed) return set(i, Node::Is::Sensed);
        if (p.linear()) return set(i, Node::Is::Made);
        if (syntax::combines(p.aggregate)) return combine(i);
        if (given(i) && !options_.all) return {};
        return derive(i);
    }
    Result<void> set(std::size_t i, Node::Is is, std::string note = "") {
        node(i).is = is;
        node(i).note = std::move(note);
        return {};
    }

    // Whether it is given from outside, or made by a linear rule.
    bool given(std::size_t i) {
        const Known& fact = facts_[i].fact;
        if (!e_.is_base(fact)) return false;
        node(i).is = e_.linear_rules(fact.predicate).empty() ? Node::Is::Given : Node::Is::Made;
        return true;
    }

    // ---- one derivation

    Result<void> derive(std::size_t i) {
        if (options_.depth != kNoDepth && facts_[i].depth >= options_.depth) return further(i);
        const bool several = options_.all && facts_[i].depth == 0;
        bool any = false, lacks = false;
        // Where everything holds in one state, that says more than facts of several ticks.
        for (const Ranks ranks : {Ranks::Compared, Ranks::Ignored}) {
            const bool before = any;
            for (const bool spread : {false, true}) {
                if (any || (spread && e_.states().settled && facts_[i].fact.age == 0)) continue;
                // Whether the body of a rule with a delay has been met for long enough is not known from this state alone: such a rule
                // is the answer where no other is.
                for (const bool delayed : {false, true})
                    for (const Rule* rule : e_.derivations(facts_[i].fact.predicate)) {
                        if (any && (!several || delayed)) break;
                        if ((rule->heads[0].delay.op != check::Op::Anonymous) != delayed) continue;
                        const Result<Outcome> one = by_rule(i, *rule, {spread, ranks, several ? ~std::size_t{0} : std::size_t{1}});
                        if (!one) return tl::unexpected<Error>(one.error());
                        any = any || one->found > 0;
                        lacks = lacks || one->lacks;
                    }
                // With more states it is tried again.
                if (!any && lacks && !e_.before_the_first() && e_.wanted() < kMostStates) return {};
            }
            if (e_.recursion_of(facts_[i].fact.predicate) == nullptr) break;
            if (any && !before && ranks == Ranks::Ignored) {
                std::string& note = node(i).note;
                note += (note.empty() ? "" : "; ") + std::string(kUnranked);
            }
        }
        if (!any) {
            if (node(i).is != Node::Is::Unknown) return {};
            return unknown(i, lacks);
        }
        if (node(i).is == Node::Is::Unknown) node(i).is = Node::Is::Derived;
        if (facts_[i].depth > 0 || !facts_[i].fact.whole()) return {};
        Result<std::vector<std::string>> others = alternatives(e_, facts_[i].fact);
        if (!others) return tl::unexpected<Error>(others.error());
        node(i).others = std::move(*others);
        return {};
    }

    Result<void> further(std::size_t i) {
        const bool axiom = std::ranges::any_of(e_.views(facts_[i].fact.predicate), [](const Rule* r) { return r->body.empty(); });
        return set(i, axiom ? Node::Is::Given : Node::Is::Further);
    }

    Result<void> unknown(std::size_t i, bool lacks) {
        std::string cannot;
        for (const Rule* rule : e_.views(facts_[i].fact.predicate))
            if (const std::string why = e_.cannot(rule->body); !why.empty())
                cannot = fmt::format("{}:{} cannot be looked up: {}", rule->file, rule->line, why);
        if (!cannot.empty()) return set(i, Node::Is::Unknown, cannot);
        if (lacks && e_.before_the_first())
            return set(i, Node::Is::Unknown,
                       fmt::format("what it rested on has changed since, and nothing is known of ticks before {}", e_.states().first_tick));
        if (lacks) return set(i, Node::Is::Further, fmt::format("it rests on facts of earlier ticks; ask in tick {}", node(i).tick));
        return set(i, Node::Is::Unknown, "what it rested on has changed since");
    }

    struct Outcome {
        std::size_t found = 0;
        bool lacks = false;  // States that it would need.
    };
    struct How {
        bool spread;
        Ranks ranks;
        std::size_t most;
    };

    Result<Outcome> by_rule(std::size_t i, const Rule& rule, const How& how) {
        const Known fact = facts_[i].fact;
        const std::optional<PartialMatch> match = e_.match_head(rule, rule.heads[0].atom, fact, false);
        if (!match || !e_.cannot(match->body).empty()) return Outcome{};
        const Explainer::Search search{.age = fact.age,
                                       .spread = how.spread,
                                       .allowed = how.ranks == Ranks::Compared ? lower_.than(*match, fact) : LowerRanks::Allowed{},
                                       .recursion = e_.recursion_of(fact.predicate)};
        Outcome out;
        Result<void> within;
        const Result<bool> done = e_.search(*match, search, [&](const Solution& solution) {
            if (out.found < how.most) {
                auto way = way_of(i, *match, search, solution);
                if (!way) {
                    within = tl::unexpected<Error>(way.error());
                    return false;
                }
                add_way(i, std::move(*way));
            } else {
                ++node(i).more;
            }
            ++out.found;
            return how.most > 1;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        if (!within) return tl::unexpected<Error>(within.error());
        out.lacks = !*done;
        const bool axiom = std::ranges::all_of(rule.body, [](const Clause& c) { return c.kind == Clause::Kind::Test; });
        if (out.found > 0 && axiom) node(i).is = Node::Is::Given;
        return out;
    }
    void add_way(std::size_t i, Way way) {
        const auto same = [&](const Way& other) {
            return other.rule == way.rule && other.line == way.line &&
                   std::ranges::equal(other.parts, way.parts, [](const Part& a, const Part& b) { return a.text == b.text; });
        };
        if (std::ranges::none_of(node(i).ways, same)) node(i).ways.push_back(std::move(way));
    }

    // ---- how a body is met

    Result<Way> way_of(std::size_t i, const PartialMatch& match, const Explainer::Search& search, const Solution& solution) {
        Way way = e_.way_of(*match.of);
        const Bound bound = bound_by(match);
        const Rule named = e_.named(match, solution.values, bound);
        way.with = e_.with(match, solution.values, looked_at(e_, match, bound, search));
        for (std::size_t c = 0; c < match.own; ++c) {
            const Clause& clause = match.body[c];
            switch (clause.kind) {
                case Clause::Kind::Atom: {
                    const std::size_t age = search.age + e_.age_of(match, clause, search.spread);
                    const std::size_t child = add(read_by(e_, match, clause, *solution.facts[c], age, search), facts_[i].depth + 1);
                    way.parts.push_back({.text = node(child).fact, .node = child});
                    break;
                }
                case Clause::Kind::Not:
                    way.parts.push_back(
                        {.is = Part::Is::Absent, .text = e_.print(named, clause.inner), .tick = oldest_tick(e_, match, clause, search)});
                    break;
                case Clause::Kind::Test:
                    if (says_nothing(e_, named, clause)) break;
                    [[fallthrough]];
                default:
                    way.parts.push_back({.is = Part::Is::Condition, .text = e_.print(named, clause)});
            }
            if (clause.kind != Clause::Kind::Aggregate) continue;
            std::size_t ways = 0;
            const auto one = [&](const Solution& inner) {
                ++ways;
                for (std::size_t n = 0; n < clause.inner.size() && ways <= most_ways(); ++n) {
                    if (inner.facts[n] == nullptr) continue;
                    const std::size_t age = search.age + e_.age_of(match, clause.inner[n], search.spread);
                    const std::size_t child = add(e_.keep(clause.inner[n].atom.predicate, *inner.facts[n], age), facts_[i].depth + 1);
                    way.parts.push_back({.text = node(child).fact, .node = child});
                }
                return true;
            };
            const std::size_t at = way.parts.size() - 1;
            // Its own result is known to the body, and not to its matches.
            if (auto done = e_.search_part(match, clause.inner, solution.values, bound, search, one); !done)
                return tl::unexpected<Error>(done.error());
            way.parts[at].note = fmt::format("of {} match{}", ways, ways == 1 ? "" : "es");
        }
        return way;
    }
    std::size_t most_ways() const { return options_.all ? ~std::size_t{0} : options_.most_ways; }

    // ---- aggregates

    // All that is combined: every derivation of the group, and the facts that are given.
    Result<void> combine(std::size_t i) {
        node(i).is = Node::Is::Combined;
        if (options_.depth != kNoDepth && facts_[i].depth >= options_.depth) return set(i, Node::Is::Further);
        Known group = facts_[i].fact;
        const check::Predicate& p = e_.predicate(group.predicate);
        group.arguments[p.aggregate_at - 1].reset();
        for (const std::string& given : given_to(e_, group)) node(i).ways.push_back({.note = "given: " + given});
        // A settled run has read what is there now.
        const bool spread = !e_.states().settled || group.age > 0;
        for (const Rule* rule : e_.views(group.predicate)) {
            std::optional<PartialMatch> match = e_.match_head(*rule, rule->heads[0].atom, group, false);
            if (!match) continue;
            tell_apart(*match);
            if (const std::string why = e_.cannot(match->body); !why.empty()) {
                node(i).ways.push_back(e_.way_of(*rule));
                node(i).ways.back().note = "this rule cannot be looked up: " + why;
                continue;
            }
            Explainer::Search search{.age = group.age, .spread = spread};
            Result<void> within;
            const auto one = [&](const Solution& solution) {
                const Result<std::optional<bool>> counts = delay_has_passed(e_, *match, search, solution);
                if (!counts) {
                    within = tl::unexpected<Error>(counts.error());
                    return false;
                }
                if (!counts->value_or(true)) return true;
                if (node(i).ways.size() >= most_ways()) {
                    ++node(i).more;
                    return true;
                }
                auto way = way_of(i, *match, search, solution);
                if (!way) {
                    within = tl::unexpected<Error>(way.error());
                    return false;
                }
                way->note = "gives " + check::print(e_.checked(), e_.named(*match, solution.values, bound_by(*match)), rule->heads[0].atom);
                if (!counts->has_value()) way->note += "; whether for long enough is not known";
                node(i).ways.push_back(std::move(*way));
                return true;
            };
            Result<bool> done = e_.search(*match, search, one);
            if (done && !*done && spread && e_.before_the_first()) {
                search.spread = false;
                node(i).note = fmt::format("as of tick {}: what it was computed from may have changed since", node(i).tick);
                done = e_.search(*match, search, one);
            } else if (done && !*done) {
                node(i).note = fmt::format("it rests on facts of earlier ticks; ask in tick {}", node(i).tick);
            }
            if (!done) return tl::unexpected<Error>(done.error());
            if (!within) return within;
        }
        return {};
    }

    Explainer& e_;
    const WhyOptions& options_;
    Explanation out_;
    std::vector<Asked> facts_;  // By node.
    std::map<std::pair<std::string, std::size_t>, std::size_t> numbers_;
    LowerRanks lower_;
};

}  // namespace

namespace {

Result<Explanation> explained(timeline::Timeline& timeline, const std::string& body, const WhyOptions& options,
                              const std::function<Result<Explanation>(Explainer&)>& explain) {
    Explanation out;
    const Result<void> asked = ask_back(timeline, body, [&](Explainer& explainer) -> Result<void> {
        Result<Explanation> found = explain(explainer);
        if (!found) return tl::unexpected<Error>(found.error());
        out = std::move(*found);
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    if (!options.origins) return out;
    if (auto found = find_origins(timeline, out); !found) return tl::unexpected<Error>(found.error());
    return out;
}

}  // namespace

Result<Explanation> why(timeline::Timeline& timeline, const std::string& fact, const WhyOptions& options) {
    return explained(timeline, fact, options, [&](Explainer& explainer) { return Why(explainer, options).run(fact); });
}

Result<Explanation> why_body(timeline::Timeline& timeline, const Witness& witness, const WhyOptions& options) {
    std::string body = witness.body;
    for (const auto& [name, value] : witness.values) body += fmt::format(", {} = {}", name, value);
    return explained(timeline, body, options, [&](Explainer& explainer) {
        return Why(explainer, options).run_body(witness.body, witness.catom, witness.values.size());
    });
}

}  // namespace meld::inspect
