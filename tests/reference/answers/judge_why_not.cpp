#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "tests/reference/answers/judge.h"
#include "tests/reference/answers/judge_yet.h"
#include "tests/reference/evaluator/model.h"

namespace meld::reference {

using check::Clause;
using check::Op;
using check::Predicate;
using check::Rule;
using check::Term;
using Node = Answer::Node;
using Part = Answer::Part;
using Way = Answer::Way;

namespace {

// Whether a text is this one, where variables that the program does not name may stand for anything.
bool reads(std::string_view text, std::string_view as) {
    for (std::size_t at = 0; at < as.size(); ++at) {
        const bool open = as[at] == '_' && (at == 0 || as[at - 1] == ' ' || as[at - 1] == '(');
        if (!open) {
            if (text.empty() || text.front() != as[at]) return false;
            text.remove_prefix(1);
            continue;
        }
        std::size_t end = at + 1;
        while (end < as.size() && (std::isalnum(static_cast<unsigned char>(as[end])) || as[end] == '_')) ++end;
        for (std::size_t skipped = 1; skipped <= text.size(); ++skipped)
            if (reads(text.substr(skipped), as.substr(end))) return true;
        return false;
    }
    return text.empty();
}

class WhyNotJudge {
  public:
    WhyNotJudge(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged)
        : past_(past),
          program_(past.program()),
          bodies_(past),
          answer_(answer),
          asked_(asked),
          judged_(judged),
          yet_(past, asked.tick, judged) {}

    std::string run() {
        if (answer_.tick != asked_.tick || !past_.has(asked_.tick)) return fmt::format("it is of tick {}", answer_.tick);
        if (answer_.roots != std::vector<std::size_t>{0}) return "it is not explained";
        if (answer_.nodes.at(0).fact != asked_.fact) return "it explains " + answer_.nodes[0].fact;
        std::vector<bool> named(answer_.nodes.size(), false);
        named[0] = true;
        for (const Node& n : answer_.nodes) {
            const std::optional<Pattern> fact = parse_fact(program_, n.fact);
            if (!fact || !fact->arguments[0]) return n.fact + " is no fact";
            facts_.push_back(*fact);
            for (const Way& w : n.ways)
                for (const Part& part : w.parts)
                    if (part.node && *part.node < named.size()) named[*part.node] = true;
        }
        if (std::ranges::count(named, false) > 0) return "a fact has nothing to do with what was asked";
        for (std::size_t i = 0; i < answer_.nodes.size(); ++i)
            if (!node(i)) return fmt::format("{}: {}", answer_.nodes[i].fact, why_);
        return "";
    }

  private:
    const Moment& now() const { return past_.at(asked_.tick); }
    bool fails(std::string why) {
        why_ = std::move(why);
        return false;
    }

    // ---- one fact that does not hold

    bool node(std::size_t i) {
        const Node& n = answer_.nodes[i];
        const Pattern& fact = facts_[i];
        const Predicate& p = program_.predicates[fact.predicate];
        ++judged_.nodes;
        if (n.is != "missing" || n.tick != asked_.tick) return fails("it is not said to be missing");
        if (Past::any(now().facts, fact)) return fails("it holds");
        if (const auto most = number_after(n.note, "not followed further: the answer has "))
            return answer_.nodes.size() >= static_cast<std::size_t>(*most) || fails("it could be followed further");
        if (!exists(fact.arguments[0])) return ends_with(n, fmt::format("there is no catom @{}", fact.arguments[0]->integer()));
        if (p.world != check::WorldSource::None) return not_sensed(n, fact, p);
        if (p.sensed) return ends_with(n, "it is not sensed");
        bool open = false;
        if (!instead(n, fact, p, open)) return false;
        if (!open) return true;
        return heads(i);
    }
    bool exists(const std::optional<Value>& catom) const { return now().scene.links.contains(catom->integer()); }
    // It is not explained any further than by this.
    bool ends_with(const Node& n, const std::string& note) {
        if (n.note != note) return fails(fmt::format("'{}' is said instead of '{}'", n.note, note));
        return n.ways.empty() || fails("it is explained further");
    }
    bool not_sensed(const Node& n, const Pattern& fact, const Predicate& p) {
        if (p.world != check::WorldSource::Neighbor && p.world != check::WorldSource::NeighborPort) return ends_with(n, "it is not sensed");
        if (!fact.arguments[1]) return ends_with(n, "it is not sensed");
        const std::int64_t at = fact.arguments[0]->integer(), to = fact.arguments[1]->integer();
        if (!exists(fact.arguments[1])) return ends_with(n, fmt::format("there is no catom @{}", to));
        const std::vector<Link>& links = now().scene.links.at(at);
        const auto link = std::ranges::find(links, to, &Link::other);
        if (link == links.end()) return ends_with(n, fmt::format("@{} and @{} do not touch", at, to));
        return ends_with(n, fmt::format("@{} touches @{} at port {}", at, to, link->port));
    }

