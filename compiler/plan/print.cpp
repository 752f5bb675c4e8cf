// The plan as text, as --emit=plan prints it.
#include <algorithm>

#include <fmt/format.h>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

std::string storage_name(Storage storage) {
    switch (storage) {
        case Storage::Unused:
            return "unused";
        case Storage::Flag:
            return "flag";
        case Storage::Single:
            return "single";
        case Storage::PerLink:
            return "per link";
        case Storage::Rows:
            return "rows";
        case Storage::World:
            return "world";
    }
    return "";
}

std::string recursion_name(Recursion r) {
    switch (r) {
        case Recursion::None:
            return "not recursive";
        case Recursion::LocalSets:
            return "recursive at the catom, from scratch";
        case Recursion::Ranked:
            return "recursive over links, ranks and quarantine";
        case Recursion::Mutual:
            return "mutually recursive, ranks and quarantine";
        case Recursion::Tree:
            return "sums over a tree";
        case Recursion::Rounds:
            return "recursive in rounds, from scratch";
    }
    return "";
}

namespace {

class Printer {
  public:
    explicit Printer(const Plan& plan) : plan_(plan), program_(plan.program) {}

    std::string plan() {
        for (const ColumnId id : plan_.columns.ids()) {
            const Column& c = plan_.columns[id];
            out_ += fmt::format("column {} {}: {} byte{} a catom{}{}\n", id.index(), c.name, c.stride, c.stride == 1 ? "" : "s",
                                c.rows ? fmt::format(", {} a row", c.row_bytes) : "", c.exported ? ", exported" : "");
        }
        if (plan_.idle_births) out_ += "at first only catoms with given facts are evaluated\n";
        for (const StratumPlan& stratum : plan_.strata) {
            std::string names;
            for (const PredicateId p : stratum.predicates) names += (names.empty() ? "" : ", ") + program_.predicates[p].name;
            out_ += fmt::format("\nstratum {}: {}\n", names, recursion_name(stratum.recursion));
            for (const RulePlan& r : stratum.rules) rule(r);
            semi_naive(stratum);
            deltas(stratum.deltas);
        }
        if (!plan_.initial_facts.empty()) out_ += "\ninitial facts, once for each new catom\n";
        for (const RulePlan& r : plan_.initial_facts) rule(r);
        if (!plan_.linear_rules.empty()) out_ += "\nlinear rules, first fitting first\n";
        if (plan_.singles.apply()) {
            std::string facts, messages;
            for (const PredicateId p : plan_.singles.facts) facts += (facts.empty() ? "" : ", ") + program_.predicates[p].name;
            for (const PredicateId p : plan_.singles.messages)
                messages += (messages.empty() ? ", beside any number of " : ", ") + program_.predicates[p].name;
            out_ += fmt::format("  in variables, while there is at most one of each: {}{}\n", facts, messages);
        }
        std::string pulled;
        for (const PredicateId p : plan_.pulled) pulled += (pulled.empty() ? "" : ", ") + program_.predicates[p].name;
        if (!pulled.empty()) out_ += fmt::format("  told to all neighbours, who read it there while nobody looks on: {}\n", pulled);
        for (const RulePlan& r : plan_.linear_rules) rule(r);
        return out_;
    }

  private:
    void rule(const RulePlan& r) {
        if (!r.branches.empty()) return branching(r);
        rule_ = &program_.rules[r.rule];
        out_ += fmt::format("  {}  at {}   {}\n", rule_->name, rule_->variables[rule_->site].name, rule_->text);
        if (rule_->select != Select::None)
            indented(2, fmt::format("choose {} {}",
                                    rule_->select == Select::Random      ? "any"
                                    : rule_->select == Select::Ascending ? "the least"
                                                                         : "the greatest",
                                    name(rule_->selected)));
        if (r.sweep.applies())
            indented(2, fmt::format("all {} in one pass, if there is one {}", program_.predicates[r.sweep.messages].name,
                                    program_.predicates[r.sweep.state].name));
        if (r.search.applies()) indented(2, "all firings in one search");
        steps(r.steps, 2);
        heads(r.heads, 2 + r.steps.size());
    }

