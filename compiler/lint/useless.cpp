// Rules that can never fire, parts of them that can never match, predicates that nothing starts, unused predicates and parameters. Facts
// may come from the world file and results may only be written out, so it warns only if that does not explain it.
#include <algorithm>
#include <deque>

#include "compiler/check/program/forall.h"
#include "compiler/lint/contradiction.h"
#include "compiler/lint/linear_form.h"
#include "compiler/lint/lint.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

class Useless {
  public:
    Useless(const Program& program, std::uint32_t program_file, diagnostics::Reporter& report)
        : program_(program), program_file_(program_file), report_(report) {}

    void run() {
        for (const Rule& rule : program_.rules) never_fires(rule);
        count_uses();
        for (const check::Stratum& c : program_.strata) nothing_starts(c);
        for (const PredicateId p : program_.predicates.ids()) {
            other_name(p);
            unused(p);
            unknown_action(p);
        }
        for (const Function& f : program_.functions) unused_parameters(f);
    }

  private:
    // ---- rules

    void never_fires(const Rule& rule) {
        if (impossible(rule, {}, rule.body, Kind::NeverFires, "so the rule never fires")) return;
        const Around around = conditions(rule.body);
        parts(rule, around, rule.body, "and the rule never fires");
        parts_of_heads(rule, around, rule.heads);
    }

    // What holds around a part of a rule.
    using Around = std::vector<Condition>;
    static Around with(Around around, const std::vector<Condition>& more) {
        around.insert(around.end(), more.begin(), more.end());
        return around;
    }

    // Negations and aggregates. `then` is the consequence of there being no match.
    void parts(const Rule& rule, const Around& around, const std::vector<Clause>& body, const char* then) {
        for (const Clause& c : body) {
            if (c.inner.empty()) continue;
            const Around inside = with(around, conditions(c.inner));
            if (is_forall(c)) {
                const std::vector<Clause>& asked = c.inner.back().inner;
                if (!impossible(rule, inside, asked, Kind::NeverMatches, "so `forall` holds only where there is no such fact"))
                    parts(rule, with(inside, conditions(asked)), asked, "");
            } else if (!impossible(rule, around, c.inner, Kind::NeverMatches,
                                   c.kind == Clause::Kind::Not ? "so `not` always holds" : of_nothing(c, then))) {
                parts(rule, inside, c.inner, "");
            }
        }
    }
    static std::string of_nothing(const Clause& c, const std::string& then) {
        if (c.aggregate == Aggregate::Custom && c.parameter.op != Op::Anonymous) return "so the aggregate always has its initial value";
        const bool of_lists = c.aggregate == Aggregate::Sum && c.test.type.compound();
        const std::string_view value = !of_lists                   ? info(c.aggregate).of_nothing
                                       : c.test.type == Type::Vec3 ? "vec3(0, 0, 0)"
                                                                   : "an empty list";
        if (value.empty()) return "so there is nothing to aggregate" + (then.empty() ? "" : ", " + then);
        if (c.aggregate == Aggregate::Collect) return "so the list is always empty";
        return fmt::format("so the {} is always {}", aggregate_name(c.aggregate), value);
    }

    void parts_of_heads(const Rule& rule, const Around& around, const std::vector<Head>& heads) {
        for (const Head& h : heads) {
            if (h.kind == Head::Kind::If) {
                const std::vector<Condition> condition = conditions(h.term);
                // A bare `false` is intended, or a question of other dialects that has only one answer here.
                const bool asked = h.term.op != Op::Bool;
                const bool never = asked && impossible(rule, around, condition, Kind::NeverMatches, "so `then` gives nothing");
                const bool always = asked && !h.others.empty() && !never &&
                                    impossible(rule, around, {{&h.term, false}}, Kind::NeverMatches, "so `otherwise` produces nothing");
                if (!never) parts_of_heads(rule, with(around, condition), h.heads);
                if (!always) parts_of_heads(rule, with(around, {{&h.term, false}}), h.others);
                continue;
            }
            const bool aggregate = h.kind == Head::Kind::Aggregate;
            if (aggregate || h.kind == Head::Kind::Comprehension) {
                if (impossible(rule, around, h.body, Kind::NeverMatches, aggregate ? "so there is nothing to aggregate" : kHeadOfNothing))
                    continue;
                parts(rule, around, h.body, "");
            }
            parts_of_heads(rule, with(around, conditions(h.body)), h.heads);
            parts_of_heads(rule, around, h.others);
        }
    }
    static constexpr const char* kHeadOfNothing = "so this part of the head produces nothing";

    // A rule that never fires does nothing, so it can go.
    static void suggest_no_rule(const Rule& rule, diagnostics::Diagnostic& d) {
        if (d.kind == Kind::NeverFires) d.fixes = {diagnostics::leave_out(rule.span, "this rule", Fit::Item)};
    }

