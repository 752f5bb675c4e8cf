#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "runtime/ask/facts/removed_catoms.h"
#include "runtime/ask/why/earlier_states.h"
#include "runtime/ask/why/failure.h"
#include "runtime/ask/why/heads.h"
#include "runtime/ask/why/why.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/module/kernel/lists.h"
#include "runtime/module/kernel/ranks.h"

namespace meld::inspect {

namespace {

// So many facts of one answer are explained: what a rule could take a value from may go on without end, as D - 1 of D + 1 does.
constexpr std::size_t kMostFacts = 10'000;
// Facts of one rule of which it is asked what they wait for, if what is asked about leaves something open.
constexpr std::size_t kMostOffers = 20;

using check::Clause;
using check::Head;
using check::PredicateId;
using check::Rule;
using Node = Explanation::Node;
using Part = Explanation::Part;
using Way = Explanation::Way;

class WhyNot {
  public:
    WhyNot(Explainer& explainer, const WhyOptions& options) : e_(explainer), options_(options) {}

    Result<Explanation> run(const std::string& asked) {
        out_.tick = e_.states().tick;
        out_.asked = asked;
        const Result<Known> fact = e_.asked();
        if (!fact) return tl::unexpected<Error>(fact.error());
        if (e_.asks_more())
            return fail("more is asked than whether one fact holds",
                        "Write it with values, or _ where anything will do: 'dist(@42, 5)'; a query tells what holds besides");
        if (!fact->catom) return fail("the catom is missing", "Say whose fact it is: 'dist(@42, 5)'");
        bool holds = false;
        const Result<void> matched = e_.each_match([&](const Known&) {
            holds = true;
            return false;
        });
        if (!matched) return tl::unexpected<Error>(matched.error());
        if (holds) return std::move(out_);
        out_.roots.push_back(add(*fact, 0));
        for (std::size_t i = 0; i < facts_.size(); ++i)
            if (auto done = explain(i); !done) return tl::unexpected<Error>(done.error());
        return std::move(out_);
    }
    Result<Explanation> run_body(const std::string& asked) {
        out_.tick = e_.states().tick;
        out_.asked = asked;
        const Rule& question = e_.program().question();
        PartialMatch match{.of = &question, .rule = question, .body = question.body, .own = question.body.size(), .open = true};
        match.values.resize(question.variables.count());
        match.bound.resize(question.variables.count());
        Attempt best;
        Way way;
        std::optional<Known> missing;
        bool holds = false;
        const auto further = [&](const Attempt& attempt) { missing = note_attempt(match, attempt, way); };
        const Result<bool> done = e_.search(match, {.best = &best, .further = further}, [&](const Solution&) {
            holds = true;
            return false;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        if (holds) return std::move(out_);
        out_.nodes.push_back({.is = Node::Is::Missing, .fact = asked, .tick = out_.tick});
        facts_.push_back({});
        out_.roots.push_back(0);
        if (missing) way.parts.back().node = add(*missing, 1);
        node(0).ways.push_back(std::move(way));
        for (std::size_t i = 1; i < facts_.size(); ++i)
            if (auto explained = explain(i); !explained) return tl::unexpected<Error>(explained.error());
        return std::move(out_);
    }
    // The catom of the fact that was asked about, if there is none.
    std::optional<u64> absent() const { return absent_; }

  private:
    struct Asked {
        Known fact;
        std::size_t depth;
    };

    std::size_t add(const Known& fact, std::size_t depth) {
        const std::string text = e_.text(fact);
        const auto [known, is_new] = numbers_.try_emplace(text, facts_.size());
        if (!is_new) return known->second;
        out_.nodes.push_back({.is = Node::Is::Missing, .fact = text, .tick = e_.states().tick});
        facts_.push_back({fact, depth});
        return known->second;
    }
    Node& node(std::size_t i) { return out_.nodes[i]; }
    Result<void> note(std::size_t i, std::string text) {
        node(i).note = std::move(text);
        return {};
    }

    Result<void> explain(std::size_t i) {
        if (i >= kMostFacts) return note(i, fmt::format("not followed further: the answer has {} facts", kMostFacts));
        const Known fact = facts_[i].fact;
        const check::Predicate& p = e_.predicate(fact.predicate);
        Facts& now = e_.facts(0);
        if (!now.exists(*fact.catom)) {
            if (i == 0) absent_ = fact.catom;
            return note(i, fmt::format("there is no catom @{}", *fact.catom));
        }
        if (p.world != WorldSource::None) return not_sensed(i);
        if (p.sensed) return note(i, "it is not sensed");
        if (const std::optional<Instead> other = instead_of(fact)) {
            node(i).note = other->text;
            if (other->for_good) return {};
        }
        const std::vector<const Rule*> views = e_.views(fact.predicate), linear_rules = e_.linear_rules(fact.predicate);
        if (views.empty() && linear_rules.empty()) return note(i, "it was never given, and no rule derives it");
        if (options_.depth != 0 && facts_[i].depth >= options_.depth) {
            node(i).note += (node(i).note.empty() ? "" : "; ") + std::string("ask about it for more");
            return {};
        }
        for (const Rule* rule : views)
            if (auto done = by_rule(i, *rule, rule->heads[0].atom, {}, fact); !done) return done;
        for (const Rule* rule : linear_rules)
            if (auto done = by_heads(i, *rule); !done) return done;
        if (e_.base_of(fact.predicate)) node(i).ways.push_back({.note = "and it was not given"});
        return {};
    }

    Result<void> not_sensed(std::size_t i) {
        const Known& fact = facts_[i].fact;
        if (!meld::is_link(e_.predicate(fact.predicate).world) || !fact.arguments[0]) return note(i, "it is not sensed");
        const u64 to = fact.arguments[0]->catom;
        if (!e_.facts(0).exists(to)) return note(i, fmt::format("there is no catom @{}", to));
        std::vector<i64> ports;
        e_.facts(0).at(e_.program().source(fact.predicate), *fact.catom, [&](const Fact& f) {
            if (f.arguments[0].catom == to && fact.arguments.size() > 1) ports.push_back(f.arguments[1].integer);
            return true;
        });
        if (!ports.empty()) return note(i, fmt::format("@{} touches @{} at port {}", *fact.catom, to, fmt::join(ports, ", ")));
        return note(i, fmt::format("@{} and @{} do not touch", *fact.catom, to));
    }

    // Another value of a fact's group that holds; for good: the fact could not replace it.
    struct Instead {
        std::string text;
        bool for_good;
    };
    std::optional<Instead> instead_of(const Known& fact) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        if (p.aggregate == check::Aggregate::None) return std::nullopt;
        const std::size_t at = p.aggregate_at - 1;
        std::optional<Known> held;
        e_.facts(0).at(e_.program().source(fact.predicate), *fact.catom, [&](const Fact& f) {
            bool same = true;
            for (std::size_t a = 0; a < at; ++a)
                same = same && fact.arguments[a] && e_.terms().equal(p.arguments[a + 1].type, f.arguments[a], *fact.arguments[a]);
            if (same) held = e_.keep(fact.predicate, f, 0);
            return !same;
        });
        if (!held) return std::nullopt;
        const std::string text = e_.text(*held);
        const std::string word = check::aggregate_name(e_.checked(), p);
        if (syntax::combines(p.aggregate))
            return Instead{fmt::format("{} holds: its {} is of all that there is, as why tells", text, word), true};
        if (!syntax::keeps_best(p.aggregate) || !fact.arguments[at])
            return Instead{fmt::format("{} holds, and there is one value", text), true};
        const int order = tuple::compare(e_.terms().types.of(p.arguments[at + 1].type), *held->arguments[at], *fact.arguments[at]);
        if (syntax::keeps_least(p.aggregate) ? order <= 0 : order >= 0)
            return Instead{fmt::format("{} holds, and {} keeps it", text, word), true};
        return Instead{fmt::format("{} holds", text), false};
    }
    // The fact with the group that this way to satisfy a body gives it.
    Known in_its_group(const Known& fact, const check::Atom& head, const Solution& solution, const Bound& bound) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        Known out = fact;
        Values values = solution.values;
        const std::size_t end = p.aggregate == check::Aggregate::None ? p.arguments.size() : p.aggregate_at + 1;
        for (std::size_t a = 1; a < end; ++a) {
            if (out.arguments[a - 1] || !all_bound(head.arguments[a], bound) || !cannot(e_.checked(), head.arguments[a]).empty()) continue;
            const Value v = e_.terms().value_as(head.arguments[a], p.arguments[a].type, values);
            if (e_.terms().scratch.went_well()) out.arguments[a - 1] = e_.keep(p.arguments[a].type, v);
        }
        return out;
    }