    void branching(const RulePlan& r) {
        const check::Rule joined = rule_of(plan_, r);
        rule_ = &joined;
        for (const RulePlan& b : r.branches) {
            const check::Rule& rule = program_.rules[b.rule];
            out_ += fmt::format("  {}  at {}   {}\n", rule.name, rule.variables[rule.site].name, rule.text);
        }
        steps(r.steps, 2);
        for (const RulePlan& b : r.branches) {
            steps(b.steps, 2 + r.steps.size());
            heads(b.heads, 2 + r.steps.size() + b.steps.size());
        }
        rule_ = nullptr;
    }

    // What each round but the first evaluates.
    void semi_naive(const StratumPlan& stratum) {
        for (const RulePlan& r : stratum.semi_naive) {
            headline(r, "semi-naive");
            heads(r.heads, 2 + r.steps.size());
        }
    }

    // What is evaluated where only single rows have changed.
    void deltas(const DeltaRules& deltas) {
        for (const RulePlan& r : deltas.affected) {
            headline(r, "delta rule");
            const MakeFact& h = r.derived();
            std::string group;
            for (std::size_t i = 0; i < group_arguments(program_.predicates[h.predicate]); ++i)
                group += ", " + print(program_, *rule_, h.arguments[i]);
            indented(2 + r.steps.size(),
                     fmt::format("-> affected group {}({}{})", program_.predicates[h.predicate].name, name(h.place), group));
        }
        for (const RulePlan& r : deltas.regroup) {
            headline(r, "for one group");
            heads(r.heads, 2 + r.steps.size());
        }
    }
    // Which rule this is and what it is for, and its steps.
    void headline(const RulePlan& r, std::string_view what) {
        rule_ = &program_.rules[r.rule];
        out_ += fmt::format("  {}, {}\n", rule_->name, what);
        steps(r.steps, 2);
    }

    // Each step stands below the one before it; in a long body most of the text would be spaces.
    void indented(std::size_t depth, const std::string& text) {
        static constexpr std::size_t kDeepest = 50;
        out_ += std::string(std::min(depth, kDeepest) * 2, ' ') + text + "\n";
    }

    void steps(const std::vector<Step>& all, std::size_t depth) {
        for (const Step& s : all) {
            indented(depth, step(s, depth));
            ++depth;
        }
    }

    std::string name(VariableId v) const { return rule_->variables[v].name; }

    std::string text(const Term& term) const { return print(program_, *rule_, term); }