    // Another value of the group may hold, which this one could not replace; otherwise it is `open` why no rule gives it.
    bool instead(const Node& n, const Pattern& fact, const Predicate& p, bool& open) {
        open = true;
        std::optional<Row> held;
        if (p.aggregate != check::Aggregate::None)
            for (const Row& row : now().facts[fact.predicate.index()]) {
                bool same = true;
                for (std::size_t a = 0; a < p.aggregate_at; ++a) same = same && fact.arguments[a] && *fact.arguments[a] == row[a];
                if (same) held = row;
            }
        std::string_view said = n.note;
        const std::optional<Pattern> named = take_fact(program_, said);
        if (!held) return !named || fails("no value holds of which it says so");
        if (!named || !named->whole() || named->predicate != fact.predicate || named->row() != *held)
            return fails(print(program_, fact.predicate, *held) + " holds, and it does not say so");
        const std::optional<Value>& value = fact.arguments[p.aggregate_at];
        const Value& is = (*held)[p.aggregate_at];
        if (keeps_best(p.aggregate) && value) {
            const bool worse = keeps_least(p.aggregate) ? *value < is : *value > is;
            if (said.starts_with(" holds, and ")) open = false;
            return worse == open || fails("the better value is another");
        }
        open = false;
        return said.starts_with(combines(p.aggregate) ? " holds: " : " holds, and there is one value") || fails("it says: " + n.note);
    }

    // ---- rules

    bool heads(std::size_t i) {
        const Node& n = answer_.nodes[i];
        std::vector<HeadOf> all = heads_of(program_, facts_[i].predicate, RuleKind::View);
        for (HeadOf& h : heads_of(program_, facts_[i].predicate, RuleKind::Linear)) all.push_back(std::move(h));
        if (all.empty()) return ends_with(n, "it was never given, and no rule derives it");
        if (says(n.note, "ask about it for more")) return asked_.depth > 0 || fails("it could be followed further");
        std::size_t next = 0;
        bool given = false;
        for (const Way& w : n.ways) {
            if (!w.has_rule()) {
                if (given || w.note != "and it was not given") return fails("it is said of no rule: " + w.note);
                given = true;
                if (Past::any(now().given, facts_[i])) return fails("it was given");
                continue;
            }
            if (next == all.size() || given) return fails("there is no such rule: " + w.text);
            const HeadOf& h = all[next++];
            if (h.rule->name != w.rule || h.rule->text != w.text || h.rule->file != w.file || h.rule->line != w.line)
                return fails(fmt::format("{} stands instead of {}", w.text, h.rule->text));
            if (!way(i, w, h)) {
                why_ = fmt::format("{}:{}: {}", w.file, w.line, why_);
                return false;
            }
        }
        return next == all.size() || fails("a rule is missing: " + all[next].rule->text);
    }

