#include "compiler/check/analysis/split_linear.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>
#include <vector>

namespace meld::check {

namespace {

// The catom that a test says a variable without a name is; empty: another clause.
std::string fixed_catom(const Program& program, const Rule& rule, const Clause& c) {
    if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal || !c.test.operands[0].is_variable()) return "";
    const bool fixed = c.test.operands[1].op == Op::Node || c.test.operands[1].op == Op::Constant;
    return fixed && rule.variables[c.test.operands[0].variable].name.starts_with("_") ? print(program, rule, c.test.operands[1]) : "";
}

// The rule as it is written: catoms that it names are named, and not tested.
Rule with_named_catoms(const Program& program, const Rule& rule) {
    Rule out = rule;
    for (const Clause& c : rule.body)
        if (const std::string name = fixed_catom(program, rule, c); !name.empty()) out.variables[c.test.operands[0].variable].name = name;
    std::erase_if(out.body, [&](const Clause& c) { return !fixed_catom(program, rule, c).empty(); });
    return out;
}

class Splitter {
  public:
    Splitter(const Program& program, const Rule& rule, VariableId here, VariableId there)
        : program_(program), rule_(rule), here_(here), there_(there) {}

    std::optional<Split> run() {
        find_links();
        if (gives_what_it_keeps_) return std::nullopt;
        // A link that is itself consumed is at one catom only, and what is there goes along it.
        const bool at_here = links_by_linear(here_), at_there = links_by_linear(there_);
        if (!connected() && at_here && !at_there) std::swap(here_, there_);
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
            if (is_link(c) && !program_.predicates[c.atom.predicate].linear()) add(sent, print(program_, rule_, c));
        if (!connected()) {
            const std::string link = fmt::format("neighbor({}, {})", rule_.variables[here_].name, rule_.variables[there_].name);
            if (!links_by_linear(there_)) add(sent, link);
            add(consumed, link);
        }
        consumed.replace(consumed.find('\n'), 1, fact);
        return Split{.kept = rule_.variables[here_].name,
                     .sent = rule_.variables[there_].name,
                     .declaration = fmt::format("type linear {}(node, node{}).", name_, types),
                     .send = fmt::format("{} -o {}.", sent, fact),
                     .consume = consumed + rule_.text.substr(arrow)};
    }

  private:
    static VariableId at(const Clause& c) { return c.atom.arguments[0].variable; }
    static void add(std::string& list, const std::string& text) { list += (list.empty() ? "" : ", ") + text; }

    bool is_link(const Clause& c) const {
        return c.kind == Clause::Kind::Atom && program_.predicates[c.atom.predicate].route && c.atom.arguments.size() > 1 &&
               c.atom.arguments[1].is_variable();
    }
    void find_links() {
        for (const Clause& c : rule_.body) {
            if (!is_link(c)) continue;
            const bool linear = program_.predicates[c.atom.predicate].linear();
            links_.push_back({at(c), c.atom.arguments[1].variable, linear});
        }
        std::map<PredicateId, VariableId> of;
        for (const Clause& c : rule_.body) {
            if (c.kind != Clause::Kind::Atom || !program_.predicates[c.atom.predicate].linear()) continue;
            const auto [one, fresh] = of.emplace(c.atom.predicate, at(c));
            gives_what_it_keeps_ = gives_what_it_keeps_ || (!fresh && one->second != at(c) && !is_fixed(at(c)) && !is_fixed(one->second));
        }
    }
    bool is_fixed(VariableId v) const { return !std::isupper(static_cast<unsigned char>(rule_.variables[v].name[0])); }
    // Whether links that stay lead from one catom to the other.
    bool connected() const {
        Variables seen{here_};
        for (std::size_t before = 0; before < seen.size();) {
            before = seen.size();
            for (const Link& l : links_) {
                if (l.linear) continue;
                if (seen.contains(l.from)) seen.insert(l.to);
                if (seen.contains(l.to)) seen.insert(l.from);
            }
        }
        return seen.contains(there_);
    }
    // Whether a link that is consumed there joins the two.
    bool links_by_linear(VariableId from) const {
        const VariableId to = from == here_ ? there_ : here_;
        return std::ranges::any_of(links_, [&](const Link& l) { return l.linear && l.from == from && l.to == to; });
    }

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
    struct Link {
        VariableId from, to;
        bool linear;
    };
    std::vector<Link> links_;
    // Some predicate has facts at both: the two would both be sent, and miss each other.
    bool gives_what_it_keeps_ = false;
    std::string name_;
    std::vector<VariableId> carried_;
};

}  // namespace

std::optional<Split> split_linear(const Program& program, const Rule& rule, VariableId here, VariableId there) {
    const Rule named = with_named_catoms(program, rule);
    if (named.variables[here].name.starts_with("_") || named.variables[there].name.starts_with("_")) return std::nullopt;
    return Splitter(program, named, here, there).run();
}

}  // namespace meld::check