    // Whether these can never match; reports that, and its consequence.
    bool impossible(const Rule& rule, const Around& around, const std::vector<Clause>& body, Kind kind, const std::string& so) {
        const auto known = with(around, conditions(sizes_of(body)));
        if (impossible(rule, known, conditions(body), kind, so, &body)) return true;
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom) continue;
            if (links_itself(c.atom)) {
                suggest_no_rule(rule, report_.add(kind, c.atom.span, "no catom is its own neighbour, " + so));
                return true;
            }
            if (const Term* nothing = count_of_nothing(c.atom)) {
                const std::string none = "not " + any_of(rule, c.atom);
                auto& d = report_.add(kind, nothing->span, fmt::format("{}, {}", kNoCount, so));
                d.help = fmt::format("write `{}` where there is nothing to count", none);
                if (kind == Kind::NeverFires) d.fixes = {diagnostics::write(c.atom.span, none)};
                return true;
            }
        }
        return false;
    }
    static constexpr const char* kNoCount = "a `count` is at least 1: with nothing to count there is no fact";

    // Where an atom asks for a count, which term does.
    const Term* count_in(const Atom& a) const {
        const Predicate& p = program_.predicates[a.predicate];
        return p.aggregate == Aggregate::Count ? &a.arguments[p.aggregate_at] : nullptr;
    }
    const Term* count_of_nothing(const Atom& a) const {
        const Term* count = count_in(a);
        const auto number = count == nullptr ? std::nullopt : literal(*count);
        return number && *number < 1 ? count : nullptr;
    }
    // N >= 1 for each variable that is a count, as clauses that live as long as this object.
    const std::vector<Clause>& sizes_of(const std::vector<Clause>& body) {
        std::vector<Clause>& sizes = sizes_.emplace_back();
        for (const Clause& c : body) {
            const Term* count = c.kind == Clause::Kind::Atom ? count_in(c.atom) : nullptr;
            if (count == nullptr || !count->is_variable()) continue;
            Term one;
            one.op = Op::Int;
            one.type = Type::Int;
            one.integer = 1;
            one.span = count->span;
            Clause& size = sizes.emplace_back(Clause{.kind = Clause::Kind::Test, .span = count->span});
            size.test.op = Op::GreaterEqual;
            size.test.type = Type::Bool;
            size.test.span = count->span;
            size.test.operands = {*count, one};
        }
        return sizes;
    }
    bool is_size(const Term& test) const {
        return std::any_of(sizes_.begin(), sizes_.end(), [&](const std::vector<Clause>& sizes) {
            return std::any_of(sizes.begin(), sizes.end(), [&](const Clause& c) { return &c.test == &test; });
        });
    }
    // The atom with a wildcard for its count: deg(A, _).
    std::string any_of(const Rule& rule, Atom a) const {
        Term& count = a.arguments[program_.predicates[a.predicate].aggregate_at];
        count = Term{.op = Op::Anonymous, .type = count.type, .span = count.span};
        return print(program_, rule, a);
    }
    bool impossible(const Rule& rule, const Around& around, const std::vector<Condition>& body, Kind kind, std::string so,
                    const std::vector<Clause>* clauses = nullptr) {
        const auto found = contradiction(program_, rule, around, body);
        if (!found) return false;
        const Term& test = *found->test.term;
        // The other side of an `if` in the head of a view.
        const bool denied = test.op == Op::Not && same_place(test.span, test.operands[0].span);
        if (clauses != nullptr && kind == Kind::NeverFires && in_head(*clauses, test)) {
            kind = Kind::NeverMatches;
            so = denied ? "so `otherwise` produces nothing" : kHeadOfNothing;
        }
        const char* others = found->with.empty()       ? ""
                             : found->with.size() == 1 ? " with the other condition"
                                                       : " with the other conditions";
        auto& d = report_.add(kind, test.span,
                              fmt::format("this is {} true{}, {}", denied || !found->test.holds ? "always" : "never", others, so));
        suggest_no_rule(rule, d);
        for (const Term* other : found->with) {
            const bool holds = std::none_of(around.begin(), around.end(), [&](const Condition& c) { return c.term == other && !c.holds; });
            d.labels.push_back({other->span, is_size(*other)           ? "a count, which is at least 1"
                                             : !holds                  ? "where this is not so"
                                             : found->with.size() == 1 ? "the other condition"
                                                                       : "one of the others"});
        }
        return true;
    }
    static bool same_place(source::Span a, source::Span b) { return a.file == b.file && a.begin == b.begin && a.end == b.end; }
    // Views have what their heads ask for in their bodies, under the place of that head.
    static bool in_head(const std::vector<Clause>& body, const Term& test) {
        return std::any_of(body.begin(), body.end(), [&](const Clause& c) {
            bool here = false;
            each_subterm(c.test, [&](const Term& t) { here = here || &t == &test; });
            return here && !same_place(c.span, c.test.span);
        });
    }
    bool links_itself(const Atom& a) const {
        return is_link(program_.predicates[a.predicate].world) && a.arguments[1].is_variable() &&
               a.arguments[0].variable == a.arguments[1].variable;
    }

    // ---- predicates

    void count_uses() {
        made_.assign(program_.predicates.count(), false);
        read_ = given_ = made_;
        for (const Predicate& p : program_.predicates)
            if (p.complete_link.valid()) read_[p.complete_link.index()] = true;
        for (const Rule& rule : program_.rules) {
            const auto read = [&](const Atom& a, bool) { read_[a.predicate.index()] = true; };
            each_atom(rule.body, read);
            each_head(rule.heads, [&](const Head& h) {
                each_atom(h.body, read);
                if (h.kind == Head::Kind::Fact) (rule.linear ? given_ : made_)[h.atom.predicate.index()] = true;
            });
        }
    }
    bool ours(PredicateId p) const { return !program_.predicates[p].prelude && program_.predicates[p].span.file == program_file_; }

    // Every rule of the stratum needs the stratum itself first.
    void nothing_starts(const check::Stratum& c) {
        if (!c.recursive || !ours(c.predicates[0])) return;
        for (const PredicateId p : c.predicates)
            if (given_[p.index()]) return;
        for (const RuleId id : c.rules) {
            bool needs = false;
            each_atom(program_.rules[id].body,
                      [&](const Atom& a, bool negated) { needs = needs || (!negated && c.contains(a.predicate)); });
            if (!needs) return;
        }
        const Predicate& p = program_.predicates[c.predicates[0]];
        report_
            .add(Kind::NeverDerived, p.span,
                 fmt::format("every rule for `{}` needs {} first: nothing starts it", p.name,
                             c.predicates.size() > 1 ? "what it leads to" : "`" + p.name + "`"))
            .help = "add a rule or a fact that does, or give one in the world file";
    }

    static bool alike(const Predicate& a, const Predicate& b) {
        return std::equal(a.arguments.begin(), a.arguments.end(), b.arguments.begin(), b.arguments.end(),
                          [](const Argument& x, const Argument& y) { return x.type == y.type; });
    }

    // Two names for one thing: one is only read, the other only derived.
    void other_name(PredicateId id) {
        const Predicate& p = program_.predicates[id];
        if (!ours(id) || p.sensed || made_[id.index()] || given_[id.index()] || !read_[id.index()]) return;
        std::vector<std::string> lonely;
        for (const PredicateId other : program_.predicates.ids())
            if (ours(other) && (made_[other.index()] || given_[other.index()]) && !read_[other.index()] &&
                program_.predicates[other].kind != PredicateKind::Action && alike(p, program_.predicates[other]))
                lonely.push_back(program_.predicates[other].name);
        const std::string near = diagnostics::nearest_name(p.name, lonely);
        if (near.empty()) return;
        auto& d = report_.add(Kind::NeverDerived, p.span,
                              fmt::format("`{}` is read and never derived, while `{}` is derived and never read", p.name, near));
        for (const Predicate& other : program_.predicates)
            if (other.name == near) d.labels.push_back({other.span, "declared here"});
        d.help = "did you mean one predicate?";
    }

    void unused(PredicateId id) {
        if (!ours(id) || read_[id.index()] || made_[id.index()] || given_[id.index()]) return;
        const Predicate& p = program_.predicates[id];
        auto& d = report_.add(Kind::NeverRead, p.span, fmt::format("`{}` is declared and never used", p.name));
        d.help = "leave out the declaration";
        d.fixes = {diagnostics::leave_out(p.declaration, "the declaration", Fit::Item)};
    }

    void unknown_action(PredicateId id) {
        const Predicate& p = program_.predicates[id];
        if (!ours(id) || p.kind != PredicateKind::Action || (!made_[id.index()] && !given_[id.index()])) return;
        std::vector<std::string> known;
        for (const Predicate& other : program_.predicates)
            if (other.prelude && other.kind == PredicateKind::Action) known.push_back(other.name);
        const std::string near = diagnostics::nearest_name(p.name, known);
        report_
            .add(Kind::UnknownAction, p.span,
                 fmt::format("the runtime has no action `{}`: nothing happens unless a component in C++ carries it out", p.name))
            .help = near.empty() ? "" : fmt::format("did you mean `{}`?", near);
    }

    // ---- functions

    void unused_parameters(const Function& f) {
        if (f.external || f.of_library || f.span.file != program_file_) return;
        std::vector<bool> used(f.variables.count(), false);
        each_free_use(f.body, [&](const Term& t) { used[t.variable.index()] = true; });
        for (std::size_t i = 0; i < f.parameter_count; ++i) {
            const Variable& v = f.variables[VariableId(i)];
            if (used[i] || v.name.starts_with("_")) continue;
            auto& d = report_.add(Kind::UnusedParameter, v.span, fmt::format("the parameter `{}` of `{}` is never used", v.name, f.name));
            d.help = fmt::format("leave it out, or name it `_{}` if the function must have it", v.name);
            d.fixes = {diagnostics::write(v.span, "_" + v.name)};
        }
    }

    const Program& program_;
    std::uint32_t program_file_;
    diagnostics::Reporter& report_;
    std::deque<std::vector<Clause>> sizes_;  // What is known of counts.
    std::vector<bool> read_, made_, given_;  // By predicate: in a body; the head of a view; the head of a linear rule.
};

}  // namespace

void warn_of_useless(const Program& program, std::uint32_t program_file, diagnostics::Reporter& report) {
    Useless(program, program_file, report).run();
}

}  // namespace meld::lint
