#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>

#include "tests/reference/answers/judge.h"
#include "tests/reference/answers/judge_way.h"
#include "tests/reference/evaluator/model.h"

namespace meld::reference {

using check::Clause;
using check::Op;
using check::Predicate;
using check::Rule;
using Node = Answer::Node;
using Part = Answer::Part;
using Way = Answer::Way;

namespace {

constexpr const char* kReplaced = "a value that a better one has replaced, and on which others still rest";
// So many ticks back is looked.
constexpr std::int64_t kLooksBack = 15;

class WhyJudge {
  public:
    WhyJudge(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged)
        : past_(past),
          program_(past.program()),
          bodies_(past),
          answer_(answer),
          asked_(asked),
          judged_(judged),
          ways_(past, answer, asked, judged, facts_) {}

    std::string run() {
        if (answer_.tick != asked_.tick) return fmt::format("it is of tick {}", answer_.tick);
        if (answer_.roots.empty()) return "nothing is explained";
        const std::optional<Pattern> wanted = parse_fact(program_, asked_.fact);
        if (!wanted) return "the fact cannot be read";
        for (const Node& node : answer_.nodes) {
            const std::optional<Pattern> fact = parse_fact(program_, node.fact);
            if (!fact) return fmt::format("{} is no fact", node.fact);
            facts_.push_back(*fact);
        }
        for (const std::size_t root : answer_.roots)
            if (root >= facts_.size() || !facts_[root].whole() || !fits_question(*wanted, root)) return "it explains another fact";
        for (std::size_t i = 0; i < answer_.nodes.size() && trouble_.empty(); ++i)
            if (!node(i)) trouble_ = fmt::format("{}, in tick {}: {}", answer_.nodes[i].fact, answer_.nodes[i].tick, why_);
        if (trouble_.empty() && !ends()) trouble_ = why_;
        return trouble_;
    }

  private:
    bool fits_question(const Pattern& wanted, std::size_t root) const {
        return facts_[root].predicate == wanted.predicate && wanted.fits(facts_[root].row()) && answer_.nodes[root].tick == asked_.tick;
    }
    bool fails(std::string why) {
        why_ = std::move(why);
        return false;
    }
    std::optional<HeadOf> head_of(const Way& w, PredicateId p) {
        auto out = ways_.head_of(w, p);
        if (!out) why_ = ways_.why();
        return out;
    }
    bool way(std::size_t i, const Way& w, const Pattern& fact) { return ways_.so(i, w, fact) || fails(ways_.why()); }

    // ---- one fact

    bool node(std::size_t i) {
        const Node& n = answer_.nodes[i];
        const Pattern& fact = facts_[i];
        const Predicate& p = program_.predicates[fact.predicate];
        ++judged_.nodes;
        if (!past_.has(n.tick) || n.tick > answer_.tick) return fails("there is no such tick");
        const Moment& now = past_.at(n.tick);
        const bool replaced = says(n.note, kReplaced);
        const bool there = Past::any(now.facts, fact);
        const bool in_front = Past::any(now.fronts, fact), at_rest = past_.quiet() && n.tick == past_.last();
        if (without_value(n, fact) ? there || at_rest : replaced ? there || !in_front : !there) return fails("it does not hold");
        if (p.world != check::WorldSource::None || p.sensed) return (n.is == "sensed" && n.ways.empty()) || fails("it is sensed");
        if (n.is == "made") return made(i);
        if (n.is == "combined") return combined(i);
        if (n.is == "given") return given(i);
        if (n.is == "derived") return derived(i);
        if (n.is == "unknown") return unknown(i);
        if (n.is == "further") return further(i);
        return fails(fmt::format("'{}' is nothing that it can be", n.is));
    }

