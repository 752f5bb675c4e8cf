// A rule is walked once with a stack of its brackets: the content of a bracket is a head, a body or a value.
#include "compiler/lsp/occurrences.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::lsp {

namespace {

// What a declaration declares: its kind and the token of its name.
struct Declares {
    SymbolKind kind;
    std::size_t name;
};

bool is_call(const FileTokens& file, std::size_t i) {
    MELD_EXPECT(i + 1 < file.tokens.size(), "token {} of {}", i, file.tokens.size());
    return file.tokens[i].kind == TokenKind::Name && file.tokens[i + 1].kind == TokenKind::LeftParen;
}

std::optional<Declares> declares(const FileTokens& file, const Item& item) {
    const auto signature = [&](SymbolKind kind) -> std::optional<Declares> {
        for (std::size_t i = item.begin + 1; i + 1 < item.end; ++i) {
            if (is_call(file, i)) return Declares{kind, i};
            i = std::max(i, file.partners[i]);
        }
        return std::nullopt;
    };
    switch (item.kind) {
        case TokenKind::Type:
            return signature(SymbolKind::Predicate);
        case TokenKind::Extern:
        case TokenKind::Fun:
            return signature(SymbolKind::Function);
        case TokenKind::Const:
            if (item.begin + 1 < item.end) return Declares{SymbolKind::Constant, item.begin + 1};
            return std::nullopt;
        case TokenKind::Import:
            for (std::size_t i = item.begin + 1; i + 1 < item.end; ++i) {
                if (file.tokens[i].text == "as" && file.tokens[i].kind == TokenKind::Name) return Declares{SymbolKind::Predicate, i + 1};
            }
            return signature(SymbolKind::Predicate);
        default:
            return std::nullopt;
    }
}

std::size_t declared_arity(const FileTokens& file, const Item& item, const Declares& what) {
    if (what.kind == SymbolKind::Constant) return 0;
    for (std::size_t i = item.begin; i < item.end; ++i) {
        if (is_call(file, i)) return count_arguments(file, i);
    }
    return kAnyArity;
}

bool is_operator(TokenKind kind) { return kind >= TokenKind::Equal && kind <= TokenKind::Append; }

class RuleWalk {
  public:
    RuleWalk(const FileTokens& file, std::uint32_t index, std::size_t item, const Declared& declared, std::vector<Occurrence>& found)
        : file_(file), tokens_(file.tokens), index_(index), item_(item), declared_(declared), found_(found) {}

    // The tokens from `begin` on to the item's end; `value`: of an expression, not of a rule.
    void run(std::size_t begin, bool value) {
        const Item& item = file_.items[item_];
        MELD_EXPECT(stack_.empty() && begin <= item.end && item.end <= tokens_.size(), "tokens {} to {}", begin, item.end);
        stack_.push_back({value ? Where::Value : Where::Part});
        for (at_ = begin; at_ < item.end; ++at_) {
            const Token& token = tokens_[at_];
            switch (token.kind) {
                case TokenKind::Variable:
                    variable(token);
                    break;
                case TokenKind::Name:
                    name(token);
                    break;
                case TokenKind::Bar:
                    ++stack_.back().section;
                    break;
                case TokenKind::LeftParen:
                case TokenKind::StructOpen:
                case TokenKind::LeftBracket:
                case TokenKind::LeftBrace:
                    stack_.push_back(opened(token.kind));
                    break;
                case TokenKind::RightParen:
                case TokenKind::RightBracket:
                case TokenKind::RightBrace:
                    if (stack_.size() > 1) stack_.pop_back();
                    break;
                default:
                    break;
            }
        }
    }

  private:
    // Part: clauses or heads. Value: expressions. Sections: { X | body | head } or [sum => S | X | body | head].
    enum class Where { Part, Value, Comprehension, Bracketed };
    struct Level {
        Where where;
        bool body = false;  // A Part that is a body wherever it stands.
        int section = 0;
    };

    TokenKind last() const { return at_ == file_.items[item_].begin ? TokenKind::Period : tokens_[at_ - 1].kind; }

    TokenKind ahead(std::size_t count) const { return tokens_[std::min(at_ + count, tokens_.size() - 1)].kind; }

