// After modules: `stable(p(A, X), 5)` in a body becomes an atom of a separate predicate, declared here with the rule
//     p@stable5(A, X)@+5 :- p(A, X).
// So a fact is stable for n ticks once it has held for that long without interruption.
#include <algorithm>
#include <map>
#include <set>

#include "compiler/check/check.h"
#include "compiler/check/names/each_name.h"
#include "compiler/syntax/stable_name.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

class Stable {
  public:
    Stable(syntax::Tree& tree, diagnostics::Reporter& report) : tree_(tree), report_(report) {}

    void run() {
        for (std::size_t i = 0; i < tree_.items.size(); ++i)
            if (const auto* d = std::get_if<syntax::Declaration>(&tree_.items[i]))
                declared_.emplace(std::pair(d->name.text, d->arguments.size()), i);
        // A program may have a predicate of that name.
        if (declared_.contains({"stable", 2})) return;
        for (std::size_t i = 0, end = tree_.items.size(); i < end; ++i) {
            auto* rule = std::get_if<syntax::Rule>(&tree_.items[i]);
            if (rule == nullptr) continue;
            unit_ = tree_.unit_of[i];
            clauses(rule->body);
            heads(rule->head);
        }
        for (auto& [item, unit] : made_) {
            tree_.items.push_back(std::move(item));
            tree_.unit_of.push_back(unit);
        }
    }

  private:
    void clauses(std::vector<syntax::Clause>& all) {
        for (syntax::Clause& c : all) {
            if (auto* atom = std::get_if<syntax::Atom>(&c.node)) expand(*atom);
            if (auto* none = std::get_if<syntax::Not>(&c.node)) clauses(none->clauses);
            if (auto* all_of = std::get_if<syntax::Forall>(&c.node)) {
                expand(all_of->atom);
                clauses(all_of->clauses);
            }
            if (auto* aggregate = std::get_if<syntax::BodyAggregate>(&c.node)) clauses(aggregate->clauses);
        }
    }
    void heads(std::vector<syntax::HeadItem>& all) {
        for (syntax::HeadItem& h : all) {
            if (auto* every = std::get_if<syntax::Comprehension>(&h.node)) {
                clauses(every->body);
                heads(every->head);
            }
            if (auto* aggregate = std::get_if<syntax::RuleAggregate>(&h.node)) clauses(aggregate->body);
            if (auto* exists = std::get_if<syntax::Exists>(&h.node)) heads(exists->head);
            if (auto* choice = std::get_if<syntax::HeadIf>(&h.node)) {
                heads(choice->then_head);
                heads(choice->else_head);
            }
        }
    }

    void expand(syntax::Atom& atom) {
        syntax::Call* fact = stable_fact(atom);
        if (fact == nullptr) return;
        const auto* ticks = std::get_if<syntax::IntLiteral>(&atom.arguments[1]->node);
        const Span place = atom.arguments[1]->span;
        syntax::Atom plain{
            .sigil = atom.sigil, .name = {fact->name, atom.arguments[0]->span}, .arguments = std::move(fact->arguments), .span = atom.span};
        const auto found = declared_.find({plain.name.text, plain.arguments.size()});
        if (ticks == nullptr || ticks->value < 1) {
            auto& d = report_.add(Kind::BadDelay, place, "a fact is stable for a number of ticks, at least one");
            d.help = "write the number, as in `stable(p(A), 5)`";
            if (ticks != nullptr) d.fixes = {diagnostics::write(place, "1")};
        } else if (found != declared_.end())
            plain.name.text = predicate(std::get<syntax::Declaration>(tree_.items[found->second]), ticks->value, atom.span);
        // Where there is no such predicate the resolver says so.
        atom = std::move(plain);
    }
    static bool has(const syntax::Declaration& d, const char* modifier) {
        return std::any_of(d.modifiers.begin(), d.modifiers.end(), [&](const syntax::Name& m) { return m.text == modifier; });
    }

    // The name of the predicate that holds if p has held for that long.
    std::string predicate(const syntax::Declaration& p, std::int64_t ticks, Span span) {
        const std::string name = syntax::stable_name(p.name.text, ticks);
        for (const char* kind : {"linear", "action"}) {
            if (!has(p, kind)) continue;
            report_
                .add(Kind::LinearInView, span,
                     fmt::format("`{}` is {} {}, and only what holds for a time can be stable", p.name.text, *kind == 'a' ? "an" : "a",
                                 *kind == 'a' ? kind : "linear fact"))
                .labels = {{p.name.span, "declared here"}};
            tree_.lost.insert(name);
            return name;
        }
        if (!known_.insert({name, p.arguments.size()}).second) return name;
        const bool route = has(p, "route") || has(p, "neighbor");
        syntax::Declaration declaration{.modifiers = route ? std::vector<syntax::Name>{{"route", span}} : std::vector<syntax::Name>{},
                                        .name = {name, span},
                                        .arguments = {},
                                        .repeats = false,
                                        .span = span};
        for (const syntax::Argument& a : p.arguments) {
            syntax::Argument plain;
            plain.type = a.type;
            plain.name = a.name;
            plain.span = span;
            declaration.arguments.push_back(std::move(plain));
        }
        syntax::Rule rule;
        rule.span = span;
        rule.head.push_back({syntax::HeadFact{atom_of(name, p.arguments.size(), span),
                                              syntax::Delay{static_cast<double>(ticks), syntax::Delay::Unit::Ticks, span}},
                             span});
        rule.body.push_back({atom_of(p.name.text, p.arguments.size(), span), span});
        made_.emplace_back(std::move(declaration), unit_);
        made_.emplace_back(std::move(rule), unit_);
        return name;
    }
    static syntax::Atom atom_of(const std::string& name, std::size_t arguments, Span span) {
        syntax::Atom atom{.sigil = syntax::Sigil::None, .name = {name, span}, .arguments = {}, .span = span};
        for (std::size_t i = 0; i < arguments; ++i) {
            auto e = std::make_unique<syntax::Expr>();
            e->node = syntax::Variable{i == 0 ? "A" : "X" + std::to_string(i)};
            e->span = span;
            atom.arguments.push_back(std::move(e));
        }
        return atom;
    }

    syntax::Tree& tree_;
    diagnostics::Reporter& report_;
    std::map<std::pair<std::string, std::size_t>, std::size_t> declared_;
    std::set<std::pair<std::string, std::size_t>> known_;
    std::vector<std::pair<syntax::Item, std::uint32_t>> made_;
    std::uint32_t unit_ = 0;
};

}  // namespace

void expand_stable(syntax::Tree& tree, diagnostics::Reporter& report) { Stable(tree, report).run(); }

}  // namespace meld::check