    bool given(std::size_t i) {
        const Node& n = answer_.nodes[i];
        if (n.ways.empty()) return Past::any(past_.at(n.tick).given, facts_[i]) || axiom(i) || fails("nobody has given it");
        // By the text: a rule that reads no facts.
        const auto of_text = [](const Way& way) {
            return std::ranges::all_of(way.parts, [](const Part& part) { return part.is == "condition"; });
        };
        if (std::ranges::none_of(n.ways, of_text) && !Past::any(past_.at(n.tick).given, facts_[i])) return fails("its rules read facts");
        return ways(i);
    }
    // Where facts are not followed further, those that are in the text are not explained either.
    bool axiom(std::size_t i) const {
        return asked_.depth > 0 && std::ranges::any_of(heads_of(program_, facts_[i].predicate, RuleKind::View),
                                                       [](const HeadOf& h) { return h.clauses.empty(); });
    }
    bool derived(std::size_t i) {
        if (answer_.nodes[i].ways.empty()) return fails("it has no way in which it was derived");
        return ways(i) && beaten(i);
    }
    bool unknown(std::size_t i) {
        ++judged_.unknown;
        const std::vector<HeadOf> heads = heads_of(program_, facts_[i].predicate, RuleKind::View);
        const bool hidden = std::ranges::any_of(heads, [](const HeadOf& h) { return beyond_states(h.clauses); });
        // What linear rules of others make is there at the end of a tick, and is read in the next.
        bool arrives = false;
        for (const HeadOf& h : heads)
            check::each_atom(h.clauses, [&](const check::Atom& a, bool) {
                arrives = arrives || !heads_of(program_, a.predicate, RuleKind::Linear).empty();
            });
        return hidden || (arrives && says(answer_.nodes[i].note, "has changed since")) ||
               fails("it is explained by nothing: " + answer_.nodes[i].note);
    }
    bool further(std::size_t i) {
        if (says(answer_.nodes[i].note, "it rests on facts of earlier ticks"))
            return answer_.tick - answer_.nodes[i].tick >= kLooksBack - 3 || fails("it could be followed further");
        return asked_.depth > 0 || fails("it is not followed to the end");
    }
    bool ways(std::size_t i) {
        for (const Way& w : answer_.nodes[i].ways)
            if (!way(i, w, facts_[i])) return false;
        return true;
    }

    // ---- values that lost, and values that go in

    static bool better(const Predicate& p, const Value& a, const Value& b) {
        return keeps_least(p.aggregate) ? a < b : keeps_greatest(p.aggregate) && a > b;
    }
    bool same_group(const Predicate& p, const Row& a, const Row& b) const {
        return std::equal(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(p.aggregate_at), b.begin());
    }

    // Each of the others could hold by the rule and the facts that are named, and is not better. At rest nothing is better.
    bool beaten(std::size_t i) {
        const Node& n = answer_.nodes[i];
        const Predicate& p = program_.predicates[facts_[i].predicate];
        for (const std::string& other : n.others)
            if (!says(other, " more value") && !loser(i, other)) return false;
        if (!keeps_best(p.aggregate) || !facts_[i].whole() || says(n.note, kReplaced)) return true;
        if (!past_.quiet() || n.tick != past_.last()) return true;
        const Row own = facts_[i].row();
        bool best = true;
        for (const HeadOf& h : heads_of(program_, facts_[i].predicate, RuleKind::View)) {
            if (h.head->delay.op != Op::Anonymous || beyond_states(h.clauses)) continue;
            ways_.each_derivation(h, own[0].integer(), {n.tick, false}, [&](const Row& row, const Environment&) {
                best = best && (!same_group(p, row, own) || !better(p, row[p.aggregate_at], own[p.aggregate_at]));
            });
        }
        return best || fails("a rule gives a better value");
    }
    bool loser(std::size_t i, const std::string& other) {
        std::string_view rest = other;
        const std::optional<Pattern> fact = take_fact(program_, rest);
        if (!fact || !fact->whole() || fact->predicate != facts_[i].predicate) return fails("no other value: " + other);
        const Predicate& p = program_.predicates[fact->predicate];
        const Row row = fact->row(), own = facts_[i].row();
        if (!same_group(p, row, own) || row == own) return fails("a value of another group has lost: " + other);
        if (better(p, row[p.aggregate_at], own[p.aggregate_at])) return fails("a better value has lost: " + other);
        for (const HeadOf& h : heads_of(program_, fact->predicate, RuleKind::View))
            for (const bool spread : {false, true}) {
                bool found = false;
                const When when{answer_.nodes[i].tick, spread};
                ways_.each_derivation(h, row[0].integer(), when, [&](const Row& made, const Environment& env) {
                    found = found || (made == row && rest == fmt::format(": {}:{} with {}", h.rule->file, h.rule->line,
                                                                         bodies_.print(*h.rule, env, h.clauses)));
                });
                if (found) return true;
            }
        return fails("no rule gives what has lost: " + other);
    }