    Level opened(TokenKind kind) const {
        MELD_EXPECT(!stack_.empty(), "a bracket outside of a rule");
        const Level& outer = stack_.back();
        const bool body = !in_head();
        if (kind == TokenKind::LeftBrace)
            return last() == TokenKind::Colon ? Level{Where::Part, true} : Level{Where::Comprehension, outer.body};
        if (kind == TokenKind::StructOpen || outer.where == Where::Value) return {Where::Value};
        if (kind == TokenKind::LeftBracket) {
            if (last() == TokenKind::RightParen) return {Where::Part, true};  // forall p(A)[q(A)]
            const bool aggregate = ahead(1) == TokenKind::Colon || ahead(2) == TokenKind::ResultArrow || starts_sized_aggregate(at_ + 1) ||
                                   (ahead(1) == TokenKind::Name && ahead(2) == TokenKind::Name);
            return aggregate ? Level{Where::Bracketed, body} : Level{Where::Value};
        }
        const bool parts =
            last() == TokenKind::Not || last() == TokenKind::ExistsPeriod || last() == TokenKind::Delta || ahead(1) == TokenKind::If;
        return parts ? Level{Where::Part, body} : Level{Where::Value};
    }

    // The min_k(3) => of a rule aggregate.
    bool starts_sized_aggregate(std::size_t name) const {
        if (name + 1 >= tokens_.size() || tokens_[name].kind != TokenKind::Name || tokens_[name + 1].kind != TokenKind::LeftParen)
            return false;
        std::size_t depth = 0, at = name + 1;
        for (; at < file_.items[item_].end; ++at) {
            if (tokens_[at].kind == TokenKind::LeftParen) ++depth;
            if (tokens_[at].kind == TokenKind::RightParen && --depth == 0) break;
        }
        return at + 1 < file_.items[item_].end && tokens_[at + 1].kind == TokenKind::ResultArrow;
    }

    bool in_head() const {
        const Item& item = file_.items[item_];
        bool head = item.arrow == item.end || (tokens_[item.arrow].kind == TokenKind::ViewArrow ? at_ < item.arrow : at_ > item.arrow);
        for (const Level& level : stack_) {
            if (level.where == Where::Part && level.body) head = false;
            if (level.where == Where::Comprehension) head = head && level.section >= 2;
            if (level.where == Where::Bracketed) head = head && level.section >= 3;
        }
        return head;
    }

    void add(SymbolKind kind, const Token& token, std::size_t arity, Role role) {
        MELD_EXPECT(!token.text.empty(), "a name without letters at {}", token.span.begin);
        Symbol symbol{.kind = kind, .name = token.text, .arity = arity};
        if (kind == SymbolKind::Variable) {
            symbol.file = index_;
            symbol.item = item_;
        }
        found_.push_back({std::move(symbol), role, token.span, item_});
    }

    void variable(const Token& token) {
        const bool constant = declared_.constants.contains(token.text);
        add(constant ? SymbolKind::Constant : SymbolKind::Variable, token, 0, Role::Uses);
    }

    static std::size_t nearest_arity(const std::map<std::string, std::set<std::size_t>>& known, const std::string& name,
                                     std::size_t arity) {
        const auto found = known.find(name);
        if (found == known.end() || found->second.empty() || found->second.contains(arity)) return arity;
        return *found->second.begin();
    }

    void name(const Token& token) {
        const bool predicate = declared_.predicates.contains(token.text);
        const bool function = declared_.functions.contains(token.text);
        if (is_call(file_, at_)) {
            const std::size_t arity = count_arguments(file_, at_);
            if (starts_sized_aggregate(at_)) return;
            const bool value = stack_.back().where == Where::Value || is_operator(last()) || last() == TokenKind::If;
            const bool is_function = value ? function || !predicate : function && !predicate;
            if (is_function) {
                add(SymbolKind::Function, token, nearest_arity(declared_.functions, token.text, arity), Role::Uses);
            } else if (token.text != "proved" || predicate) {
                add(SymbolKind::Predicate, token, nearest_arity(declared_.predicates, token.text, arity),
                    in_head() ? Role::Derives : Role::Reads);
            }
            return;
        }
        if (declared_.constants.contains(token.text)) return add(SymbolKind::Constant, token, 0, Role::Uses);
        const TokenKind next = ahead(1);
        const bool word = next == TokenKind::ResultArrow || next == TokenKind::Name || next == TokenKind::Variable ||
                          token.text == "true" || token.text == "false" || token.text == "nil";
        if (word) return;
        if (predicate && at_ >= 4 && tokens_[at_ - 4].text == "proved")
            return add(SymbolKind::Predicate, token, nearest_arity(declared_.predicates, token.text, kAnyArity), Role::Reads);
        // In original Meld a lower-case name that is no constant is a variable.
        if (stack_.back().where == Where::Value || is_operator(last()) || is_operator(next))
            add(SymbolKind::Variable, token, 0, Role::Uses);
    }