    // Each as the comment of its struct shows it (steps.h).
    std::string step(const Step& s, std::size_t depth) {
        return visit_step<std::string>(s, [&](const auto& one) { return concrete(one, depth); });
    }
    std::string concrete(const EachNeighbour& s, std::size_t) const {
        const std::string which = s.place.valid() ? name(s.place) : s.only.op == Op::Anonymous ? "_" : text(s.only);
        return "for each neighbour " + which + at(s.port);
    }
    std::string concrete(const FindNeighbour& s, std::size_t) const { return "find neighbour " + name(s.place) + at(s.port); }
    std::string at(const PortUse& port) const {
        if (port.bind.valid()) return " at port " + name(port.bind);
        return port.equals.op == Op::Anonymous ? "" : " at port " + text(port.equals);
    }
    std::string concrete(const Match& s, std::size_t) const {
        std::string out = (s.changed ? "changed " : "") + program_.predicates[s.predicate].name + "(" + name(s.place);
        for (std::size_t i = 0; i < s.arguments.size(); ++i)
            out += std::string(s.uses[i] == ArgumentUse::Compare ? ", =" : ", ") + text(s.arguments[i]);
        const char* found = s.lookup.kind == Lookup::Kind::Alike    ? "  those alike once"
                            : !s.lookup.found()                     ? ""
                            : s.lookup.kind == Lookup::Kind::Prefix ? "  sorted"
                                                                    : "  index";
        return out + ")" + (s.ranks ? "  rank" : "") + found;
    }
    std::string concrete(const Test& s, std::size_t) const { return "if " + text(s.condition); }
    std::string concrete(const Set& s, std::size_t) const { return name(s.variable) + " = " + text(s.value); }
    std::string concrete(const Unless& s, std::size_t depth) { return "unless\n" + inside(s.steps, depth); }
    std::string concrete(const EachElement& s, std::size_t) const {
        return fmt::format("for each {} in {}", name(s.variable), text(s.list));
    }
    std::string concrete(const AggregateOver& s, std::size_t depth) {
        const std::string value = s.value.op == Op::Anonymous ? "" : " " + text(s.value);
        return fmt::format("{} = {}{} over\n", name(s.variable), aggregate(s.aggregate, s.function, s.parameter), value) +
               inside(s.steps, depth);
    }
    // How it is written, with the number of values that min_k and max_k keep.
    std::string aggregate(Aggregate which, FunctionId function, const Term& parameter) const {
        if (which == Aggregate::Custom) return program_.functions[function].name;
        return aggregate_name(which) + (info(which).has(AggregateInfo::kParameter) ? "(" + text(parameter) + ")" : "");
    }
    std::string concrete(const ChangeSince& s, std::size_t) const {
        return fmt::format("if delta {} {} {}", name(s.variable), sign(s.compare), text(s.bound));
    }
    static const char* sign(Op op) {
        switch (op) {
            case Op::Equal:
                return "=";
            case Op::NotEqual:
                return "<>";
            case Op::Less:
                return "<";
            case Op::LessEqual:
                return "<=";
            case Op::GreaterEqual:
                return ">=";
            default:
                return ">";
        }
    }
    std::string inside(const std::vector<Step>& inner, std::size_t depth) {
        std::string saved;
        std::swap(saved, out_);
        steps(inner, depth + 1);
        std::swap(saved, out_);
        while (!saved.empty() && saved.back() == '\n') saved.pop_back();
        return saved;
    }

    // Each as the comment of its struct shows it (heads.h).
    void heads(const std::vector<HeadPlan>& all, std::size_t depth) {
        for (const HeadPlan& h : all) visit_head(h, [&](const auto& one) { head(one, depth); });
    }
    void head(const MakeFact& h, std::size_t depth) {
        std::string arguments;
        for (const Term& t : h.arguments) arguments += ", " + text(t);
        indented(depth,
                 fmt::format("-> {}({}{}){}", program_.predicates[h.predicate].name, name(h.place), arguments, h.alike ? "  [alike]" : ""));
    }
    void head(const ForAll& h, std::size_t depth) {
        indented(depth, "-> for all");
        steps(h.steps, depth + 1);
        heads(h.heads, depth + 1 + h.steps.size());
    }
    void head(const AggregateAll& h, std::size_t depth) {
        head(h.each, depth);
        for (const HeadAggregate& a : h.aggregates) {
            const std::string from =
                a.aggregate == Aggregate::Custom && a.parameter.op != Op::Anonymous ? " from " + text(a.parameter) : "";
            const std::string value = a.each.valid() ? " " + name(a.each) : "";
            indented(depth, fmt::format("   {} = {}{}{}", name(a.result), aggregate(a.aggregate, a.function, a.parameter), from, value));
        }
        heads(h.results, depth);
    }
    void head(const Choose& h, std::size_t depth) {
        indented(depth, "-> if " + text(h.condition));
        heads(h.heads, depth + 1);
        indented(depth, "   else");
        heads(h.others, depth + 1);
    }
    void head(const With& h, std::size_t depth) {
        indented(depth, fmt::format("-> {} = {}", name(h.variable), text(h.value)));
        heads(h.heads, depth + 1);
    }

    const Plan& plan_;
    const Program& program_;
    const check::Rule* rule_ = nullptr;
    std::string out_;
};

}  // namespace

std::string print(const Plan& plan) { return Printer(plan).plan(); }

}  // namespace meld::plan