    // ---- rules

    Result<void> by_heads(std::size_t i, const Rule& rule) {
        Result<void> outcome;
        each_head_within(rule, [&](const HeadWithin& at) {
            if (!outcome || at.head.kind != Head::Kind::Fact || at.head.atom.predicate != facts_[i].fact.predicate) return;
            outcome = by_rule(i, rule, at.head.atom, at.around, facts_[i].fact, at.of_results);
        });
        return outcome;
    }

    Result<void> by_rule(std::size_t i, const Rule& rule, const check::Atom& head, const std::vector<Clause>& more, const Known& fact,
                         bool of_results = false) {
        Way way = e_.way_of(rule);
        std::optional<PartialMatch> match = e_.match_head(rule, head, fact, true, more);
        const std::string cannot = match ? e_.cannot(match->body) : "";
        if (!match || !cannot.empty()) {
            way.note = match ? "it cannot be looked up: " + cannot : "its head is never this fact";
            node(i).ways.push_back(std::move(way));
            return {};
        }
        Attempt best;
        std::optional<Known> missing;
        const auto further = [&](const Attempt& attempt) { missing = note_attempt(*match, attempt, way); };
        Offers offers;
        Result<bool> done = offered(fact, head, *match, {.best = &best, .further = further}, offers);
        if (!done) return tl::unexpected<Error>(done.error());
        if (missing) way.parts.back().node = add(*missing, facts_[i].depth + 1);
        if (!offers.facts.empty()) {
            if (!rule.linear) done = offered(fact, head, *match, {.spread = true}, offers);
            if (!done) return tl::unexpected<Error>(done.error());
            Result<std::string> yet = met_and_yet(rule, head, offers, of_results);
            if (!yet) return tl::unexpected<Error>(yet.error());
            way.note = std::move(*yet);
        } else if (!offers.instead.empty()) {
            way.note = "its body is met, and " + offers.instead;
        } else if (rule.linear && best.failed == nullptr) {
            way.note = "its body is met by one fact twice, and what a rule consumes, no other part of its body matches";
        }
        node(i).ways.push_back(std::move(way));
        return {};
    }
    // What a rule gives, where something is left open; or what holds instead of all of it.
    struct Offers {
        std::map<std::string, Known> facts = {};
        std::string instead = {};
    };
    Result<bool> offered(const Known& fact, const check::Atom& head, const PartialMatch& match, const Explainer::Search& search,
                         Offers& out) {
        const Bound bound = bound_by(match);
        return e_.search(match, search, [&](const Solution& solution) {
            Known one = fact.whole() ? fact : in_its_group(fact, head, solution, bound);
            const std::optional<Instead> other = fact.whole() ? std::nullopt : instead_of(one);
            if (other && other->for_good)
                out.instead = other->text;
            else if (out.facts.size() < kMostOffers)
                out.facts.try_emplace(e_.text(one), one);
            return true;
        });
    }