    const FileTokens& file_;
    const std::vector<Token>& tokens_;
    std::uint32_t index_;
    std::size_t item_;
    const Declared& declared_;
    std::vector<Occurrence>& found_;
    std::size_t at_ = 0;
    std::vector<Level> stack_;
};

// Names of predicates in declarations that use them: `[<- edge]`, export p, priority p < q.
void add_mentioned(const FileTokens& file, std::size_t item, const Declared& declared, std::vector<Occurrence>& found) {
    const Item& it = file.items[item];
    for (std::size_t i = it.begin + 1; i < it.end; ++i) {
        const Token& token = file.tokens[i];
        const auto known = declared.predicates.find(token.text);
        const bool link = file.tokens[i - 1].kind == TokenKind::NeighbourOpen;
        if (token.kind != TokenKind::Name || known == declared.predicates.end() || known->second.empty()) continue;
        if (!link && it.kind != TokenKind::Export && it.kind != TokenKind::Hint) continue;
        const bool stated = file.tokens[i + 1].kind == TokenKind::Slash && i + 2 < it.end;
        const auto arity = stated ? static_cast<std::size_t>(file.tokens[i + 2].integer) : *known->second.begin();
        found.push_back({Symbol{.kind = SymbolKind::Predicate,
                                .name = token.text,
                                .arity = known->second.contains(arity) ? arity : *known->second.begin()},
                         Role::Uses, token.span, item});
    }
}

// The parameters of a function are variables of its item.
void add_parameters(const FileTokens& file, std::uint32_t index, std::size_t item, std::size_t name, std::vector<Occurrence>& found) {
    for (std::size_t i = name + 2; i < std::max(file.partners[name + 1], name + 2); ++i) {
        const Token& token = file.tokens[i];
        if (token.kind != TokenKind::Variable) continue;
        found.push_back(
            {Symbol{.kind = SymbolKind::Variable, .name = token.text, .file = index, .item = item}, Role::Declaration, token.span, item});
    }
}

void add_declaration(const FileTokens& file, std::uint32_t index, std::size_t item, const Declared& declared,
                     std::vector<Occurrence>& found) {
    MELD_EXPECT(item < file.items.size(), "item {} of {}", item, file.items.size());
    const Item& it = file.items[item];
    const auto what = declares(file, it);
    if (what) {
        const Token& token = file.tokens[what->name];
        found.push_back({Symbol{.kind = what->kind, .name = token.text, .arity = declared_arity(file, it, *what)}, Role::Declaration,
                         token.span, item});
    }
    add_mentioned(file, item, declared, found);
    if (it.kind == TokenKind::Fun && what) add_parameters(file, index, item, what->name, found);
    if (it.kind != TokenKind::Const && it.kind != TokenKind::Fun) return;
    std::size_t value = it.begin;
    while (value < it.end && file.tokens[value].kind != TokenKind::Equal) ++value;
    if (value < it.end) RuleWalk(file, index, item, declared, found).run(value + 1, true);
}

}  // namespace

std::size_t count_arguments(const FileTokens& file, std::size_t name) {
    MELD_EXPECT(is_call(file, name) && file.partners.size() == file.tokens.size(), "token {} is no call", name);
    const std::size_t close = file.partners[name + 1];
    if (close <= name + 1) return kAnyArity;
    if (close == name + 2) return 0;
    std::size_t count = 1;
    for (std::size_t i = name + 2; i < close; ++i) {
        if (file.tokens[i].kind == TokenKind::Comma) ++count;
        i = std::max(i, file.partners[i] > i ? file.partners[i] : i);
    }
    return count;
}

void add_declared(const FileTokens& file, Declared& declared) {
    for (const Item& item : file.items) {
        const auto what = declares(file, item);
        if (!what) continue;
        const std::string& name = file.tokens[what->name].text;
        if (what->kind == SymbolKind::Constant) {
            declared.constants.insert(name);
        } else {
            (what->kind == SymbolKind::Function ? declared.functions : declared.predicates)[name].insert(declared_arity(file, item, *what));
        }
    }
}

std::vector<Occurrence> find_occurrences(const FileTokens& file, std::uint32_t index, const Declared& declared) {
    std::vector<Occurrence> found;
    for (std::size_t i = 0; i < file.items.size(); ++i) {
        const Item& item = file.items[i];
        const Token& first = file.tokens[item.begin];
        const bool named = (item.kind == TokenKind::Include || item.kind == TokenKind::Use) && item.begin + 1 < item.end;
        if (item.kind == TokenKind::IncludePath || named) {
            const Token& path = named ? file.tokens[item.begin + 1] : first;
            found.push_back({Symbol{.kind = SymbolKind::Include, .name = path.text}, Role::Uses, path.span, i});
        } else if (item.kind == TokenKind::Name) {
            RuleWalk(file, index, i, declared, found).run(item.begin, false);
        } else {
            add_declaration(file, index, i, declared, found);
        }
    }
    return found;
}

}  // namespace meld::lsp
