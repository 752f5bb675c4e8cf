// Pass 2, names of predicates: which one a fact of a rule means, the cure where there is none, and its sign.
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "compiler/check/program/library.h"
#include "compiler/check/rules/resolver.h"
#include "runtime/module/abi/actions.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

std::optional<PredicateId> Resolver::find(const syntax::Atom& atom, Part part) {
    const auto found = names_.predicates.find({atom.name.text, atom.arguments.size()});
    if (found != names_.predicates.end()) {
        if (!program_.predicates[found->second].refused) return found->second;
        refused_ = true;
        return std::nullopt;
    }
    if (names_.tree.is_lost(atom.name.text)) {
        refused_ = true;
        return std::nullopt;
    }
    if (const std::string_view standard = standard_word(atom.name.text); !standard.empty())
        if (const auto action = names_.predicates.find({std::string(standard), atom.arguments.size()}); action != names_.predicates.end())
            return action->second;
    // There may be several of the name.
    std::string counts;
    std::size_t last = 0;
    std::vector<diagnostics::Label> declared;
    for (const auto& [key, id] : names_.predicates) {
        if (key.first != atom.name.text) continue;
        last = program_.predicates[id].arguments.size();
        counts += (counts.empty() ? "" : " or ") + std::to_string(last);
        declared.push_back({program_.predicates[id].span, "declared here"});
    }
    if (!declared.empty()) {
        auto& d = report_.add(Kind::ArityMismatch, atom.span,
                              fmt::format("`{}` has {} argument{}, and here {} {}", atom.name.text, counts, last == 1 ? "" : "s",
                                          atom.arguments.size() == 1 ? "is" : "are", atom.arguments.size()));
        d.labels = declared;
        if (part == Part::Body) suggest_more_arguments(atom, d);
        return std::nullopt;
    }
    const Unknown unknown = unknown_predicate(atom.name, atom.arguments.size(), part);
    std::vector<Type> types;
    for (const auto& argument : atom.arguments) types.push_back(scope_->infer(*argument));
    if (unknown.may_be_declared) later_.add_use(unknown.message, atom.name, types, consumed(atom, part));
    return std::nullopt;
}

LaterFixes::Consumed Resolver::consumed(const syntax::Atom& atom, Part part) const {
    using Consumed = LaterFixes::Consumed;
    if (atom.sigil == syntax::Sigil::Linear || atom.sigil == syntax::Sigil::Read) return Consumed::Certainly;
    if (part == Part::Head || tree_->arrow != syntax::Arrow::Linear) return Consumed::Perhaps;
    const bool other = std::any_of(tree_->body.begin(), tree_->body.end(), [&](const syntax::Clause& clause) {
        const auto* fact = std::get_if<syntax::Atom>(&clause.node);
        const auto found = fact == nullptr ? names_.predicates.end() : names_.predicates.find({fact->name.text, fact->arguments.size()});
        return found != names_.predicates.end() && program_.predicates[found->second].linear();
    });
    return other ? Consumed::Perhaps : Consumed::Certainly;
}

// `_` for the arguments that are missing, where any value will do.
void Resolver::suggest_more_arguments(const syntax::Atom& atom, diagnostics::Diagnostic& d) const {
    const auto more = names_.predicates.upper_bound({atom.name.text, atom.arguments.size()});
    // stable(p(A), 5) ends elsewhere than p(A).
    const bool written = atom.name.span.begin <= atom.span.begin + 2 && files_.text(atom.span).ends_with(')');
    if (more == names_.predicates.end() || more->first.first != atom.name.text || atom.arguments.empty() || !written) return;
    std::string missing;
    for (std::size_t i = atom.arguments.size(); i < more->first.second; ++i) missing += ", _";
    d.fixes = {diagnostics::insert({atom.span.file, atom.span.end - 1, atom.span.end - 1}, std::move(missing))};
}

// What to write for words of other machines and libraries, which nobody means to declare.
bool Resolver::cure_of_another_machine(const syntax::Name& name, std::optional<std::size_t> arguments, Part part,
                                       diagnostics::Diagnostic& d) const {
    if (name.text == "stable") d.help = "in a body, write `stable(p(A), 5)`: p(A) has held for 5 ticks";
    if (name.text == "terminate") {
        d.help = "to end the run, write `stop-program(A)`";
        if (arguments == 1u) d.fixes = {diagnostics::write(name.span, "stop-program")};
    }
    if (is_older(name.text)) d.help = kUseOlder;
    if (part == Part::Head && name.text == "setPosition")
        d.help =
            "a catom does not say where it is. On a lattice it moves to a cell by `moveTo(A, X, Y, Z)`, where it is a body by forces and\n"
            "torques: `force(A, X, Y, Z)`";
    if (const MachineState* state = machine_state(name.text); state != nullptr && part == Part::Body) {
        d.message = fmt::format("`{}` tells of the machine of Linear Meld, and there is none here", name.text);
        d.help = state->cure;
        const bool awaited = std::ranges::any_of(tree_->body, [&](const syntax::Clause& c) {
            const auto* fact = std::get_if<syntax::Atom>(&c.node);
            return fact != nullptr && fact->name.span.begin == name.span.begin;
        });
        if (state->never && awaited) d.fixes = {diagnostics::leave_out(tree_->span, "the rule", Fit::Item)};
    }
    return !d.help.empty();
}