    // The parts that can be met together, and the one that then cannot; the fact that is not there, if it is that.
    std::optional<Known> note_attempt(const PartialMatch& match, const Attempt& attempt, Way& way) {
        way.parts.clear();
        way.with = e_.with(match, attempt.values, attempt.bound);
        const Rule named = e_.named(match, attempt.values, attempt.bound);
        const auto own = [&](const Clause* c) { return static_cast<std::size_t>(c - match.body.data()) < match.own; };
        for (const Clause* c : attempt.met) {
            if (c == attempt.failed || !own(c) || (c->kind != Clause::Kind::Atom && c->kind != Clause::Kind::Not)) continue;
            const bool absent = c->kind == Clause::Kind::Not;
            way.parts.push_back(
                {.is = absent ? Part::Is::Absent : Part::Is::Fact, .text = absent ? e_.print(named, c->inner) : e_.print(named, *c)});
        }
        if (attempt.failed == nullptr) return std::nullopt;
        const Clause& c = *attempt.failed;
        Part part{.is = Part::Is::Fails, .text = e_.print(named, c)};
        Values values = attempt.values;
        std::optional<Known> missing;
        if (c.kind == Clause::Kind::Atom) {
            missing = missing_fact(e_, c.atom, attempt.bound, values);
        } else if (c.kind == Clause::Kind::Not) {
            Failure found = failure_of_absence(e_, match, c.inner, values, attempt.bound);
            part.note = std::move(found.note);
            missing = std::move(found.missing);
        }
        way.parts.push_back(std::move(part));
        return missing;
    }

