#include "runtime/driver/grade/likeness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>
#include <utility>
#include <variant>

#include "compiler/syntax/parse.h"
#include "runtime/base/hash.h"

namespace meld::driver {

namespace {

// A chain of names that differ only in their place in it needs as many rounds as half of its length.
constexpr int kRounds = 16;

enum class Word { Name, Variable, Sign };

struct Token {
    Word is;
    std::string text;
};

// Of an item as the syntax tree prints it: without comments, and with one space where there is any.
std::vector<Token> tokens_of(std::string_view text) {
    std::vector<Token> out;
    const auto word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    for (std::size_t at = 0; at < text.size();) {
        const char c = text[at];
        std::size_t end = at + 1;
        if (std::isspace(static_cast<unsigned char>(c))) {
            ++at;
            continue;
        }
        if (c == '"') {
            while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
            end = std::min(end + 1, text.size());
        } else if (word(c)) {
            // not-bipartite is one name; where a number is subtracted, the printed text has spaces.
            while (end < text.size() && (word(text[end]) || (text[end] == '-' && end + 1 < text.size() && word(text[end + 1])))) ++end;
        } else if (text.substr(at).starts_with(":-") || text.substr(at).starts_with("-o")) {
            ++end;
        }
        const Word is = c == '_' || std::isdigit(static_cast<unsigned char>(c)) || !word(c) ? Word::Sign
                        : std::isupper(static_cast<unsigned char>(c))                       ? Word::Variable
                                                                                            : Word::Name;
        out.push_back({is, std::string(text.substr(at, end - at))});
        at = end;
    }
    return out;
}

// What is known of a name so far, by the name; of a variable by its item and the name.
using Colours = std::map<std::string, std::uint64_t>;

// A place in which a name stands, and the hashes of what is around it, from within.
struct Use {
    std::string name;
    std::uint64_t around;
};

// One round: hashes an item by the colours of its names.
class ItemHash {
  public:
    ItemHash(const std::vector<Token>& tokens, std::size_t item, const Colours& colours)
        : tokens_(tokens),
          item_(item),
          colours_(colours),
          rule_(std::ranges::any_of(tokens, [](const Token& t) { return t.text == ":-" || t.text == "-o"; })) {}

    // Adds what is around each name to what `around` has of it.
    std::uint64_t run(Colours& around) {
        std::vector<Use> uses;
        const std::uint64_t hash = sections("", rule_, uses);
        for (const Use& use : uses) around[use.name] += mix64(hash_combine(use.around, hash));
        return hash;
    }

  private:
    static bool closes(const std::string& text) { return text == ")" || text == "]" || text == "}"; }

    // Up to the bracket that closes, or the end: parts between commas, in sections between bars and arrows. The order of parts means
    // nothing in bodies, heads and comprehensions.
    std::uint64_t sections(std::string_view open, bool unordered, std::vector<Use>& uses) {
        std::uint64_t all = hash_text(open);
        std::vector<std::uint64_t> parts;
        const auto end_section = [&] {
            if (unordered) std::ranges::sort(parts);
            for (const std::uint64_t part : parts) all = hash_combine(all, part);
            parts.clear();
        };
        std::vector<Use> here;
        std::uint64_t part = 0;
        std::uint64_t place = 0;
        const auto end_part = [&] {
            parts.push_back(part);
            for (Use& use : here) uses.push_back({std::move(use.name), hash_combine(use.around, part)});
            here.clear();
            part = place = 0;
        };
        std::string before;
        for (; at_ < tokens_.size() && !closes(tokens_[at_].text); ++at_) {
            const Token& token = tokens_[at_];
            ++place;
            if (token.text == ",") {
                end_part();
            } else if (token.text == "|" || token.text == ":-" || token.text == "-o") {
                end_part();
                end_section();
                all = hash_combine(all, hash_text(token.text));
            } else if (token.text == "(" || token.text == "[" || token.text == "{") {
                ++at_;
                std::vector<Use> within;
                part = hash_combine(part, sections(token.text, token.text == "{" || (token.text == "(" && before == "not"), within));
                for (Use& use : within) here.push_back({std::move(use.name), hash_combine(use.around, place)});
            } else {
                part = hash_combine(part, colour_of(token, place, here));
            }
            before = token.text;
        }
        end_part();
        end_section();
        return all;
    }

    std::uint64_t colour_of(const Token& token, std::uint64_t place, std::vector<Use>& uses) const {
        if (token.is == Word::Sign) return hash_text(token.text);
        // The names of arguments in declarations are remarks.
        if (token.is == Word::Variable && !rule_ && is_declaration()) return 0;
        const std::string name = token.is == Word::Variable ? fmt::format("{} {}", item_, token.text) : token.text;
        const auto known = colours_.find(name);
        if (known == colours_.end()) return hash_text(token.text);
        uses.push_back({name, place});
        return known->second;
    }

    bool is_declaration() const { return !tokens_.empty() && tokens_[0].text == "type"; }

    const std::vector<Token>& tokens_;
    std::size_t item_;
    const Colours& colours_;
    bool rule_;
    std::size_t at_ = 0;
};

// An item's text: the tree prints one item per line.
std::vector<std::vector<Token>> items_of(const std::vector<syntax::Tree>& files) {
    std::vector<std::vector<Token>> items;
    for (const syntax::Tree& tree : files) {
        const std::string text = syntax::print(tree);
        for (std::size_t at = 0; at < text.size();) {
            const std::size_t end = std::min(text.find('\n', at), text.size());
            std::vector<Token> tokens = tokens_of(std::string_view(text).substr(at, end - at));
            // The full stop is of the item, and not of the part of a body that happens to be the last.
            if (!tokens.empty() && tokens.back().text == ".") tokens.pop_back();
            if (!tokens.empty()) items.push_back(std::move(tokens));
            at = end + 1;
        }
    }
    return items;
}

}  // namespace

std::set<std::string> declared_names(const syntax::Tree& tree) {
    std::set<std::string> names;
    for (const syntax::Item& item : tree.items)
        std::visit(
            [&](const auto& each) {
                using T = std::decay_t<decltype(each)>;
                if constexpr (std::is_same_v<T, syntax::Declaration> || std::is_same_v<T, syntax::Constant> ||
                              std::is_same_v<T, syntax::Function> || std::is_same_v<T, syntax::Alias> ||
                              std::is_same_v<T, syntax::NodeKind> || std::is_same_v<T, syntax::Module>)
                    names.insert(each.name.text);
            },
            item);
    return names;
}

std::uint64_t likeness(const std::vector<syntax::Tree>& files, const std::set<std::string>& fixed) {
    const std::vector<std::vector<Token>> items = items_of(files);
    Colours colours;
    for (const syntax::Tree& tree : files)
        for (const std::string& name : declared_names(tree))
            if (!fixed.contains(name)) colours[name] = 1;
    for (std::size_t i = 0; i < items.size(); ++i)
        for (const Token& token : items[i])
            if (token.is == Word::Variable) colours[fmt::format("{} {}", i, token.text)] = 2;
    std::uint64_t all = 0;
    for (int round = 0; round < kRounds; ++round) {
        Colours around;
        all = 0;
        for (std::size_t i = 0; i < items.size(); ++i) all += mix64(ItemHash(items[i], i, colours).run(around));
        for (auto& [name, colour] : colours) colour = hash_combine(colour, around[name]);
    }
    return all;
}

}  // namespace meld::driver