    bool way(std::size_t i, const Way& w, const HeadOf& h) {
        ++judged_.ways;
        const Pattern& fact = facts_[i];
        if (w.note == "its head is never this fact") return contradicts(h, fact) || fails("its head may be this fact");
        if (says(w.note, "it cannot be looked up: ")) return beyond_states(h.clauses) || fails("it can be looked up: " + w.note);
        std::optional<Environment> with = bodies_.environment(h, w.with);
        if (!with) return fails("the values of its variables are none");
        // Of the text v(@2) the catom has no name, and yet a value.
        for (std::size_t a = 0; a < fact.arguments.size(); ++a) {
            const Term& t = h.head->atom.arguments[a];
            if (t.is_variable() && h.rule->variables[t.variable].name.starts_with('_')) (*with)[t.variable.index()] = fact.arguments[a];
        }
        const bool failed = !w.parts.empty() && w.parts.back().is == "fails";
        Clauses met;
        std::vector<bool> used(h.clauses.size(), false);
        for (std::size_t n = 0; n + (failed ? 1 : 0) < w.parts.size(); ++n) {
            ++judged_.parts;
            const std::optional<std::size_t> c = clause_of(w.parts[n], h, *with, used);
            if (!c) return fails(fmt::format("no part of its body is '{}' {}", w.parts[n].is, w.parts[n].text));
            met.push_back(h.clauses[*c]);
        }
        if (!satisfied(h, met, *with)) return fails("what is said to be met is not");
        return failed ? part_fails(w, h, *with, met, used, fact) : yet_.so(w, h, fact) || fails(yet_.why());
    }

    // Whether head and fact cannot be the same, whatever the body.
    bool contradicts(const HeadOf& h, const Pattern& fact) const {
        Environment env(h.rule->variables.count());
        const std::vector<Term>& arguments = h.head->atom.arguments;
        for (std::size_t a = 0; a < arguments.size(); ++a) {
            if (!fact.arguments[a] || arguments[a].op == Op::Anonymous) continue;
            std::optional<Value> is;
            if (arguments[a].is_variable()) {
                std::optional<Value>& known = env[arguments[a].variable.index()];
                if (!known) known = fact.arguments[a];
                is = known;
            } else if (all_bound(arguments[a], Environment(h.rule->variables.count())) && !beyond_states(arguments[a])) {
                is = evaluate(now().scene, arguments[a], env);
                if (!is) return true;
            }
            if (is && *is != *fact.arguments[a]) return true;
        }
        return false;
    }

    std::optional<std::size_t> clause_of(const Part& part, const HeadOf& h, const Environment& with, std::vector<bool>& used) const {
        for (std::size_t c = 0; c < h.clauses.size(); ++c) {
            const Clause& clause = h.clauses[c];
            const bool absent = clause.kind == Clause::Kind::Not && part.is == "absent";
            const bool alike = part.is == "fails" || absent || (clause.kind == Clause::Kind::Atom && part.is == "fact");
            if (used[c] || !alike) continue;
            const std::string text = absent ? bodies_.print(*h.rule, with, clause.inner) : bodies_.print(*h.rule, with, clause);
            if (!reads(part.text, text)) continue;
            used[c] = true;
            return c;
        }
        return std::nullopt;
    }
    bool satisfied(const HeadOf& h, const Clauses& clauses, const Environment& with) const {
        return bodies_.solve({*h.rule, clauses, {}, {asked_.tick, false}, with}, [](const Environment&) { return true; });
    }

    // ---- a part that fails

