// Before pass 1: type names. Replaces the names of `type list int vector.` and `node page.` by their types, so that later passes see only
// types. Assumes separate_modules(): every name means one type.
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "compiler/check/check.h"
#include "compiler/check/names/each_name.h"
#include "compiler/check/program/types.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

bool is_type_word(const std::string& word) {
    static const std::set<std::string> words = {"bool", "int",  "float", "string", "node",  "catom",  "module",
                                                "addr", "vec3", "list",  "set",    "array", "struct", "tuple"};
    return words.contains(word);
}

// Names may double the size of their type again and again; a type is copied to each of its uses.
constexpr std::size_t kMaxTypeParts = 1000;

std::size_t parts_of(const syntax::Type& t) {
    std::size_t parts = 1;
    for (const syntax::Type& part : t.arguments) parts += parts_of(part);
    return parts;
}

class TypeNameExpansion {
  public:
    TypeNameExpansion(syntax::Tree& tree, diagnostics::Reporter& report) : tree_(tree), report_(report) {}

    void run() {
        for (syntax::Item& item : tree_.items) {
            if (auto* a = std::get_if<syntax::Alias>(&item)) add(a->name, &a->type, a->span);
            if (auto* k = std::get_if<syntax::NodeKind>(&item)) add(k->name, nullptr, k->span);
            if (auto* e = std::get_if<syntax::Extern>(&item); e != nullptr && !e->result) handles_.insert(e->name.text);
        }
        for (auto& [name, alias] : aliases_) expand(name);
        for (const auto& [name, alias] : aliases_) must_be_known(alias.type);
        EachName<TypeNameExpansion> walk(*this);
        for (syntax::Item& item : tree_.items) {
            if (std::holds_alternative<syntax::Alias>(item)) continue;
            walk.item(item);
            if (auto* d = std::get_if<syntax::Declaration>(&item)) drop_type_before_name(*d);
        }
    }

    void predicate(const syntax::Name&, std::optional<std::size_t>) {}
    void constant(const std::string&, Span) {}
    void capital(const syntax::Expr&) {}
    void function(const std::string&, Span) {}
    void type(syntax::Type& t) {
        const auto found = t.arguments.empty() ? aliases_.find(t.name) : aliases_.end();
        if (found == aliases_.end()) return;
        const Span use = t.span;
        // Inside a name that means itself.
        if (found->second.state == State::Busy) {
            recursive(found->first, use);
            t = {"int", {}, use};
            return;
        }
        if (open_ >= kMaxTypeParts) {
            too_large(found->first);
            t = {"int", {}, use};
            return;
        }
        expand(found->first);
        t = found->second.type;
        at(t, use);
    }

  private:
    enum class State { Waiting, Busy, Done };
    struct Alias {
        syntax::Type type;
        Span span;
        State state = State::Waiting;
    };

    void add(const syntax::Name& name, const syntax::Type* type, Span item) {
        if (is_type_word(name.text)) {
            report_.add(Kind::DuplicateDeclaration, name.span, fmt::format("`{}` is a type already", name.text)).help =
                "choose another name";
            return;
        }
        // A kind of nodes is a name for node.
        Alias alias{type != nullptr ? *type : syntax::Type{"node", {}, name.span}, name.span,
                    type != nullptr ? State::Waiting : State::Done};
        const auto [place, first] = aliases_.emplace(name.text, std::move(alias));
        if (first) return;
        auto& d = report_.add(Kind::DuplicateDeclaration, name.span, fmt::format("the type name `{}` is declared twice", name.text));
        d.labels = {{place->second.span, "first declared here"}};
        d.fixes = {diagnostics::leave_out(item, "this declaration", Fit::Item)};
    }

    void expand(const std::string& name) {
        Alias& alias = aliases_.at(name);
        if (alias.state != State::Waiting) return;
        alias.state = State::Busy;
        EachName<TypeNameExpansion> walk(*this);
        ++open_;
        walk.type(alias.type);
        --open_;
        if (parts_of(alias.type) > kMaxTypeParts) {
            too_large(name);
            alias.type = {"int", {}, alias.span};
        }
        alias.state = State::Done;
    }

    // Reported once: types built on it would be too large as well.
    void too_large(const std::string& name) {
        if (std::exchange(is_too_large_, true)) return;
        report_
            .add(Kind::NestingTooDeep, aliases_.at(name).span,
                 fmt::format("the type `{}` is built from more than {} types", name, kMaxTypeParts))
            .help = "split it into the arguments of several predicates";
    }

    // A name for a type that nobody knows; where the name is used, the same is said of the use.
    void must_be_known(const syntax::Type& t) {
        for (const syntax::Type& part : t.arguments) must_be_known(part);
        if (is_type_word(t.name) || handles_.contains(t.name) || tree_.is_lost(t.name)) return;
        std::vector<std::string> names{"bool", "int", "float", "string", "node", "vec3"};
        for (const auto& [name, alias] : aliases_) names.push_back(name);
        suggest_type(report_.add(Kind::UnknownType, t.span, fmt::format("there is no type `{}`", t.name)), t.name, names);
    }

    void recursive(const std::string& name, Span use) {
        auto& d = report_.add(Kind::RecursiveTypeName, aliases_.at(name).span, fmt::format("the type `{}` means itself", name));
        d.labels = {{use, fmt::format("`{}` is needed here", name)}};
        d.help = "a type is built from int, float, bool, node, string, lists, sets, arrays and structs of these";
    }

    // `type vector p(node, int).`: the arguments have their own types.
    void drop_type_before_name(syntax::Declaration& d) {
        for (std::size_t i = 0; i < d.modifiers.size();) {
            if (!aliases_.contains(d.modifiers[i].text)) {
                ++i;
                continue;
            }
            auto& ignored = report_.add(Kind::HintIgnored, d.modifiers[i].span,
                                        fmt::format("`{}` has no effect before the predicate", d.modifiers[i].text));
            ignored.help = "the types of the arguments go between the brackets";
            ignored.fixes = {safe(diagnostics::leave_out(ignored.span, fmt::format("`{}`", d.modifiers[i].text), Fit::Word))};
            d.modifiers.erase(d.modifiers.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }

    // Messages about a use of the name point at the use.
    static void at(syntax::Type& t, Span span) {
        t.span = span;
        for (syntax::Type& part : t.arguments) at(part, span);
    }

    syntax::Tree& tree_;
    diagnostics::Reporter& report_;
    std::map<std::string, Alias> aliases_;
    std::set<std::string> handles_;  // extern type handle.
    std::size_t open_ = 0;           // Names that are being expanded inside of each other.
    bool is_too_large_ = false;
};

}  // namespace

void expand_type_names(syntax::Tree& tree, diagnostics::Reporter& report) { TypeNameExpansion(tree, report).run(); }

}  // namespace meld::check
