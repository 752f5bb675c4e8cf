// Before pass 1: `import linear p(node, int) from file.` repeats what the file declares, and must agree with it. Assumes separate_modules()
// and expand_type_names().
#include <set>
#include <string>
#include <vector>

#include "compiler/check/check.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

// The kind of a predicate; the words `route` and `persistent` may be left out of an import.
std::string kind_of(const syntax::Declaration& d) {
    for (const syntax::Name& m : d.modifiers)
        if (m.text == "linear" || m.text == "action" || m.text == "sensed") return m.text;
    return "persistent";
}

// The properties in which two declarations must agree.
std::string canonical(const syntax::Type& type) {
    const bool catom = type.name == "catom" || type.name == "module" || type.name == "addr";
    std::string text = catom ? "node" : type.name;
    for (const syntax::Type& part : type.arguments) text += "(" + canonical(part) + ")";
    return text;
}

void compare(const syntax::Import& import, const std::vector<const syntax::Declaration*>& declared, diagnostics::Reporter& report) {
    const syntax::Declaration& said = *import.declaration;
    const auto mismatch = [&](Span span, const std::string& text, const syntax::Declaration& d) {
        auto& m = report.add(Kind::ImportMismatch, span, text);
        m.labels = {{d.span, "declared here"}};
        m.help = "write `import " + said.name.text + " from ...` to take it as it is declared";
        m.fixes = {diagnostics::write(said.span, said.name.text)};
    };
    const syntax::Declaration* found = nullptr;
    for (const syntax::Declaration* d : declared)
        if (d->arguments.size() == said.arguments.size()) found = d;
    if (found == nullptr) {
        const std::size_t count = declared.front()->arguments.size();
        return mismatch(said.span,
                        fmt::format("`{}` is declared with {} argument{}, and imported with {}", said.name.text, count,
                                    count == 1 ? "" : "s", said.arguments.size()),
                        *declared.front());
    }
    if (kind_of(*found) != kind_of(said))
        return mismatch(said.span, fmt::format("`{}` is declared {}, and imported as {}", said.name.text, kind_of(*found), kind_of(said)),
                        *found);
    for (std::size_t i = 0; i < said.arguments.size(); ++i) {
        const syntax::Type &theirs = found->arguments[i].type, &ours = said.arguments[i].type;
        if (canonical(theirs) != canonical(ours))
            return mismatch(ours.span,
                            fmt::format("argument {} of `{}` is declared {}, and imported as {}", i + 1, said.name.text,
                                        syntax::print(theirs), syntax::print(ours)),
                            *found);
    }
}

}  // namespace

void check_imports(const syntax::Tree& tree, diagnostics::Reporter& report) {
    for (const syntax::Item& item : tree.items) {
        const auto* import = std::get_if<syntax::Import>(&item);
        if (import == nullptr || !import->declaration) continue;
        std::vector<const syntax::Declaration*> declared;
        for (const syntax::Item& other : tree.items)
            if (const auto* d = std::get_if<syntax::Declaration>(&other); d != nullptr && d->name.text == import->predicate.text)
                declared.push_back(d);
        if (!declared.empty()) compare(*import, declared, report);
    }
}

}  // namespace meld::check
