// The output of --explain-rules: how each predicate is stored; where each rule runs, in which order it reads and why, and what it sends.
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "compiler/plan/picks.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

class Explainer {
  public:
    explicit Explainer(const Plan& plan) : plan_(plan), program_(plan.program) {}

    std::string explanation() {
        out_ += "Predicates\n";
        for (const PredicateId id : program_.predicates.ids()) {
            const Predicate& p = program_.predicates[id];
            const Stored& s = plan_.of(id);
            if (s.storage == Storage::Unused && p.prelude) continue;
            out_ += fmt::format("  {:<28} {:<9}", p.signature(), storage_name(s.storage));
            if (s.column.valid()) {
                const Column& c = plan_.columns[s.column];
                out_ += c.rows ? fmt::format(" {} bytes a catom and {} a fact", c.stride, c.row_bytes)
                               : fmt::format(" in a record of {} byte{}{}", c.stride, c.stride == 1 ? "" : "s",
                                             c.predicates.size() > 1 ? " shared with " + others(c, id) : "");
                if (s.exported) out_ += ", read by neighbours";
                if (s.ranked) out_ += ", with its rank";
            } else if (s.storage == Storage::World) {
                out_ += " read from the ensemble";
            } else if (p.kind == PredicateKind::Action) {
                out_ += " not stored: carried out";
            }
            if (const std::optional<Aggregate> picked = picks(plan_, id))
                out_ += fmt::format(", the {} of its values without a call of {}", *picked == Aggregate::Min ? "least" : "greatest",
                                    program_.functions[p.fold].name);
            out_ += "\n";
        }
        out_ += fmt::format("  all columns: {} bytes a catom\n\nRules\n", bytes_per_catom(plan_));
        for (const StratumPlan& s : plan_.strata)
            for (const RulePlan& r : s.rules)
                explain_view(r, recursion_name(s.recursion) + (s.deltas.inputs != 0 ? ", by delta rules where only rows change" : ""));
        for (const RulePlan& r : plan_.initial_facts) explain_rule(r, "once, when the catom is initialized");
        for (const RulePlan& r : plan_.linear_rules) explain_rule(r, "linear");
        explain_singles();
        return out_;
    }

  private:
    std::string others(const Column& c, PredicateId self) const {
        std::string text;
        for (const PredicateId p : c.predicates)
            if (p != self) text += (text.empty() ? "" : ", ") + program_.predicates[p].name;
        return text;
    }