// A predicate of nearly this name that can stand there. The program's own come before those that it did not declare, and those with as many
// arguments before others; nobody derives what is sensed, or reads an action.
std::string Resolver::nearest_predicate(const std::string& name, std::optional<std::size_t> arguments, Part part) const {
    for (const bool alike : {true, false})
        for (const bool own : {true, false}) {
            std::vector<std::string> known;
            for (const auto& [key, id] : names_.predicates) {
                const Predicate& p = program_.predicates[id];
                const bool fits = part == Part::Head ? !p.sensed : p.kind != PredicateKind::Action;
                if (fits && p.prelude != own && (!alike || !arguments || key.second == *arguments)) known.push_back(key.first);
            }
            if (std::string near = diagnostics::nearest_name(name, known); !near.empty()) return near;
        }
    return "";
}

// For a question, which cannot declare anything.
std::string Resolver::declared_names() const {
    constexpr std::size_t kShown = 8;
    std::set<std::string> names;
    for (const auto& [key, id] : names_.predicates)
        if (!program_.predicates[id].prelude) names.insert("`" + key.first + "`");
    if (names.empty()) return "the program declares none of its own";
    const std::vector<std::string> shown(names.begin(),
                                         std::next(names.begin(), static_cast<std::ptrdiff_t>(std::min(kShown, names.size()))));
    return fmt::format("the program declares {}{}", fmt::join(shown, ", "),
                       names.size() > kShown ? fmt::format(" and {} more", names.size() - kShown) : "");
}

Resolver::Unknown Resolver::unknown_predicate(const syntax::Name& name, std::optional<std::size_t> arguments, Part part) {
    auto& d = report_.add(Kind::UnknownPredicate, name.span, fmt::format("there is no predicate `{}`", name.text));
    if (cure_of_another_machine(name, arguments, part, d)) return {d, false};
    const std::string near = nearest_predicate(name.text, arguments, part);
    if (near.empty() && tree_->arrow == syntax::Arrow::Question)
        d.help = declared_names();
    else if (near.empty())
        d.help = fmt::format("{}`type {}(node{}).`", kDeclareIt, name.text, arguments.value_or(2) > 1 ? ", ..." : "");
    else if (!arguments || names_.predicates.contains({near, *arguments}))
        d.did_you_mean(near, name.span, Fit::Name);
    else
        d.help = fmt::format("did you mean `{}`?", near);
    return {d, tree_->arrow != syntax::Arrow::Question};
}

void Resolver::sigil(const syntax::Atom& tree, const Predicate& p) {
    using syntax::Sigil;
    // Original Meld's mark of linear facts; in a view there is a message for it.
    if ((!dialect_linear_ || tree_->arrow == syntax::Arrow::View) && tree.sigil == Sigil::Persistent) return;
    const bool wrong =
        (tree.sigil == Sigil::Persistent && p.linear()) || ((tree.sigil == Sigil::Linear || tree.sigil == Sigil::Read) && !p.linear());
    if (!wrong) return;
    auto& d = report_.add(
        Kind::SigilMismatch, tree.span,
        fmt::format("`{}` is declared {}, and the sign before it says otherwise", p.name, p.linear() ? "linear" : "persistent"));
    d.labels = {{p.span, "declared here"}};
    d.help = fmt::format("write `{}({})`", p.name, tree.arguments.size() > 1 ? "..." : "A");
    d.fixes = {safe(diagnostics::leave_out({tree.span.file, tree.span.begin, tree.span.begin + 1}, "the sign", Fit::Word))};
}

void Resolver::find_signs() {
    for (const syntax::Item& item : names_.tree.items) {
        const auto* rule = std::get_if<syntax::Rule>(&item);
        if (rule == nullptr) continue;
        for (const syntax::HeadItem& head : rule->head) {
            const auto* fact = std::get_if<syntax::HeadFact>(&head.node);
            if (fact == nullptr || fact->atom.sigil != syntax::Sigil::Persistent) continue;
            const auto found = names_.predicates.find({fact->atom.name.text, fact->atom.arguments.size()});
            persistent_marked_ = persistent_marked_ || (found != names_.predicates.end() && !program_.predicates[found->second].linear());
        }
    }
}

// In a file without `-o`, `!p` of a persistent p means `not p`, unless the program marks persistent facts by `!`, as Linear Meld does.
void Resolver::not_a_negation(const syntax::Atom& tree, const Predicate& p) {
    if (dialect_linear_ || tree.sigil != syntax::Sigil::Persistent || p.linear()) return;
    if (persistent_marked_) {
        diagnostics::Fix leave_out =
            safe(diagnostics::leave_out({tree.span.file, tree.span.begin, tree.span.begin + 1}, "the sign", Fit::Word));
        if (sign_note_ != nullptr) {
            sign_note_->fixes.front().edits.push_back(std::move(leave_out.edits.front()));
            return;
        }
        sign_note_ =
            &report_.add(Kind::NeedlessSign, tree.span,
                         fmt::format("`!` before `{}` says that it is persistent, as in Linear Meld; it does not negate it", p.name));
        sign_note_->labels = {{p.span, "declared here, persistent"}};
        sign_note_->help = fmt::format("leave the sign out; where `{0}` must not hold, write `not {0}(...)`", p.name);
        sign_note_->fixes = {std::move(leave_out)};
        return;
    }
    auto& d = report_.add(Kind::SigilMismatch, tree.span, fmt::format("`!` before `{}` does not negate it", p.name));
    d.labels = {{p.span, "declared here, persistent"}};
    const std::string atom = tree.arguments.size() > 1 ? p.name + "(...)" : p.name + "(A)";
    d.help = fmt::format("write `not {0}` where it does not hold, `{0}` where it does", atom);
    const Span mark{tree.span.file, tree.span.begin, tree.span.begin + 1};
    d.fixes = {diagnostics::write(mark, "not "), diagnostics::leave_out(mark, "the sign", Fit::Word)};
    d.fixes.front().title = fmt::format("Write `not {}`", atom);
}

}  // namespace meld::check