    // A sum, count or the like: all that goes in, and that it is the sum of it.
    bool combined(std::size_t i) {
        const Node& n = answer_.nodes[i];
        const Predicate& p = program_.predicates[facts_[i].predicate];
        ++judged_.combined;
        if (!combines(p.aggregate)) return fails("it is not combined of anything");
        if (says(n.note, "it rests on facts of earlier ticks")) return further(i);
        const Row own = facts_[i].row();
        std::vector<Derived> all;
        std::set<Row> given;
        for (const Row& row : past_.at(n.tick).given[facts_[i].predicate.index()])
            if (same_group(p, row, own)) given.insert(row);
        for (const Row& row : given) all.push_back({row});
        bool hidden = false;
        for (const HeadOf& h : heads_of(program_, facts_[i].predicate, RuleKind::View)) {
            // Nothing but the run knows what goes in.
            hidden = hidden || beyond_states(h.clauses);
            ways_.each_counted(h, own[0].integer(), {n.tick, true}, [&](const Row& row, const Environment& env) {
                if (!same_group(p, row, own)) return;
                Derived& one = all.emplace_back(Derived{.row = row});
                for (const check::VariableId v : h.rule->contributors) one.from.insert(env[v.index()]->integer());
            });
        }
        const bool makers = !heads_of(program_, facts_[i].predicate, RuleKind::Linear).empty();
        std::size_t ways = 0;
        Pattern group = facts_[i];
        for (const Way& w : n.ways) {
            if (!w.has_rule()) {
                std::string_view said = w.note;
                if (!said.starts_with("given: ")) return fails("it is said of a way: " + w.note);
                said.remove_prefix(7);
                const std::optional<Pattern> fact = parse_fact(program_, said);
                if (!fact || !fact->whole() || !same_group(p, fact->row(), own) || (!makers && !given.contains(fact->row())))
                    return fails("nobody has given " + std::string(said));
                if (!given.contains(fact->row())) all.push_back({fact->row()});
            } else {
                group.arguments[p.aggregate_at].reset();
                if (says(w.note, "this rule cannot be looked up") ? !hidden || !head_of(w, group.predicate) : !way(i, w, group))
                    return false;
            }
            ++ways;
        }
        if (hidden) {
            ++judged_.unknown;
            return true;
        }
        if (ways + n.more != all.size()) return fails(fmt::format("{} go in, and {} are said to be", all.size(), ways + n.more));
        if (n.more > 0 && (asked_.all || ways < kShown)) return fails(fmt::format("only {} are shown", ways));
        Rows sum;
        static_cast<void>(reduce(past_.at(n.tick).scene, past_.at(n.tick).facts, p, all, nullptr, sum));
        return sum.contains(own) || fails("it is not what they come to");
    }
    // ---- what linear rules make

