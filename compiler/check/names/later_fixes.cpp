#include "compiler/check/names/later_fixes.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "compiler/syntax/tokens.h"
#include "runtime/base/assert.h"

namespace meld::check {

using Fit = diagnostics::Edit::Fit;

namespace {

// A small name as that of a variable, which has no hyphens.
std::string capital(std::string name) {
    name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

// Where nothing tells a type, int is the most likely.
Type guessed(Type type) {
    if (type == Type::Error) return Type::Int;
    for (Type& part : type.parts) part = guessed(std::move(part));
    return type;
}

}  // namespace

LaterFixes::LaterFixes(const source::FileSet& files, const Names& names) : files_(files), names_(names) {
    for (const syntax::Item& item : names.tree.items) {
        const auto* d = std::get_if<syntax::Declaration>(&item);
        const Span span = std::visit([](const auto& one) { return one.span; }, item);
        // No program can write such a name: expand_stable() did.
        if (d != nullptr && d->name.text.find('@') == std::string::npos)
            places_[span.file] = {span, "", Fit::After};
        else
            places_.try_emplace(span.file, diagnostics::Edit{span, "", Fit::Before});
    }
}

diagnostics::Edit LaterFixes::declaration(Span user, std::string text) const {
    const auto place = places_.find(user.file);
    MELD_EXPECT(place != places_.end(), "file {} has a rule and no items", user.file);
    diagnostics::Edit edit = place->second;
    edit.text = std::move(text);
    return edit;
}

// ---- unknown predicates

void LaterFixes::add_use(diagnostics::Diagnostic& message, const syntax::Name& name, const std::vector<Type>& arguments,
                         Consumed consumed) {
    Unknown& known = unknown_.try_emplace({name.text, arguments.size()}, Unknown{.arguments = arguments}).first->second;
    known.messages.emplace_back(&message, name.span);
    known.linear = known.linear || consumed == Consumed::Certainly;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::optional<Type> both = join(known.arguments[i], arguments[i]);
        known.fits = known.fits && both;
        if (both) known.arguments[i] = *both;
    }
}

void LaterFixes::declare(const Unknown& unknown) const {
    // A fact lives at its first argument.
    if (unknown.arguments.empty() || !unknown.fits || !same(unknown.arguments[0], Type::Node)) return;
    std::string arguments = "node";
    for (std::size_t i = 1; i < unknown.arguments.size(); ++i) arguments += ", " + type_name(guessed(unknown.arguments[i]));
    for (const auto& [message, name] : unknown.messages) {
        const std::string text =
            fmt::format("type {}{}({}).", unknown.linear ? "linear " : "", diagnostics::name_at(files_, name), arguments);
        if (message->help.starts_with(kDeclareIt)) message->help = fmt::format("{}`{}`", kDeclareIt, text);
        message->fixes.push_back({.title = fmt::format("Declare `{}`", text), .edits = {declaration(name, text)}});
    }
}

// ---- variables of original Meld

void LaterFixes::add_small_variables(diagnostics::Diagnostic& message, Span rule, std::set<std::string> names) {
    small_ = &message;
    if (rule.file == message.span.file) small_variables_[rule.begin] = std::move(names);
}

// The message is about the first variable of a program; a fix of that one alone would only move the message to the next.
void LaterFixes::write_capitals() const {
    if (small_ == nullptr) return;
    const auto is_predicate = [&](const std::string& name) {
        const auto found = names_.predicates.lower_bound({name, 0});
        return found != names_.predicates.end() && found->first.first == name;
    };
    diagnostics::Reporter unheard;
    const std::vector<syntax::Token> tokens = syntax::scan(files_.file(small_->span), small_->span.file, unheard);
    diagnostics::Fix fix{.title = "Write the variables of this file with a capital", .edits = {}, .safe = true};
    const std::set<std::string>* names = nullptr;
    std::set<std::string> others;
    for (std::size_t i = 0; i + 1 < tokens.size(); ++i) {
        const syntax::Token& token = tokens[i];
        if (const auto rule = small_variables_.find(token.span.begin); rule != small_variables_.end()) names = &rule->second;
        if (names == nullptr) continue;
        if (token.kind == syntax::TokenKind::Variable) others.insert(token.text);
        if (token.kind == syntax::TokenKind::Name && names->contains(token.text) && tokens[i + 1].kind != syntax::TokenKind::LeftParen)
            fix.edits.push_back({token.span, capital(token.text)});
        if (token.kind != syntax::TokenKind::Period) continue;
        // Two variables must not become one, nor a variable a constant.
        std::set<std::string> made;
        for (const std::string& name : *names) {
            const std::string text = capital(name);
            // A difference without blanks, n-1, has a message and a fix of its own.
            if (names->contains(name.substr(0, name.find('-'))) && name.find('-') != std::string::npos) return;
            if (!made.insert(text).second || others.contains(text) || names_.constants.contains(text)) return;
            // In proved(a, p) it is the predicate that is meant.
            if (is_predicate(name)) return;
        }
        names = nullptr;
        others.clear();
    }
    small_->fixes = {std::move(fix)};
}

void LaterFixes::finish() const {
    for (const auto& [key, unknown] : unknown_) declare(unknown);
    write_capitals();
}

}  // namespace meld::check
