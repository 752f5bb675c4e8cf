// Several programs in one tree, for catoms that run different rules over the same predicates. They share all names: what two of them
// declare must be the same, and is kept once. A rule of a file that not every program includes gets one more condition, that its catom runs
// one of the programs that do; so all later stages, and everything that explains a run, know nothing of several programs.
//
// merge_programs() works on the tree before names are resolved, guard_programs() on rules that know where they run.
#include <algorithm>
#include <bit>
#include <map>
#include <string>
#include <utility>

#include "compiler/check/check.h"
#include "compiler/syntax/parse.h"
#include "compiler/syntax/stable_name.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

constexpr std::string_view kGuard = "runs-program";

// ---- declarations

// What is declared, as a program writes it; the names of arguments say nothing.
std::string declared(const syntax::Declaration& d) {
    syntax::Declaration plain = d;
    std::ranges::sort(plain.modifiers, {}, &syntax::Name::text);
    for (syntax::Argument& argument : plain.arguments) argument.name.reset();
    return syntax::print(plain);
}

class Merger {
  public:
    Merger(syntax::Tree& tree, diagnostics::Reporter& report) : tree_(tree), report_(report) {}

    void run() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < tree_.items.size(); ++i) {
            if (std::visit([&](auto& item) { return again(item, i); }, tree_.items[i])) continue;
            if (kept != i) {
                tree_.items[kept] = std::move(tree_.items[i]);
                tree_.unit_of[kept] = tree_.unit_of[i];
            }
            ++kept;
        }
        tree_.items.resize(kept);
        tree_.unit_of.resize(kept);
    }

  private:
    struct First {
        std::uint64_t programs;
        Span name;
        std::string text;
    };

    bool again(const syntax::Declaration& d, std::size_t i) {
        return again(i, fmt::format("{}/{}", d.name.text, d.arguments.size()), d.name, declared(d));
    }
    bool again(const syntax::Constant& c, std::size_t i) { return again(i, "const", c.name, printed(i)); }
    bool again(const syntax::Function& f, std::size_t i) { return again(i, "fun", f.name, printed(i)); }
    bool again(const syntax::Extern& e, std::size_t i) { return again(i, "extern", e.name, printed(i)); }
    bool again(const syntax::Alias& a, std::size_t i) { return again(i, "type", a.name, printed(i)); }
    bool again(const syntax::NodeKind& k, std::size_t i) { return again(i, "type", k.name, printed(i)); }
    template <class Other>
    bool again(const Other&, std::size_t) {
        return false;
    }

    std::string printed(std::size_t i) {
        syntax::Tree one;
        one.units.emplace_back();
        one.add(std::move(tree_.items[i]), 0);
        std::string text = syntax::print(one);
        tree_.items[i] = std::move(one.items.front());
        return text;
    }

    // Whether another program has declared it before.
    bool again(std::size_t i, const std::string& sort, const syntax::Name& name, std::string text) {
        const std::uint32_t file = name.span.file;
        if (tree_.unit_of[i] != 0 || file >= tree_.programs_of.size() || tree_.programs_of[file] == 0) return false;
        const std::uint64_t programs = tree_.programs_of[file];
        const auto [place, is_first] = first_.emplace(std::pair(sort, name.text), First{programs, name.span, text});
        // Twice in one program is a mistake that others report.
        if (is_first || (place->second.programs & programs) != 0) return false;
        place->second.programs |= programs;
        if (place->second.text == text) return true;
        const bool predicate = sort.find('/') != std::string::npos;
        auto& d = report_.add(Kind::DuplicateDeclaration, name.span,
                              fmt::format("this program declares `{}` differently from another one of the same ensemble", name.text));
        d.labels = {{place->second.name, "declared here"}};
        d.help = predicate ? "declare it in the same words in both, or once in a file that both include"
                           : "give one of the two another name, or define it once in a file that both include";
        return true;
    }

    syntax::Tree& tree_;
    diagnostics::Reporter& report_;
    std::map<std::pair<std::string, std::string>, First> first_;
};

// ---- rules

class Guard {
  public:
    Guard(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report)
        : programs_of_(tree.programs_of), program_(program), report_(report) {
        for (const std::uint64_t programs : programs_of_) all_ |= programs;
    }

    void run() {
        for (const PredicateId p : program_.predicates.ids())
            if (program_.predicates[p].name == kGuard && program_.predicates[p].arguments.size() == 2) number_ = p;
        MELD_CHECK(number_.valid(), "the prelude has no {}", kGuard);
        if (!program_.predicates[number_].prelude) {
            report_
                .add(Kind::SensedMismatch, program_.predicates[number_].span,
                     fmt::format("`{}` says which of several programs a catom runs, and is declared here as another predicate", kGuard))
                .help = "give it another name";
            return;
        }
        for (Rule& rule : program_.rules) {
            const std::uint64_t programs = rule.span.file < programs_of_.size() ? programs_of_[rule.span.file] : 0;
            if (rule.refused || !rule.site.valid() || programs == 0 || programs == all_ || is_shared(rule)) continue;
            std::vector<Clause> body = guard(rule, programs);
            std::ranges::move(rule.body, std::back_inserter(body));
            rule.body = std::move(body);
        }
    }

  private:
    // Several programs may ask whether one fact is stable: the first of them that does makes the rule.
    bool is_shared(const Rule& rule) const {
        return std::ranges::any_of(rule.derives,
                                   [&](PredicateId p) { return syntax::read_stable_name(program_.predicates[p].name).has_value(); });
    }

    Term term(Op op, Type type, Span span) const { return {.op = op, .type = std::move(type), .span = span}; }
    Term number(int value, Span span) const {
        Term out = term(Op::Int, Type::Int, span);
        out.integer = value;
        return out;
    }

    // runs-program(A, 2), or runs-program(A, P), P = 0 || P = 2.
    std::vector<Clause> guard(Rule& rule, std::uint64_t programs) {
        const Span span = rule.span;
        Clause fact{.kind = Clause::Kind::Atom, .span = span};
        fact.atom.predicate = number_;
        fact.atom.span = span;
        Term place = term(Op::Variable, Type::Node, span);
        place.variable = rule.site;
        if (std::has_single_bit(programs)) {
            fact.atom.arguments = {std::move(place), number(std::countr_zero(programs), span)};
            return {std::move(fact)};
        }
        Term runs = term(Op::Variable, Type::Int, span);
        runs.variable = rule.variables.add({"_Program", span, Type::Int});
        fact.atom.arguments = {std::move(place), runs};
        Clause one_of{.kind = Clause::Kind::Test, .span = span};
        for (int i = 0; i < 64; ++i) {
            if ((programs >> i & 1) == 0) continue;
            Term same = term(Op::Equal, Type::Bool, span);
            same.operands = {runs, number(i, span)};
            if (one_of.test.op == Op::Anonymous) {
                one_of.test = std::move(same);
                continue;
            }
            Term either = term(Op::Or, Type::Bool, span);
            either.operands = {std::move(one_of.test), std::move(same)};
            one_of.test = std::move(either);
        }
        return {std::move(fact), std::move(one_of)};
    }

    const std::vector<std::uint64_t>& programs_of_;
    Program& program_;
    diagnostics::Reporter& report_;
    std::uint64_t all_ = 0;
    PredicateId number_;
};

}  // namespace

void merge_programs(syntax::Tree& tree, diagnostics::Reporter& report) {
    if (!tree.programs_of.empty()) Merger(tree, report).run();
}

void guard_programs(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report) {
    if (!tree.programs_of.empty()) Guard(tree, program, report).run();
}

}  // namespace meld::check
