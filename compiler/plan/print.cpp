// The plan as text, and the explanation of rules and storage that --explain-rules prints.
#include <fmt/format.h>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

std::string storage_name(Storage storage) {
    switch (storage) {
        case Storage::Unused: return "unused";
        case Storage::Flag: return "flag";
        case Storage::Single: return "single";
        case Storage::PerLink: return "per link";
        case Storage::Rows: return "rows";
        case Storage::World: return "world";
    }
    return "";
}

namespace {

std::string recursion_name(Recursion r) {
    switch (r) {
        case Recursion::None: return "not recursive";
        case Recursion::LocalSets: return "recursive at the catom, from scratch";
        case Recursion::Ranked: return "recursive over links, ranks and quarantine";
        case Recursion::Mutual: return "mutually recursive, ranks and quarantine";
        case Recursion::Tree: return "sums over a tree";
    }
    return "";
}

class Printer {
  public:
    explicit Printer(const Plan& plan) : plan_(plan), program_(plan.program) {}

    std::string plan() {
        for (const ColumnId id : plan_.columns.ids()) {
            const Column& c = plan_.columns[id];
            out_ += fmt::format("column {} {}: {} bytes a catom{}{}\n", id.index(), c.name, c.stride, c.rows ? fmt::format(", {} a row", c.row_bytes) : "",
                                c.exported ? ", exported" : "");
        }
        for (const ComponentPlan& c : plan_.components) {
            std::string names;
            for (const PredicateId p : c.predicates) names += (names.empty() ? "" : ", ") + program_.predicates[p].name;
            out_ += fmt::format("\ncomponent {}: {}\n", names, recursion_name(c.recursion));
            for (const RulePlan& r : c.rules) rule(r);
            deltas(c);
        }
        if (!plan_.births.empty()) out_ += "\nat birth\n";
        for (const RulePlan& r : plan_.births) rule(r);
        if (!plan_.linear_rules.empty()) out_ += "\nlinear rules, first fitting first\n";
        for (const RulePlan& r : plan_.linear_rules) rule(r);
        return out_;
    }

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
                               : fmt::format(" in a record of {} bytes{}", c.stride, c.predicates.size() > 1 ? " shared with " + others(c, id) : "");
                if (s.exported) out_ += ", read by neighbours";
                if (s.ranked) out_ += ", with its rank";
            } else if (s.storage == Storage::World) {
                out_ += " read from the ensemble";
            } else if (p.kind == PredicateKind::Action) {
                out_ += " not stored: carried out";
            }
            out_ += "\n";
        }
        out_ += fmt::format("  all columns: {} bytes a catom\n\nRules\n", bytes_per_catom(plan_));
        for (const ComponentPlan& c : plan_.components)
            for (const RulePlan& r : c.rules) explain_view(r, recursion_name(c.recursion) + (c.deltas.inputs != 0 ? ", by row where only rows change" : ""));
        for (const RulePlan& r : plan_.births) explain_rule(r, "once, at birth");
        for (const RulePlan& r : plan_.linear_rules) explain_rule(r, "linear");
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
    std::string home_of(const check::Rule& rule) const {
        for (const check::Clause& c : rule.body)
            if (c.kind == check::Clause::Kind::Test && c.test.op == check::Op::Equal && rule.variables[rule.home].name.starts_with("_"))
                for (const std::size_t side : {0u, 1u})
                    if (c.test.operands[side].is_variable() && c.test.operands[side].variable == rule.home) return print(program_, rule, c.test.operands[1 - side]);
        return rule.variables[rule.home].name;
    }
    void explain_view(const RulePlan& r, const std::string& how) {
        if (r.branches.empty()) return explain_rule(r, how);
        check::Rule rule = rule_of(plan_, r);
        for (const RulePlan& b : r.branches) {
            RulePlan whole = b;
            whole.steps.insert(whole.steps.begin(), r.steps.begin(), r.steps.end());
            rule.text = program_.rules[b.rule].text;
            rule.variables[rule.home].name = program_.rules[b.rule].variables[program_.rules[b.rule].home].name;
            explain_rule(whole, rule, &b == &r.branches[0] ? how : fmt::format("{}; begins with {}", how, program_.rules[r.rule].name));
        }
    }
    void explain_rule(const RulePlan& r, const std::string& how) { explain_rule(r, program_.rules[r.rule], how); }
    void explain_rule(const RulePlan& r, const check::Rule& rule, const std::string& how) {
        out_ += fmt::format("  {}\n      runs at {}, {}", rule.text, home_of(rule), how);
        std::string order;
        std::size_t reads_made = 0;
        for (const Step& s : r.steps)
            if (const std::string text = access(s, rule); !text.empty()) {
                order += (order.empty() ? "" : ", then ") + text;
                ++reads_made;
            }
        if (reads_made > 1) out_ += "\n      reads " + order;
        std::string reads;
        remote_reads(r.steps, reads);
        heads_remote(r.heads, reads);
        if (!reads.empty()) out_ += fmt::format("\n      a change of {} is sent over each link", reads);
        std::string sends;
        sent(r.heads, rule, sends);
        if (!sends.empty()) out_ += fmt::format("\n      sends {}", sends);
        out_ += "\n";
    }
    // What a step reads, and why it stands where it does: one fact before a lookup before all rows, a link when nothing else is left.
    std::string access(const Step& s, const check::Rule& rule) const {
        switch (s.kind) {
            case Step::Kind::Neighbours: return "each neighbour";
            case Step::Kind::Locate: return "the neighbour " + rule.variables[s.place].name;
            case Step::Kind::Match: break;
            default: return "";
        }
        const Predicate& p = program_.predicates[s.predicate];
        const std::string at = s.at_home ? "" : " there";
        if (plan_.of(s.predicate).storage != Storage::Rows) return p.name + at;
        bool known = group_arguments(p) > 0;
        for (std::size_t i = 0; i < group_arguments(p); ++i) known = known && s.uses[i] == ArgumentUse::Compare;
        if (p.linear()) return "each " + p.name + at;
        return known ? p.name + at + " by its group" : "all rows of " + p.name + at;
    }

    void heads_remote(const std::vector<HeadPlan>& heads, std::string& out) const {
        for (const HeadPlan& h : heads) {
            remote_reads(h.steps, out);
            heads_remote(h.heads, out);
            heads_remote(h.others, out);
        }
    }
    void remote_reads(const std::vector<Step>& steps, std::string& out) const {
        for (const Step& s : steps) {
            remote_reads(s.inner, out);
            const std::string name = s.kind == Step::Kind::Match ? program_.predicates[s.predicate].name : "";
            if (s.kind == Step::Kind::Match && !s.at_home && out.find(name) == std::string::npos) out += (out.empty() ? "" : ", ") + name;
        }
    }
    void sent(const std::vector<HeadPlan>& heads, const check::Rule& rule, std::string& out) const {
        for (const HeadPlan& h : heads) {
            if (h.kind == Head::Kind::Fact && h.place != rule.home && rule.linear)
                out += fmt::format("{}{} to {}", out.empty() ? "" : ", ", program_.predicates[h.predicate].name, rule.variables[h.place].name);
            sent(h.heads, rule, out);
            sent(h.others, rule, out);
        }
    }

    void rule(const RulePlan& r) {
        if (!r.branches.empty()) return branching(r);
        rule_ = &program_.rules[r.rule];
        out_ += fmt::format("  {}  at {}   {}\n", rule_->name, rule_->variables[rule_->home].name, rule_->text);
        if (rule_->select != Select::None)
            indented(2, fmt::format("choose {} {}", rule_->select == Select::Random ? "any" : rule_->select == Select::Ascending ? "the least" : "the greatest", name(rule_->selected)));
        steps(r.steps, 2);
        heads(r.heads, 2 + r.steps.size());
    }

    void branching(const RulePlan& r) {
        const check::Rule joined = rule_of(plan_, r);
        rule_ = &joined;
        for (const RulePlan& b : r.branches) {
            const check::Rule& rule = program_.rules[b.rule];
            out_ += fmt::format("  {}  at {}   {}\n", rule.name, rule.variables[rule.home].name, rule.text);
        }
        steps(r.steps, 2);
        for (const RulePlan& b : r.branches) {
            steps(b.steps, 2 + r.steps.size());
            heads(b.heads, 2 + r.steps.size() + b.steps.size());
        }
        rule_ = nullptr;
    }

    // What is done where only rows have changed.
    void deltas(const ComponentPlan& c) {
        if (c.recursion == Recursion::LocalSets)
            for (const RulePlan& r : c.deltas.touches) {
                rule_ = &program_.rules[r.rule];
                out_ += fmt::format("  {} from what the last round made\n", rule_->name);
                steps(r.steps, 2);
                heads(r.heads, 2 + r.steps.size());
            }
        if (c.deltas.inputs == 0) return;
        for (const RulePlan& r : c.deltas.touches) {
            rule_ = &program_.rules[r.rule];
            out_ += fmt::format("  {} touches\n", rule_->name);
            steps(r.steps, 2);
            const HeadPlan& h = r.heads[0];
            std::string group;
            for (std::size_t i = 0; i < group_arguments(program_.predicates[h.predicate]); ++i) group += ", " + print(program_, *rule_, h.arguments[i]);
            indented(2 + r.steps.size(), fmt::format("-> group of {}({}{})", program_.predicates[h.predicate].name, name(h.place), group));
        }
        for (const RulePlan& r : c.deltas.groups) {
            rule_ = &program_.rules[r.rule];
            out_ += fmt::format("  {} for one group\n", rule_->name);
            steps(r.steps, 2);
            heads(r.heads, 2 + r.steps.size());
        }
    }

    void indented(std::size_t depth, const std::string& text) { out_ += std::string(depth * 2, ' ') + text + "\n"; }

    void steps(const std::vector<Step>& all, std::size_t depth) {
        for (const Step& s : all) {
            indented(depth, step(s, depth));
            ++depth;
        }
    }

    std::string name(VariableId v) const { return rule_->variables[v].name; }

    std::string step(const Step& s, std::size_t depth) {
        switch (s.kind) {
            case Step::Kind::Neighbours:
            case Step::Kind::Locate: {
                std::string text = fmt::format("{} neighbour {}", s.kind == Step::Kind::Neighbours ? "for each" : "find",
                                               s.place.valid() ? name(s.place) : s.term.op == Op::Anonymous ? "_" : print(program_, *rule_, s.term));
                if (s.port.valid()) text += " at port " + name(s.port);
                if (s.port_compare.op != Op::Anonymous) text += " at port " + print(program_, *rule_, s.port_compare);
                return text;
            }
            case Step::Kind::Match: {
                std::string text = (s.changed ? "changed " : "") + program_.predicates[s.predicate].name + "(" + name(s.place);
                for (std::size_t i = 0; i < s.arguments.size(); ++i)
                    text += ", " + std::string(s.uses[i] == ArgumentUse::Compare ? "=" : "") + print(program_, *rule_, s.arguments[i]);
                return text + ")" + (s.ranks ? "  rank" : "");
            }
            case Step::Kind::Test: return "if " + print(program_, *rule_, s.term);
            case Step::Kind::Set: return name(s.variable) + " = " + print(program_, *rule_, s.term);
            case Step::Kind::Absent: return "unless\n" + inside(s, depth);
            case Step::Kind::Each: return fmt::format("for each {} in {}", name(s.variable), print(program_, *rule_, s.term));
            case Step::Kind::Fold: {
                const std::string how = s.aggregate == Aggregate::Custom ? program_.functions[s.fold].name : aggregate_name(s.aggregate);
                const std::string value = s.term.op == Op::Anonymous ? "" : " " + print(program_, *rule_, s.term);
                return fmt::format("{} = {}{} over\n", name(s.variable), how, value) + inside(s, depth);
            }
            case Step::Kind::Delta: return fmt::format("if delta {} {} {}", name(s.variable), sign(s.compare), print(program_, *rule_, s.term));
        }
        return "";
    }
    static const char* sign(Op op) {
        switch (op) {
            case Op::Equal: return "=";
            case Op::NotEqual: return "<>";
            case Op::Less: return "<";
            case Op::LessEqual: return "<=";
            case Op::GreaterEqual: return ">=";
            default: return ">";
        }
    }
    std::string inside(const Step& s, std::size_t depth) {
        std::string saved;
        std::swap(saved, out_);
        steps(s.inner, depth + 1);
        std::swap(saved, out_);
        while (!saved.empty() && saved.back() == '\n') saved.pop_back();
        return saved;
    }

    void heads(const std::vector<HeadPlan>& all, std::size_t depth) {
        for (const HeadPlan& h : all) {
            switch (h.kind) {
                case Head::Kind::Fact: {
                    std::string text = "-> " + program_.predicates[h.predicate].name + "(" + name(h.place);
                    for (const Term& t : h.arguments) text += ", " + print(program_, *rule_, t);
                    indented(depth, text + ")");
                    break;
                }
                case Head::Kind::Comprehension:
                case Head::Kind::Aggregate:
                    indented(depth, "-> for all");
                    steps(h.steps, depth + 1);
                    heads(h.heads, depth + 1 + h.steps.size());
                    for (const Fold& f : h.folds) indented(depth, fmt::format("   {} = {}{}", name(f.result), aggregate_name(f.aggregate), f.each.valid() ? " " + name(f.each) : ""));
                    heads(h.others, depth);
                    break;
                case Head::Kind::If:
                    indented(depth, "-> if " + print(program_, *rule_, h.term));
                    heads(h.heads, depth + 1);
                    indented(depth, "   else");
                    heads(h.others, depth + 1);
                    break;
                case Head::Kind::Set:
                    indented(depth, fmt::format("-> {} = {}", name(h.variable), print(program_, *rule_, h.term)));
                    heads(h.heads, depth + 1);
                    break;
            }
        }
    }

    const Plan& plan_;
    const Program& program_;
    const check::Rule* rule_ = nullptr;
    std::string out_;
};

}  // namespace

std::string print(const Plan& plan) { return Printer(plan).plan(); }
std::string explain(const Plan& plan) { return Printer(plan).explanation(); }

}  // namespace meld::plan