    bool made(std::size_t i) {
        const Node& n = answer_.nodes[i];
        const Pattern& fact = facts_[i];
        ++judged_.made;
        const std::vector<HeadOf> makers = heads_of(program_, fact.predicate, RuleKind::Linear);
        const bool is_given = given_by_somebody(fact);
        if (makers.empty() && !is_given) return fails("no linear rule makes it, and nobody gives it");
        if (n.note.empty()) return n.ways.empty() || fails("it does not say in which tick it was made");
        if (says(n.note, "there from the start"))
            return past_.holds(0, fact.predicate, fact.row()) || fails("it was not there at the start");
        const std::optional<std::int64_t> tick = number_after(n.note, "made in tick ");
        if (!tick || !past_.has(*tick) || *tick < 1 || *tick > n.tick) return fails("it was made in no tick: " + n.note);
        if (past_.holds(*tick - 1, fact.predicate, fact.row())) return fails(fmt::format("it was there before tick {}", *tick));
        for (std::int64_t t = *tick; t <= n.tick; ++t)
            if (!past_.holds(t, fact.predicate, fact.row())) return fails(fmt::format("it was not there in tick {}", t));
        for (std::size_t w = 0; w < n.ways.size(); ++w) {
            if (!maker(n.ways[w], makers, fact, *tick)) return false;
            for (std::size_t before = 0; before < w; ++before)
                if (same(n.ways[before], n.ways[w])) return fails("one way is said twice");
        }
        return true;
    }
    bool given_by_somebody(const Pattern& fact) const {
        return std::ranges::any_of(past_.given_ever()[fact.predicate.index()], [&](const Row& row) { return fact.fits(row); });
    }
    static bool same(const Way& a, const Way& b) {
        return a.text == b.text && a.file == b.file && a.line == b.line && a.catom == b.catom &&
               std::ranges::equal(a.parts, b.parts, [](const Part& p, const Part& q) { return p.text == q.text && p.tick == q.tick; });
    }
    bool maker(const Way& w, const std::vector<HeadOf>& makers, const Pattern& fact, std::int64_t tick) {
        ++judged_.ways;
        for (const HeadOf& h : makers) {
            if (h.rule->name != w.rule || h.rule->text != w.text || h.rule->file != w.file || h.rule->line != w.line) continue;
            const auto ages = Bodies::ages(program_, *h.rule, h.clauses);
            std::map<const check::Atom*, Rows> named;
            std::size_t next = 0;
            bool fits = true;
            for (const Clause& c : h.clauses) {
                if (c.kind != Clause::Kind::Atom || !fits) continue;
                fits = next < w.parts.size();
                if (!fits) continue;
                const Part& part = w.parts[next++];
                const std::optional<Pattern> row = parse_fact(program_, part.text);
                // What is given in a tick is there for the rules of that tick.
                fits = row && row->whole() && row->predicate == c.atom.predicate && (part.tick == tick - 1 || part.tick == tick) &&
                       past_.holds(*part.tick, row->predicate, row->row());
                if (fits) named[&c.atom] = {row->row()};
            }
            if (!fits || next != w.parts.size()) continue;
            for (const std::int64_t seen : {tick - 1, tick})
                if (bodies_.solve({*h.rule, h.clauses, ages, {seen, false}, Environment(h.rule->variables.count()), named},
                                  [&](const Environment& env) { return may_give(h, env, fact); }))
                    return true;
        }
        return fails("no linear rule makes it of what is named: " + w.text);
    }
    // What of the head has a value agrees with the fact; results of aggregates around it have none.
    bool may_give(const HeadOf& h, const Environment& env, const Pattern& fact) const {
        const check::Atom& atom = h.head->atom;
        for (std::size_t a = 0; a < atom.arguments.size(); ++a) {
            if (!all_bound(atom.arguments[a], env) || beyond_states(atom.arguments[a])) continue;
            const std::optional<Value> is = evaluate(past_.at(answer_.tick).scene, atom.arguments[a], env);
            if (!is || *is != *fact.arguments[a]) return false;
        }
        return true;
    }

    // ---- all of them

    // Whatever a fact rests on, there is an end to it; and every fact is part of the answer to what was asked.
    bool ends() {
        enum class Seen { No, Open, Done };
        std::vector<Seen> seen(answer_.nodes.size(), Seen::No);
        bool circle = false, some_unranked = false;
        const std::function<void(std::size_t)> follow = [&](std::size_t i) {
            seen[i] = Seen::Open;
            for (const Way& w : answer_.nodes[i].ways)
                for (const Part& part : w.parts) {
                    if (!part.node) continue;
                    circle = circle || seen[*part.node] == Seen::Open;
                    if (seen[*part.node] == Seen::No) follow(*part.node);
                }
            seen[i] = Seen::Done;
        };
        for (const std::size_t root : answer_.roots)
            if (seen[root] == Seen::No) follow(root);
        for (const Node& n : answer_.nodes)
            if (unranked(n)) {
                some_unranked = true;
                ++judged_.unranked;
            }
        if (circle && !some_unranked) return fails("a fact rests on itself");
        return std::ranges::count(seen, Seen::No) == 0 || fails("a fact has nothing to do with what was asked");
    }

    const Past& past_;
    const check::Program& program_;
    const Bodies bodies_;
    const Answer& answer_;
    const AskedFor& asked_;
    Judged& judged_;
    std::vector<Pattern> facts_;  // Of the nodes.
    WayJudge ways_;
    std::string why_, trouble_;
};

}  // namespace

void Judged::add(const Judged& other) {
    nodes += other.nodes;
    ways += other.ways;
    parts += other.parts;
    unranked += other.unranked;
    unknown += other.unknown;
    combined += other.combined;
    made += other.made;
    quarantines += other.quarantines;
}

std::string judge_why(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged) {
    return WhyJudge(past, answer, asked, judged).run();
}

}  // namespace meld::reference
