// Renaming: every occurrence in every open program that shares the declaration. A rename that would change another name's meaning is
// refused.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "compiler/lsp/describe.h"
#include "runtime/base/assert.h"

namespace meld::lsp {

namespace {

// The one token that the text is, or nothing.
std::optional<Token> only_token(const std::string& text) {
    source::FileSet files;
    diagnostics::Reporter report;
    const std::vector<Token> tokens = syntax::scan(files.file(files.add("name", text)), 0, report);
    if (report.has_errors() || tokens.size() != 2 || tokens[0].span.begin != 0 || tokens[0].span.end != text.size()) return std::nullopt;
    return tokens[0];
}

// Why the name is not valid for this symbol; empty if it is.
std::string wrong_form(const Symbol& symbol, const std::string& written, const std::string& name) {
    const auto token = only_token(name);
    const bool capital = !written.empty() && written[0] >= 'A' && written[0] <= 'Z';
    const TokenKind wanted = capital ? TokenKind::Variable : TokenKind::Name;
    if (token && token->kind == wanted && name != "true" && name != "false" && name != "nil") return "";
    if (symbol.kind == SymbolKind::Variable && wanted == TokenKind::Variable)
        return fmt::format("`{}` is not a variable: variables start with a capital letter", name);
    return fmt::format("`{}` is not a name: names start with a {} letter and hold letters, digits, _, -, ? and '", name,
                       capital ? "capital" : "lower-case");
}

// Words change their meaning by their neighbours; with the new name every token must keep its kind.
bool keeps_kinds(const Analysis& analysis, std::uint32_t file, const std::vector<Span>& spans, const std::string& name) {
    std::string text = analysis.files().file(file).text();
    MELD_EXPECT(std::is_sorted(spans.begin(), spans.end(), [](Span a, Span b) { return a.begin < b.begin; }), "places out of order");
    for (auto span = spans.rbegin(); span != spans.rend(); ++span) text.replace(span->begin, span->end - span->begin, name);
    source::FileSet files;
    const FileTokens after = read_items(files.file(files.add("renamed", text)), 0);
    const std::vector<Token>& before = analysis.tokens().at(file).tokens;
    const auto same = [](const Token& a, const Token& b) { return a.kind == b.kind; };
    return std::equal(before.begin(), before.end(), after.tokens.begin(), after.tokens.end(), same);
}

// Whether the name is already used for something else where the symbol is known.
bool is_taken(const Analysis& analysis, const Symbol& symbol, const std::string& name) {
    for (const auto& [file, tokens] : analysis.tokens()) {
        for (std::size_t i = 0; i < tokens.items.size(); ++i) {
            if (symbol.kind == SymbolKind::Variable && (file != symbol.file || i != symbol.item)) continue;
            for (std::size_t t = tokens.items[i].begin; t < tokens.items[i].end; ++t) {
                const Token& token = tokens.tokens[t];
                if ((token.kind == TokenKind::Name || token.kind == TokenKind::Variable) && token.text == name) return true;
            }
        }
    }
    return symbol.kind == SymbolKind::Variable && analysis.declared().constants.contains(name);
}

}  // namespace

bool Edit::operator<(const Edit& other) const {
    const auto key = [](const Edit& edit) { return std::tie(edit.path, edit.range.start.line, edit.range.start.character); };
    return key(*this) < key(other);
}

Result<std::vector<Edit>> rename(const std::vector<const Analysis*>& programs, Position position, const std::string& name) {
    MELD_EXPECT(!programs.empty() && programs.front() != nullptr, "a name is changed in no program");
    const Analysis& first = *programs.front();
    const Occurrence* occurrence = first.at(position);
    if (occurrence == nullptr || occurrence->symbol.kind == SymbolKind::Include) return fail("nothing here has a name that can be changed");
    const Symbol symbol = occurrence->symbol;
    const std::string written(first.files().text(occurrence->span));
    if (std::string wrong = wrong_form(symbol, written, name); !wrong.empty()) return fail(std::move(wrong));
    if (name == symbol.name) return std::vector<Edit>{};
    const auto declaration = first.declaration(symbol);
    if (!declaration) return fail(fmt::format("`{}` is not declared in a file of this program", symbol.name));
    const std::string home = first.files().file(declaration->first).path();
    std::set<Edit> edits;
    for (const Analysis* program : programs) {
        // A variable is of one file; a program that does not see the declaration has nothing to rename.
        if (symbol.kind == SymbolKind::Variable ? program != &first : !program->uses(home) && program != &first) continue;
        if (is_taken(*program, symbol, name)) return fail(fmt::format("`{}` is taken already", name));
        std::map<std::uint32_t, std::vector<Span>> spans;
        for (const auto& [file, one] : program->all(symbol)) {
            if (program->is_prelude(file)) return fail(fmt::format("`{}` is a name of the prelude, which stays as it is", symbol.name));
            spans[file].push_back(one->span);
        }
        for (const auto& [file, list] : spans) {
            if (!keeps_kinds(*program, file, list, name))
                return fail(fmt::format("`{}` would mean something else at one of the places", name));
            for (const Span span : list) edits.insert({program->files().file(file).path(), range_of(program->files(), span)});
        }
    }
    return std::vector<Edit>(edits.begin(), edits.end());
}

}  // namespace meld::lsp
