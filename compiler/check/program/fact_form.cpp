#include "compiler/check/program/fact_form.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

namespace meld::check {

namespace {

std::string form_of(const Predicate& predicate) {
    std::set<std::string> taken = {"A"};
    std::string text = predicate.name + "(A";
    for (std::size_t i = 1; i < predicate.arguments.size(); ++i) {
        const std::string& name = predicate.arguments[i].name;
        const bool variable = !name.empty() && std::isupper(static_cast<unsigned char>(name[0])) && taken.insert(name).second;
        text += ", " + (variable ? name : "_");
    }
    return text + ")";
}

}  // namespace

std::string fact_form_help(const Program& program, const std::string& name) {
    const Predicate* found = nullptr;
    for (const Predicate& p : program.predicates) {
        if (p.name != name || p.auxiliary || p.refused) continue;
        // What the world senses under the same name is not meant where the program has its own.
        if (found == nullptr || std::pair(p.prelude, p.arguments.size()) < std::pair(found->prelude, found->arguments.size())) found = &p;
    }
    if (found == nullptr) return "";
    return fmt::format("`{}` is a predicate; write a fact of it, as `{}`", name, form_of(*found));
}

}  // namespace meld::check
