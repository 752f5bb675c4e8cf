// Completion: the possible words at the cursor, by the kind of the item it is in. The editor filters by the text typed so far.
#include <algorithm>
#include <map>
#include <set>

#include "compiler/lsp/describe.h"
#include "compiler/syntax/aggregates.h"
#include "runtime/base/assert.h"

namespace meld::lsp {

namespace {

constexpr std::string_view kItemWords[] = {"type",   "const",  "fun",    "extern", "include",  "use",
                                           "import", "export", "module", "node",   "priority", "index"};
constexpr std::string_view kDeclarationWords[] = {"route", "linear", "action", "sensed", "persistent", "virtual", "bool", "int",
                                                  "float", "string", "node",   "list",   "set",        "array",   "vec3", "while"};
constexpr std::string_view kRuleWords[] = {"not", "forall",    "exists", "delta", "proved", "if",    "then", "else",
                                           "end", "otherwise", "let",    "in",    "true",   "false", "nil"};

bool name_letter(char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') || (letter >= '0' && letter <= '9') || letter == '_' ||
           letter == '?' || letter == '\'' || letter == '-';
}

// The start of the name that ends at the offset. A hyphen belongs to names that start with a lowercase letter; after a variable or a number
// it is a minus.
std::size_t name_begin(std::string_view text, std::size_t offset) {
    std::size_t begin = offset;
    while (begin > 0 && name_letter(text[begin - 1])) --begin;
    while (begin < offset && !(text[begin] >= 'a' && text[begin] <= 'z')) {
        const std::size_t hyphen = text.substr(0, offset).find('-', begin);
        if (hyphen == std::string_view::npos) break;
        begin = hyphen + 1;
    }
    return begin;
}

// The item being written at the offset; nothing at the start of one.
std::optional<std::size_t> open_item(const FileTokens& file, std::size_t offset) {
    const auto item = file.item_at(offset == 0 ? 0 : offset - 1);
    if (!item) return std::nullopt;
    const Token& last = file.tokens[file.items[*item].end - 1];
    return last.kind == TokenKind::Period && last.span.end <= offset ? std::nullopt : item;
}

// Comments and texts have nothing to complete.
bool in_code(const FileTokens& file, std::string_view text, std::size_t offset) {
    std::size_t gap = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
    for (const Token& token : file.tokens) {
        if (token.span.begin >= offset) break;
        if (token.span.end >= offset) return token.kind != TokenKind::String && token.kind != TokenKind::IncludePath;
        gap = token.span.end;
    }
    int depth = 0;
    bool line = false;
    for (std::size_t i = gap; i < offset; ++i) {
        const std::string_view two = text.substr(i, 2);
        if (line) {
            line = text[i] != '\n';
        } else if (two == "/*" || (two == "*/" && depth > 0)) {
            depth += two == "/*" ? 1 : -1;
            ++i;
        } else if (depth == 0 && (two == "//" || two == ";;")) {
            line = true;
        }
    }
    return !line && depth == 0;
}

class Collector {
  public:
    explicit Collector(const Analysis& analysis) : analysis_(analysis) {}

    std::vector<Completion> run(std::size_t begin, std::size_t offset) {
        const FileTokens& file = analysis_.tokens().at(analysis_.root_index());
        const auto item = open_item(file, begin);
        const TokenKind kind = item ? file.items[*item].kind : TokenKind::Name;
        const bool starts = !item || file.tokens[file.items[*item].begin].span.begin == begin;
        if (starts) words(kItemWords);
        if (!starts && (kind == TokenKind::Type || kind == TokenKind::Extern || kind == TokenKind::Import)) {
            words(kDeclarationWords);
            words(syntax::words_of_declared_aggregates());
            return std::move(list_);
        }
        if (!starts) {
            words(kRuleWords);
            words(syntax::words_of_aggregates_of_matches());
        }
        if (item) variables(file, *item, begin, offset);
        declared();
        return std::move(list_);
    }

  private:
    template <class Words>
    void words(const Words& list) {
        for (const std::string_view word : list) list_.push_back({Completion::Kind::Keyword, std::string(word)});
    }

    void variables(const FileTokens& file, std::size_t item, std::size_t begin, std::size_t offset) {
        MELD_EXPECT(item < file.items.size() && begin <= offset, "item {} of {}", item, file.items.size());
        std::set<std::string> seen;
        for (std::size_t i = file.items[item].begin; i < file.items[item].end; ++i) {
            const Token& token = file.tokens[i];
            const bool typed = token.span.begin == begin && token.span.end >= offset;
            if (token.kind != TokenKind::Variable || typed || !seen.insert(token.text).second) continue;
            list_.push_back({Completion::Kind::Variable, token.text, "variable of this rule"});
        }
    }

    // Predicates of one name and several numbers of arguments are one entry.
    void declared() {
        std::map<std::pair<SymbolKind, std::string>, Completion> found;
        for (const auto& [file, tokens] : analysis_.tokens()) {
            for (const Occurrence& occurrence : analysis_.occurrences(file)) {
                if (occurrence.role != Role::Declaration || occurrence.symbol.kind == SymbolKind::Variable) continue;
                const std::string text = analysis_.item_text(file, occurrence.item);
                Completion& entry = found[{occurrence.symbol.kind, occurrence.symbol.name}];
                entry.name = occurrence.symbol.name;
                entry.kind = kind_of(occurrence.symbol.kind, tokens, tokens.items[occurrence.item]);
                if (entry.detail.find(text) == std::string::npos) entry.detail += (entry.detail.empty() ? "" : "\n") + text;
                const std::string doc = analysis_.doc(file, occurrence.item);
                if (!doc.empty()) entry.doc += (entry.doc.empty() ? "" : "\n\n") + doc;
            }
        }
        for (auto& [key, entry] : found) list_.push_back(std::move(entry));
    }

    static Completion::Kind kind_of(SymbolKind kind, const FileTokens& file, const Item& item) {
        if (kind == SymbolKind::Constant) return Completion::Kind::Constant;
        if (kind == SymbolKind::Function) return Completion::Kind::Function;
        for (std::size_t i = item.begin; i < item.end && file.tokens[i].kind != TokenKind::LeftParen; ++i) {
            if (file.tokens[i].text == "action") return Completion::Kind::Action;
        }
        return Completion::Kind::Predicate;
    }

    const Analysis& analysis_;
    std::vector<Completion> list_;
};

}  // namespace

Completions complete(const Analysis& analysis, Position position) {
    const source::File& file = analysis.root();
    const std::size_t offset = offset_of(file.text(), position);
    const std::size_t begin = name_begin(file.text(), offset);
    MELD_ASSERT(begin <= offset && offset <= file.text().size(), "bytes {} to {} of {}", begin, offset, file.text().size());
    Completions result;
    result.replaced =
        range_of(analysis.files(), {analysis.root_index(), static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(offset)});
    if (in_code(analysis.tokens().at(analysis.root_index()), file.text(), offset)) result.list = Collector(analysis).run(begin, offset);
    return result;
}

}  // namespace meld::lsp