    // A catom that the rule names by its number has a variable without a name.
    std::string site_of(const check::Rule& rule) const {
        for (const check::Clause& c : rule.body)
            if (c.kind == check::Clause::Kind::Test && c.test.op == check::Op::Equal && rule.variables[rule.site].name.starts_with("_"))
                for (const std::size_t side : {0u, 1u})
                    if (c.test.operands[side].is_variable() && c.test.operands[side].variable == rule.site)
                        return print(program_, rule, c.test.operands[1 - side]);
        return rule.variables[rule.site].name;
    }
    void explain_view(const RulePlan& r, const std::string& how) {
        if (r.branches.empty()) return explain_rule(r, how);
        check::Rule rule = rule_of(plan_, r);
        for (const RulePlan& b : r.branches) {
            RulePlan whole = b;
            whole.steps.insert(whole.steps.begin(), r.steps.begin(), r.steps.end());
            // The order was chosen for the first of them; what the others had before these steps was not compared.
            if (&b != &r.branches[0])
                for (Step& s : whole.steps)
                    if (Choice* c = choice_of(s)) c->dearer = c->waiting = {};
            rule.text = program_.rules[b.rule].text;
            rule.variables[rule.site].name = program_.rules[b.rule].variables[program_.rules[b.rule].site].name;
            explain_rule(whole, rule, &b == &r.branches[0] ? how : fmt::format("{}; begins with {}", how, program_.rules[r.rule].name));
        }
    }
    void explain_rule(const RulePlan& r, const std::string& how) { explain_rule(r, program_.rules[r.rule], how); }
    void explain_rule(const RulePlan& r, const check::Rule& rule, const std::string& how) {
        out_ += fmt::format("  {}\n      runs at {}, {}", rule.text, site_of(rule), how);
        order_of_reading(r.steps, rule);
        order_in_heads(r.heads, rule);
        lookups(r, rule);
        std::vector<std::string> reads;
        remote_reads(r.steps, reads);
        heads_remote(r.heads, reads);
        if (!reads.empty()) out_ += fmt::format("\n      a change of {} is sent over each link", fmt::join(reads, ", "));
        std::string sends;
        sent(r.heads, rule, sends);
        if (!sends.empty()) out_ += fmt::format("\n      sends {}", sends);
        if (r.sweep.candidate()) {
            const std::string &messages = program_.predicates[r.sweep.messages].name, &state = program_.predicates[r.sweep.state].name;
            out_ += r.sweep.applies() ? fmt::format("\n      takes all {} in one pass where there is one {}", messages, state)
                                      : fmt::format("\n      takes one {} at a time: {}", messages, r.sweep.obstacle);
        }
        firings(r);
        out_ += "\n";
    }
    // How a linear rule goes on after a firing.
    void firings(const RulePlan& r) {
        if (!r.search.asked || (r.sweep.candidate() && r.sweep.applies())) return;
        if (!r.search.applies()) {
            out_ += fmt::format("\n      starts over after each firing: {}", r.search.obstacle);
            return;
        }
        std::vector<std::string> kept, changed;
        for (const OneSearch::MadeAgain& m : r.search.put_back)
            kept.push_back(program_.predicates[as<Match>(r.steps[m.step])->predicate].name);
        if (r.search.changed.step != OneSearch::kNone)
            changed.push_back(program_.predicates[as<Match>(r.steps[r.search.changed.step])->predicate].name);
        out_ += "\n      does all its firings in one search";
        if (!kept.empty()) out_ += fmt::format(", which leaves {} in place", listed(kept));
        if (!changed.empty()) out_ += fmt::format(", which changes {} in place", listed(changed));
    }
    // How rows are found of which some arguments are known.
    void lookups(const RulePlan& r, const check::Rule& rule) {
        const auto each = [&](const Step& s) {
            if (const Match* m = as<Match>(s)) lookup(*m, rule);
        };
        each_step(r.steps, each);
        each_head_plan(r.heads, [&](const HeadPlan& h) {
            if (const std::vector<Step>* steps = steps_of(h)) each_step(*steps, each);
        });
    }
    void lookup(const Match& m, const check::Rule& rule) {
        const std::string name = program_.predicates[m.predicate].name + (m.at_site ? "" : " there");
        if (!m.lookup.found()) {
            if (!m.lookup.obstacle.empty()) out_ += fmt::format("\n      looks at all rows of {}: {}", name, m.lookup.obstacle);
            return;
        }
        std::vector<std::string> values;
        for (const std::size_t i : m.lookup.by) values.push_back(print(program_, rule, m.arguments[i - 1]));
        out_ += m.lookup.kind == Lookup::Kind::Prefix
                    ? fmt::format("\n      finds {} with {} first by the order of its rows", name, listed(values))
                    : fmt::format("\n      finds {} with {} by an index, where a catom holds many", name, listed(values));
    }
    // The steps of a body, of a negation or of a head, and of those inside them. A single read has no order.
    void order_of_reading(const std::vector<Step>& steps, const check::Rule& rule, std::string indent = "\n      ",
                          const std::string& inside = "") {
        if (order_of_steps(steps, rule, inside.empty() ? indent : indent + "  ", inside.empty() ? "" : indent + inside) && !inside.empty())
            indent += "  ";
        std::string last;
        for (const Step& s : steps) {
            if (const std::vector<Step>* inner = inner_steps(s); inner != nullptr && !inner->empty()) {
                const AggregateOver* over = as<AggregateOver>(s);
                const std::string what = over == nullptr                        ? "the negation"
                                         : over->aggregate == Aggregate::Custom ? "the fold"
                                                                                : "the " + aggregate_name(over->aggregate);
                order_of_reading(*inner, rule, indent,
                                 fmt::format("inside {} over {}, asked {}", what, read_in(*inner),
                                             last.empty() ? "before anything is read" : "after " + last));
            }
            if (std::string text = access(s, rule); !text.empty()) last = std::move(text);
        }
    }
    // The reads of the heads, once the body has matched.
    void order_in_heads(const std::vector<HeadPlan>& heads, const check::Rule& rule) {
        each_head_plan(heads, [&](const HeadPlan& h) {
            const std::vector<Step>* steps = steps_of(h);
            if (steps == nullptr || steps->empty()) return;
            const char* what = as<AggregateAll>(h) != nullptr ? "aggregate" : "comprehension";
            order_of_reading(*steps, rule, "\n      ", fmt::format("inside the {} over {} in the head", what, read_in(*steps)));
        });
    }
    // The names of everything that these steps read.
    std::string read_in(const std::vector<Step>& steps) const {
        std::vector<std::string> names;
        const auto add = [&](const std::string& name) {
            if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        };
        for (const Step& s : steps)
            visit_step(
                s,  //
                [&](const Match& m) { add(program_.predicates[m.predicate].name); }, [&](const EachNeighbour&) { add("neighbor"); },
                [&](const FindNeighbour&) { add("neighbor"); }, [&](const EachElement&) { add("a list"); }, [](const auto&) {});
        return listed(names);
    }
    static std::string listed(const std::vector<std::string>& texts) {
        std::string text;
        for (std::size_t i = 0; i < texts.size(); ++i) text += (i == 0 ? "" : i + 1 < texts.size() ? ", " : " and ") + texts[i];
        return text;
    }
    // Returns whether it has said anything.
    bool order_of_steps(const std::vector<Step>& steps, const check::Rule& rule, const std::string& indent, const std::string& header) {
        struct Read {
            std::string text;
            const Step* step;
        };
        std::vector<Read> reads;
        bool as_written = true;
        for (const Step& s : steps)
            if (std::string text = access(s, rule); !text.empty()) {
                reads.push_back({std::move(text), &s});
                as_written = as_written && choice_of(s)->reason == Reason::Written && choice_of(s)->waiting.empty();
            }
        if (reads.size() < 2) return false;
        out_ += header;
        if (as_written) out_ += indent + "reads in the order written: ";
        const std::vector<PredicateId>* named = nullptr;
        for (std::size_t i = 0; i < reads.size(); ++i) {
            const Choice& c = *choice_of(*reads[i].step);
            if (as_written) {
                out_ += (i == 0 ? "" : ", then ") + reads[i].text;
                continue;
            }
            out_ += fmt::format("{}{} {}: {}", indent, i == 0 ? "reads" : "then", reads[i].text, reason(*reads[i].step));
            if (!c.dearer.empty()) {
                out_ += ", so ahead of " + names(c.dearer, *reads[i].step);
            } else if (!c.waiting.empty() && (named == nullptr || *named != c.waiting)) {
                out_ += fmt::format(", while {} cannot be read yet", names(c.waiting, *reads[i].step));
                named = &c.waiting;
            }
        }
        return true;
    }
    // Each once; a second atom of the predicate being read is "the other".
    std::string names(const std::vector<PredicateId>& predicates, const Step& read) const {
        std::vector<std::string> texts;
        for (const PredicateId p : predicates) {
            const Match* m = as<Match>(read);
            const std::string other = m != nullptr && p == m->predicate ? "the other " : "";
            const std::string name = p.valid() ? other + program_.predicates[p].name : "the elements of a list";
            if (std::find(texts.begin(), texts.end(), name) == texts.end()) texts.push_back(name);
        }
        return listed(texts);
    }
    static std::string reason(const Step& s) {
        const Choice& c = *choice_of(s);
        switch (c.reason) {
            case Reason::Written:
                return "as written";
            case Reason::Test:
                return "all of it is known, a test";
            case Reason::Exists:
                return "gives no variable a value";
            case Reason::One:
                return "at most one fact";
            case Reason::Rows:
                return c.known == 0 ? "none of its arguments is known"
                                    : fmt::format("{} of {} arguments {} known", c.known, as<Match>(s)->arguments.size(),
                                                  c.known == 1 ? "is" : "are");
            case Reason::Elements:
                return "its list or set is known";
            case Reason::Named:
                return "its id is known";
            case Reason::Links:
                return fmt::format("up to {}, and nothing cheaper can be read", kMaxPorts);
        }
        return "";
    }
    void explain_singles() {
        const Singles& singles = plan_.singles;
        if (singles.apply())
            out_ += fmt::format("\nWhile a catom holds at most one {}, its linear facts are in registers.\n", any_of(singles.facts));
        else if (!singles.obstacle.empty())
            out_ += fmt::format("\nLinear facts are in lists, even where a catom holds one of each: {}.\n", singles.obstacle);
    }
    std::string any_of(const std::vector<PredicateId>& predicates) const {
        std::vector<std::string> texts;
        for (const PredicateId p : predicates) texts.push_back((texts.empty() ? "" : "one ") + program_.predicates[p].name);
        return listed(texts);
    }
    // What a step reads; empty for one that only tests or computes.
    std::string access(const Step& s, const check::Rule& rule) const {
        return visit_step<std::string>(
            s,  //
            [](const EachNeighbour&) { return "each neighbour"; },
            [&](const FindNeighbour& n) { return "the neighbour " + rule.variables[n.place].name; },
            [&](const EachElement& e) { return "each element of " + print(program_, rule, e.list); },
            [&](const Match& m) { return match(m); }, [](const auto&) { return ""; });
    }
    std::string match(const Match& m) const {
        const Predicate& p = program_.predicates[m.predicate];
        const std::string name = p.name + (m.at_site ? "" : " there");
        if (plan_.of(m.predicate).storage != Storage::Rows) return name;
        if (p.linear()) return "each " + name;
        bool known = group_arguments(p) > 0;
        for (std::size_t i = 0; i < group_arguments(p); ++i) known = known && m.uses[i] == ArgumentUse::Compare;
        return known ? name + " by its group" : (m.lookup.found() ? "rows of " : "all rows of ") + name;
    }

