// The outline of a file: its declarations, and its rules by their heads.
#include "compiler/lsp/describe.h"
#include "runtime/base/assert.h"

namespace meld::lsp {

namespace {

Outline::Kind kind_of(const Occurrence& occurrence, const std::string& text) {
    switch (occurrence.symbol.kind) {
        case SymbolKind::Constant:
            return Outline::Kind::Constant;
        case SymbolKind::Function:
            return Outline::Kind::Function;
        case SymbolKind::Include:
            return Outline::Kind::File;
        default:
            return text.starts_with("type action") ? Outline::Kind::Action : Outline::Kind::Predicate;
    }
}

// The occurrence that an item is listed under: what it declares or includes, or the first fact of its head.
const Occurrence* name_of(const std::vector<Occurrence>& occurrences, std::size_t item) {
    const Occurrence* first = nullptr;
    for (const Occurrence& occurrence : occurrences) {
        if (occurrence.item != item || occurrence.symbol.kind == SymbolKind::Variable) continue;
        const bool named =
            occurrence.role == Role::Declaration || occurrence.role == Role::Derives || occurrence.symbol.kind == SymbolKind::Include;
        if (named) return &occurrence;
        if (first == nullptr && occurrence.symbol.kind == SymbolKind::Predicate) first = &occurrence;
    }
    return first;
}

}  // namespace

std::vector<Outline> outline(const Analysis& analysis) {
    const std::uint32_t root = analysis.root_index();
    const FileTokens& file = analysis.tokens().at(root);
    std::vector<Outline> list;
    for (std::size_t i = 0; i < file.items.size(); ++i) {
        const Occurrence* name = name_of(analysis.occurrences(root), i);
        if (name == nullptr) continue;
        const std::string text = analysis.item_text(root, i);
        MELD_ASSERT(file.items[i].begin < file.items[i].end, "item {} has no tokens", i);
        const Span whole = file.tokens[file.items[i].begin].span.to(file.tokens[file.items[i].end - 1].span);
        const bool rule = file.items[i].kind == TokenKind::Name;
        list.push_back({rule ? Outline::Kind::Rule : kind_of(*name, text), name->symbol.name, text, range_of(analysis.files(), whole),
                        range_of(analysis.files(), name->span)});
    }
    return list;
}

}  // namespace meld::lsp
