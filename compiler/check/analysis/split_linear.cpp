#include "compiler/check/analysis/split_linear.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace meld::check {

namespace {

class Splitter {
  public:
    Splitter(const Program& program, const Rule& rule, VariableId here, VariableId there)
        : program_(program), rule_(rule), here_(here), there_(there) {}

    std::optional<Split> run() {
        std::string sent, consumed;
        bool placed = false;
        for (const Clause& c : rule_.body) {
            if (!c.inner.empty() && reads_linear(c.inner)) return std::nullopt;
            const bool linear = c.kind == Clause::Kind::Atom && program_.predicates[c.atom.predicate].linear();
            if (!linear || at(c) == here_) {
                add(consumed, print(program_, rule_, c));
                continue;
            }
            if (at(c) != there_ || c.atom.read_only || !take(c.atom)) return std::nullopt;
            add(sent, print(program_, rule_, c));
            if (!placed) add(consumed, "\n");
            placed = true;
        }
        const std::size_t arrow = rule_.text.find(" -o ");
        if (!placed || arrow == std::string::npos || has_linear_heads()) return std::nullopt;
        name_ += "-here";
        while (std::any_of(program_.predicates.begin(), program_.predicates.end(), [&](const Predicate& p) { return p.name == name_; }))
            name_ += "'";
        std::string types, arguments = rule_.variables[here_].name + ", " + rule_.variables[there_].name;
        for (const VariableId v : carried_) {
            types += ", " + type_name(rule_.variables[v].type);
            arguments += ", " + rule_.variables[v].name;
        }
        const std::string fact = fmt::format("{}({})", name_, arguments);
        for (const Clause& c : rule_.body)
            if (c.kind == Clause::Kind::Atom && program_.predicates[c.atom.predicate].route) add(sent, print(program_, rule_, c));
        consumed.replace(consumed.find('\n'), 1, fact);
        return Split{.declaration = fmt::format("type linear {}(node, node{}).", name_, types),
                     .send = fmt::format("{} -o {}.", sent, fact),
                     .consume = consumed + rule_.text.substr(arrow)};
    }

  private:
    static VariableId at(const Clause& c) { return c.atom.arguments[0].variable; }
    static void add(std::string& list, const std::string& text) { list += (list.empty() ? "" : ", ") + text; }

    // The variables that the fact gives; false if it is matched with a computed value, which the other catom would have to know.
    bool take(const Atom& fact) {
        if (name_.empty()) name_ = program_.predicates[fact.predicate].name;
        for (std::size_t i = 1; i < fact.arguments.size(); ++i) {
            const Term& t = fact.arguments[i];
            if (t.op == Op::Anonymous || t.op == Op::Int || t.op == Op::Float || t.op == Op::Bool || t.op == Op::String || t.op == Op::Node)
                continue;
            if (!t.is_variable() || rule_.variables[t.variable].name.starts_with("_")) return false;
            if (t.variable != here_ && t.variable != there_ && std::find(carried_.begin(), carried_.end(), t.variable) == carried_.end())
                carried_.push_back(t.variable);
        }
        return true;
    }
    bool reads_linear(const std::vector<Clause>& body) const {
        bool found = false;
        each_atom(body, [&](const Atom& a, bool) { found = found || program_.predicates[a.predicate].linear(); });
        return found;
    }
    bool has_linear_heads() const {
        bool found = false;
        each_head(rule_.heads, [&](const Head& h) { found = found || reads_linear(h.body); });
        return found;
    }

    const Program& program_;
    const Rule& rule_;
    VariableId here_, there_;
    std::string name_;
    std::vector<VariableId> carried_;
};

}  // namespace

std::optional<Split> split_linear(const Program& program, const Rule& rule, VariableId here, VariableId there) {
    if (rule.variables[here].name.starts_with("_") || rule.variables[there].name.starts_with("_")) return std::nullopt;
    return Splitter(program, rule, here, there).run();
}

}  // namespace meld::check
