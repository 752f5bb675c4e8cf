// Pass 2, variables that an aggregate or a comprehension shares with the rule around it where one of its own is expected: in
// a(A, X, Z), S = sum Z : { a(A, X, Z) } the Z of all matches is that of the fact outside.
#include "compiler/check/rules/resolver.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

bool mentions(const std::vector<Clause>& body, VariableId v) {
    bool found = false;
    for (const Clause& c : body) each_variable(c, [&](VariableId one) { found = found || one == v; });
    return found;
}

}  // namespace

void Resolver::warn_of_one_value(const syntax::BodyAggregate& tree, const Term& value, const std::vector<Clause>& inner) {
    const LocalNames::Names& own = locals_->of(&tree);
    const VariableId* shared = nullptr;
    bool varies = false;
    each_free_use(value, [&](const Term& use) {
        const Variable& v = rule_->variables[use.variable];
        varies = varies || own.contains(v.name);
        if (shared == nullptr && mentions(inner, use.variable)) shared = &use.variable;
    });
    if (varies || shared == nullptr) return;
    const Variable& v = rule_->variables[*shared];
    const std::string what = syntax::print(*tree.value);
    auto& d = report_.add(Kind::OneValue, value.span,
                          fmt::format("`{} {}` is over one value, since `{}` has its value outside the aggregate", tree.op, what, v.name));
    d.labels = {{v.span, fmt::format("this is the `{}` of all matches", v.name)}};
    d.help = fmt::format("inside the braces, use a name that the rest of the rule does not use: `{0} {1}2 : {{ ... {1}2 ... }}`", tree.op,
                         v.name);
}

void Resolver::warn_of_one_value(const std::vector<syntax::Name>& variables, const void* part, const std::vector<Clause>& body,
                                 std::string_view of) {
    for (const syntax::Name& name : variables) {
        if (locals_->of(part).contains(name.text)) continue;
        for (const VariableId id : rule_->variables.ids()) {
            const Variable& v = rule_->variables[id];
            if (v.name != name.text || !mentions(body, id)) continue;
            auto& d = report_.add(Kind::OneValue, name.span,
                                  fmt::format("this {} is over one value of `{}`, which has its value outside", of, name.text));
            d.labels = {{v.span, fmt::format("this is the `{}` of all matches", name.text)}};
            d.help = fmt::format("leave `{}` out of this list if that is meant; else use a name that the rest of the rule does not use",
                                 name.text);
            break;
        }
    }
}

}  // namespace meld::check