    bool part_fails(const Way& w, const HeadOf& h, const Environment& with, Clauses met, std::vector<bool>& used, const Pattern& fact) {
        const Part& part = w.parts.back();
        ++judged_.parts;
        if (!w.note.empty()) return fails("it is met, and fails");
        if (yet_.met(h, fact, {asked_.tick, false})) return fails("its body is met");
        const std::optional<std::size_t> c = clause_of(part, h, with, used);
        if (!c) return of_head(part, h, with, met, fact) || fails("no part of its body is that which fails: " + part.text);
        const Clause& clause = h.clauses[*c];
        if (clause.kind != Clause::Kind::Test && !tests_hold(h, with)) return fails("a condition is not met before it");
        met.push_back(clause);
        if (clause.kind == Clause::Kind::Element)
            for (const Clause& other : h.clauses)
                if (says_element(other, clause.variable)) met.push_back(other);
        if (satisfied(h, met, with)) return fails("this does not fail: " + part.text);
        if (clause.kind == Clause::Kind::Not) {
            const std::string_view said = part.note;
            return so_of_absence(part, said, *h.rule, clause.inner, with) || fails("it is said of what must not hold: " + part.note);
        }
        return clause.kind == Clause::Kind::Atom ? asks_about(part, clause.atom, with)
                                                 : !part.node || fails("it asks about what is no fact");
    }
    // `3 in List` is an element without a name, and that it is 3.
    static bool says_element(const Clause& c, check::VariableId element) {
        return c.kind == Clause::Kind::Test && c.test.op == Op::Equal &&
               std::ranges::any_of(c.test.operands, [&](const Term& t) { return t.is_variable() && t.variable == element; });
    }
    // Conditions are looked at as soon as they can be.
    bool tests_hold(const HeadOf& h, const Environment& with) const {
        return std::ranges::all_of(h.clauses, [&](const Clause& c) {
            if (c.kind != Clause::Kind::Test || !all_bound(c.test, with)) return true;
            const std::optional<Value> is = evaluate(now().scene, c.test, with);
            return is && is->truth();
        });
    }
    // The head's argument has another value.
    bool of_head(const Part& part, const HeadOf& h, const Environment& with, const Clauses& met, const Pattern& fact) const {
        const std::vector<Term>& arguments = h.head->atom.arguments;
        for (std::size_t a = 0; a < arguments.size(); ++a) {
            if (!fact.arguments[a]) continue;
            Rule rule = *h.rule;
            const check::Type& type = program_.predicates[fact.predicate].arguments[a].type;
            Term value{.op = Op::Variable, .type = type};
            value.variable = rule.variables.add({print(type, *fact.arguments[a]), {}, type});
            Environment env = with;
            env.push_back(fact.arguments[a]);
            Clause test{.kind = Clause::Kind::Test};
            test.test = {.op = Op::Equal, .type = check::Type::Bool};
            test.test.operands = {arguments[a], std::move(value)};
            if (!reads(part.text, bodies_.print(rule, env, test))) continue;
            Clauses with_it = met;
            with_it.push_back(std::move(test));
            return !bodies_.solve({rule, with_it, {}, {asked_.tick, false}, env}, [](const Environment&) { return true; });
        }
        return false;
    }
    // What holds that must not is named: all facts of one way to satisfy it. Where something must not hold beside them that should, it is
    // said why that does not.
    bool so_of_absence(const Part& part, std::string_view said, const Rule& rule, const Clauses& inner, const Environment& env) {
        std::map<const check::Atom*, Rows> named;
        bool absences = false;
        for (const Clause& c : inner) {
            absences = absences || c.kind == Clause::Kind::Not;
            if (c.kind != Clause::Kind::Atom) continue;
            if (!named.empty() && !take(said, ", ")) return false;
            const std::optional<Pattern> fact = take_fact(program_, said);
            if (!fact || !fact->whole() || fact->predicate != c.atom.predicate || !Past::any(now().facts, *fact)) return false;
            named[&c.atom].insert(fact->row());
        }
        if (!named.empty() && !take(said, absences ? " holds, and " : " holds")) return false;
        return bodies_.solve({rule, inner, {}, {asked_.tick, false}, env, named}, [&](const Environment& found) {
            if (!absences) return said.empty() && !part.node;
            return std::ranges::any_of(
                inner, [&](const Clause& c) { return c.kind == Clause::Kind::Not && so_of_part(part, said, rule, c.inner, found); });
        });
    }
    // Of a part that should hold: facts of it that there are together, and another of its clauses that then fails.
    bool so_of_part(const Part& part, std::string_view said, const Rule& rule, const Clauses& body, const Environment& env) {
        std::map<const Clause*, Pattern> beside;
        for (bool more = take(said, "beside "); more; more = take(said, ", ")) {
            const std::optional<Pattern> fact = take_fact(program_, said);
            const auto atom = std::ranges::find_if(body, [&](const Clause& c) {
                return fact && c.kind == Clause::Kind::Atom && c.atom.predicate == fact->predicate && !beside.contains(&c);
            });
            if (atom == body.end()) return false;
            beside.emplace(&*atom, *fact);
        }
        if (!beside.empty() && !take(said, " ")) return false;
        // What gives variables their values beside facts may be met too, or not yet.
        for (const bool values : {false, true})
            for (const Clause& c : body) {
                if (beside.contains(&c)) continue;
                Clauses met;
                for (const Clause& other : body)
                    if (&other != &c && (beside.contains(&other) || (values && gives_value(other)))) met.push_back(other);
                const bool so = bodies_.solve({rule, met, {}, {asked_.tick, false}, env}, [&](const Environment& found) {
                    return std::ranges::all_of(beside, [&](const auto& b) { return is_of(b.second, b.first->atom, found); }) &&
                           so_of_clause(part, said, rule, met, c, found);
                });
                if (so) return true;
            }
        return false;
    }
    // That this clause fails beside those that are met.
    bool so_of_clause(const Part& part, std::string_view said, const Rule& rule, Clauses met, const Clause& c, const Environment& env) {
        met.push_back(c);
        if (bodies_.solve({rule, met, {}, {asked_.tick, false}, env}, [](const Environment&) { return true; })) return false;
        if (said == "this does not hold:") return c.kind == Clause::Kind::Atom && part.node && asks_about(part, c.atom, env);
        if (!take(said, "this fails: ")) return false;
        const std::string text = bodies_.print(rule, env, c);
        if (c.kind != Clause::Kind::Not) return !part.node && reads(said, text);
        if (!take(said, text)) return false;
        return take(said, ": ") ? so_of_absence(part, said, rule, c.inner, env) : said.empty() && !part.node;
    }
    static bool take(std::string_view& text, std::string_view words) {
        if (!text.starts_with(words)) return false;
        text.remove_prefix(words.size());
        return true;
    }
    static bool gives_value(const Clause& c) {
        return c.kind == Clause::Kind::Element || c.kind == Clause::Kind::Aggregate ||
               (c.kind == Clause::Kind::Test && c.test.op == Op::Equal);
    }
    bool is_of(const Pattern& fact, const check::Atom& atom, const Environment& env) const {
        for (std::size_t a = 0; a < fact.arguments.size(); ++a)
            if (fact.arguments[a] && all_bound(atom.arguments[a], env) &&
                evaluate(now().scene, atom.arguments[a], env) != fact.arguments[a])
                return false;
        return true;
    }
    // The fact that is missing is the one that is asked about next; but at a catom that is known, and if it is missing.
    bool asks_about(const Part& part, const check::Atom& atom, const Environment& with) {
        Pattern wanted{.predicate = atom.predicate, .arguments = {}};
        for (const Term& t : atom.arguments) {
            wanted.arguments.emplace_back();
            if (t.op != Op::Anonymous && all_bound(t, with)) wanted.arguments.back() = evaluate(now().scene, t, with);
        }
        if (!part.node) {
            const bool followed = wanted.arguments[0] && !Past::any(now().facts, wanted);
            return !followed || atom.arguments[0].op == Op::Anonymous || fails("it is not asked why this is missing: " + part.text);
        }
        if (*part.node >= facts_.size()) return fails("there is no such fact");
        const Pattern& child = facts_[*part.node];
        if (child.predicate != wanted.predicate) return fails("another fact is asked about than " + part.text);
        for (std::size_t a = 0; a < child.arguments.size(); ++a) {
            // What the program does not name may have a value.
            const Term& t = atom.arguments[a];
            const bool unnamed = t.is_variable() && !wanted.arguments[a];
            if (child.arguments[a] != wanted.arguments[a] && !unnamed)
                return fails(fmt::format("{} is asked about for {}", answer_.nodes[*part.node].fact, part.text));
        }
        return true;
    }

    const Past& past_;
    const check::Program& program_;
    const Bodies bodies_;
    const Answer& answer_;
    const AskedFor& asked_;
    Judged& judged_;
    std::vector<Pattern> facts_;  // Of the nodes.
    YetJudge yet_;
    std::string why_;
};

}  // namespace

std::string judge_why_not(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged) {
    return WhyNotJudge(past, answer, asked, judged).run();
}

}  // namespace meld::reference