    // ---- a body that is met, and the fact is not there

    Result<std::string> met_and_yet(const Rule& rule, const check::Atom& head, const Offers& offers, bool of_results) {
        if (of_results) return "its body is met; results of aggregates in its head were not checked";
        if (rule.initial_fact) return "it is given once, in the first tick";
        if (rule.linear) return "its body is met, and it fires in the next tick, if no other rule takes its facts";
        for (const auto& [text, fact] : offers.facts) {
            const Result<std::set<u64>> silent = silent_neighbours(fact);
            if (!silent) return tl::unexpected<Error>(silent.error());
            if (!silent->empty()) return fmt::format("its body is met, and it waits for what comes from @{}", fmt::join(*silent, ", @"));
        }
        if (!rule.heads.empty() && rule.heads[0].delay.op != check::Op::Anonymous) return "its body is met, but not for long enough yet";
        for (const auto& [text, fact] : offers.facts) {
            Result<std::string> quarantine = quarantine_of(rule, head, fact);
            if (!quarantine || !quarantine->empty()) return quarantine;
        }
        for (const auto& [text, fact] : offers.facts) {
            Result<std::string> group = group_in_quarantine(rule, head, fact);
            if (!group || !group->empty()) return group;
        }
        return "its body is met now, and was not when the catom read it; it is read again in the next tick";
    }
    // That there is a value may be in quarantine while there is one, since the run keeps these apart. Empty: the body asks of nothing that,
    // or was not met when it was read.
    Result<std::string> group_in_quarantine(const Rule& rule, const check::Atom& head, const Known& fact) {
        const check::Stratum* const recursion = e_.recursion_of(fact.predicate);
        const std::optional<PartialMatch> match = recursion != nullptr ? e_.match_head(rule, head, fact, true) : std::nullopt;
        if (!match) return "";
        std::string group;
        const Result<bool> done = e_.search(*match, {.spread = true}, [&](const Solution& solution) {
            const Rule named = e_.named(*match, solution.values, bound_by(*match));
            for (std::size_t c = 0; c < match->own && group.empty(); ++c)
                if (match->body[c].kind == Clause::Kind::Atom && e_.asks_existence(*match, match->body[c], recursion))
                    group = e_.print(named, match->body[c]);
            return false;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        if (group.empty()) return "";
        return fmt::format("its body is met, and that there is {} is still in quarantine, whatever its value", group);
    }
    // Empty: it is in none.
    Result<std::string> quarantine_of(const Rule& rule, const check::Atom& head, const Known& fact) {
        const std::optional<Tombstone> lost = loss_of(fact);
        const std::optional<PartialMatch> match = lost ? e_.match_head(rule, head, fact, true) : std::nullopt;
        if (!match) return "";
        // What the catom has read may have come of other facts than there are now, with other ranks.
        bool read = false;
        for (const bool spread : {false, true}) {
            const auto rank = least_rank(fact, *match, {.spread = spread, .recursion = e_.recursion_of(fact.predicate)});
            if (!rank) return tl::unexpected<Error>(rank.error());
            const i64 ready = *rank ? trusted_from(&*lost, **rank, e_.states().latency) : 0;
            if (ready > e_.states().tick)
                return fmt::format("its body is met, and in quarantine until tick {}: rank {} against a loss of rank {} in tick {}", ready,
                                   **rank, lost->least_rank, lost->time);
            read = rank->has_value();
        }
        // The run may keep apart that there is a value beyond a bound, with ranks that are not known here.
        if (read)
            return fmt::format("its body is met, and still in quarantine after a loss of rank {} in tick {}", lost->least_rank, lost->time);
        return "";
    }

    // The rank that the fact would have by the body; nothing: it is not met.
    Result<std::optional<u32>> least_rank(const Known& fact, const PartialMatch& match, const Explainer::Search& search) {
        std::optional<u32> least;
        const Result<bool> done = e_.search(match, search, [&](const Solution& solution) {
            const u32 rank = rank_of(fact, match, solution);
            if (!least || rank < *least) least = rank;
            return true;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        return least;
    }
    u32 rank_of(const Known& head, const PartialMatch& match, const Solution& solution) const {
        const check::Stratum* const recursion = e_.recursion_of(head.predicate);
        u32 rank = 0;
        for (std::size_t c = 0; c < match.own && recursion != nullptr; ++c) {
            const Fact* const f = c < solution.facts.size() ? solution.facts[c] : nullptr;
            if (f != nullptr && f->rank != kAbsent && recursion->contains(match.body[c].atom.predicate)) rank = std::max(rank, f->rank);
        }
        return rank + 1;
    }

    // A group may need what all neighbours over a link contribute: those of which it has read nothing.
    Result<std::set<u64>> silent_neighbours(const Known& fact) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        std::set<u64> silent;
        if (!p.complete_link.valid()) return silent;
        e_.facts(0).each(e_.program().source(p.complete_link), [&](const Fact& link) {
            const u64 from = link.catom, to = link.arguments[0].catom;
            if ((p.complete_outgoing ? from : to) == *fact.catom) silent.insert(p.complete_outgoing ? to : from);
            return true;
        });
        Known group = fact;
        for (std::size_t a = p.aggregate_at - 1; a < group.arguments.size(); ++a) group.arguments[a].reset();
        for (const Rule* rule : e_.views(fact.predicate)) {
            const std::optional<PartialMatch> match = e_.match_head(*rule, rule->heads[0].atom, group, false);
            if (!match || !e_.cannot(match->body).empty()) continue;
            const Result<bool> done = e_.search(*match, {.spread = true}, [&](const Solution& solution) {
                for (const check::VariableId v : rule->contributors) silent.erase(solution.values[v.index()].catom);
                return true;
            });
            if (!done) return tl::unexpected<Error>(done.error());
        }
        return silent;
    }

    std::optional<Tombstone> loss_of(const Known& fact) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        u64 group = kGroupHash;
        const std::size_t end = p.aggregate == check::Aggregate::None ? p.arguments.size() : p.aggregate_at;
        for (std::size_t a = 1; a < end; ++a) {
            if (!fact.arguments[a - 1]) return std::nullopt;
            const check::Type& type = p.arguments[a].type;
            const Value v = *fact.arguments[a - 1];
            group = mix(group, type.compound() ? hash_list(e_.terms().types.table(), e_.terms().types.number(type), v.list) : v.catom);
        }
        return e_.facts(0).loss(e_.ranked_source(fact.predicate), *fact.catom, group);
    }

    Explainer& e_;
    const WhyOptions& options_;
    Explanation out_;
    std::optional<u64> absent_;
    std::vector<Asked> facts_;  // By node.
    std::map<std::string, std::size_t> numbers_;
};

}  // namespace

Result<Explanation> why_not(timeline::Timeline& timeline, const std::string& fact, const WhyOptions& options) {
    Explanation out;
    std::optional<u64> absent;
    const Result<void> asked = ask_back(timeline, fact, [&](Explainer& explainer) -> Result<void> {
        WhyNot question(explainer, options);
        Result<Explanation> found = question.run(fact);
        if (!found) return tl::unexpected<Error>(found.error());
        out = std::move(*found);
        absent = question.absent();
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    // Process 0 alone has run the question.
    const std::optional<u64> first = comm::value_of_first(timeline.simulation().subdomain().comm, absent);
    if (!first) return out;
    const Result<std::string> when = when_removed(timeline, *first);
    if (!when) return tl::unexpected<Error>(when.error());
    if (absent && !when->empty()) out.nodes[out.roots.front()].note += ": " + *when;
    return out;
}

Result<Explanation> why_not_body(timeline::Timeline& timeline, const std::string& body, const WhyOptions& options) {
    Explanation out;
    const Result<void> asked = ask_back(timeline, body, [&](Explainer& explainer) -> Result<void> {
        Result<Explanation> found = WhyNot(explainer, options).run_body(body);
        if (!found) return tl::unexpected<Error>(found.error());
        out = std::move(*found);
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    return out;
}

}  // namespace meld::inspect