    void heads_remote(const std::vector<HeadPlan>& heads, std::vector<std::string>& out) const {
        each_head_plan(heads, [&](const HeadPlan& h) {
            if (const std::vector<Step>* steps = steps_of(h)) remote_reads(*steps, out);
        });
    }
    void remote_reads(const std::vector<Step>& steps, std::vector<std::string>& out) const {
        each_step(steps, [&](const Step& s) {
            const Match* m = as<Match>(s);
            if (m == nullptr || m->at_site) return;
            const std::string& name = program_.predicates[m->predicate].name;
            if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
        });
    }
    void sent(const std::vector<HeadPlan>& heads, const check::Rule& rule, std::string& out) const {
        std::set<const MakeFact*> told;
        each_head_plan(heads, [&](const HeadPlan& h) {
            if (const ForAll* all = as<ForAll>(h)) told.insert(to_all_neighbours(*all));
            const MakeFact* fact = as<MakeFact>(h);
            if (fact == nullptr || fact->place == rule.site || !rule.linear) return;
            out += fmt::format("{}{} to {}", out.empty() ? "" : ", ", program_.predicates[fact->predicate].name,
                               rule.variables[fact->place].name);
            if (fact->alike) out += ", written once for all";
            if (told.contains(fact) && plan_.pulls(fact->predicate)) out += ", who read it there while nobody looks on";
            if (!fact->difference.empty()) out += fmt::format(", written for each ({})", fact->difference);
        });
    }

    const Plan& plan_;
    const Program& program_;
    std::string out_;
};

}  // namespace

std::string explain(const Plan& plan) { return Explainer(plan).explanation(); }

}  // namespace meld::plan
