#include "tests/fuzz/mutate.h"

#include <array>
#include <cctype>
#include <random>

namespace meld::fuzz {

namespace {

enum class Sort { Blank, Lower, Upper, Number, Text, Sign };

Sort sort_of(char c) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isspace(u)) return Sort::Blank;
    if (std::islower(u)) return Sort::Lower;
    if (std::isupper(u) || c == '_') return Sort::Upper;
    if (std::isdigit(u)) return Sort::Number;
    return c == '"' ? Sort::Text : Sort::Sign;
}

bool continues(Sort sort, char c) {
    const auto u = static_cast<unsigned char>(c);
    switch (sort) {
        case Sort::Blank:
            return std::isspace(u) != 0;
        case Sort::Lower:
        case Sort::Upper:
            return std::isalnum(u) || c == '_' || c == '\'' || c == '-';
        case Sort::Number:
            return std::isalnum(u) || c == '.';
        case Sort::Text:
            return c != '"' && c != '\n';
        case Sort::Sign:
            return false;
    }
    return false;
}

constexpr std::array kAwkward = {"0", "1", "-1", "9223372036854775807", "1e308", "0.0", "65536", "@0", "@arg1", "@world"};
constexpr std::array kPieces = {" not ",
                                " forall ",
                                "[X | L]",
                                "[]",
                                " if ",
                                " let X = 1 in X end",
                                "{ X | p(A, X) | q(A) }",
                                "@+3",
                                "[sum => S | X | p(A, X) | | q(A, S)]",
                                " exists X. (p(A))",
                                "S = count : { p(A) }",
                                " E in L ",
                                "delta(X; p(A, X)) > 1",
                                "proved(N, p)",
                                ":(1, 2.0)",
                                "\"text\"",
                                "(1, 2)",
                                "min int",
                                "list int",
                                "set_union set int",
                                "sum float [<- neighbor]",
                                "++",
                                "^",
                                "%",
                                " -o ",
                                " :- ",
                                "$",
                                "?",
                                "!"};

class Changer {
  public:
    Changer(std::string_view text, std::string_view other, std::uint32_t seed) : text_(text), other_(other), random_(seed) {}

    std::string run() {
        switch (pick(9)) {
            case 0:
                return change_item();
            case 1:
                return take_item();
            case 2:
                return with_word([&](std::string_view) { return std::string(); });
            case 3:
                return with_word([&](std::string_view w) { return std::string(w) + std::string(w); });
            case 4:
                return with_word([&](std::string_view) { return std::string(kAwkward[pick(kAwkward.size())]); });
            case 5:
                return with_word([&](std::string_view w) { return std::string(w) + kPieces[pick(kPieces.size())]; });
            case 6:
                return swap_words();
            default:
                return with_word([&](std::string_view w) { return alike(w); });
        }
    }

  private:
    std::size_t pick(std::size_t n) { return n == 0 ? 0 : random_() % n; }

    static std::string join(const std::vector<std::string_view>& parts) {
        std::string out;
        for (const std::string_view part : parts) out += part;
        return out;
    }

    std::string change_item() {
        std::vector<std::string_view> all = items(text_);
        if (all.empty()) return std::string(text_);
        const std::size_t at = pick(all.size());
        const auto place = all.begin() + static_cast<std::ptrdiff_t>(at);
        switch (pick(3)) {
            case 0:
                all.erase(place);
                break;
            case 1:
                all.insert(place, all[at]);
                break;
            default:
                std::swap(all[at], all[pick(all.size())]);
        }
        return join(all);
    }
    std::string take_item() {
        std::vector<std::string_view> all = items(text_);
        const std::vector<std::string_view> more = items(other_);
        if (more.empty()) return change_item();
        all.insert(all.begin() + static_cast<std::ptrdiff_t>(pick(all.size() + 1)), more[pick(more.size())]);
        return join(all);
    }

    template <class Change>
    std::string with_word(const Change& change) {
        const std::vector<std::string_view> all = words(text_);
        if (all.empty()) return std::string(kPieces[pick(kPieces.size())]);
        const std::size_t at = pick(all.size());
        std::string out;
        for (std::size_t i = 0; i < all.size(); ++i) out += i == at ? change(all[i]) : std::string(all[i]);
        return out;
    }
    std::string swap_words() {
        std::vector<std::string_view> all = words(text_);
        if (all.size() < 2) return std::string(text_);
        const std::size_t a = pick(all.size()), b = std::min(all.size() - 1, a + 1 + pick(4));
        std::swap(all[a], all[b]);
        return join(all);
    }
    // Another word of the same sort from either text.
    std::string alike(std::string_view word) {
        std::vector<std::string_view> same;
        for (const std::string_view source : {text_, other_})
            for (const std::string_view w : words(source))
                if (sort_of(w[0]) == sort_of(word[0]) && w != word) same.push_back(w);
        return std::string(same.empty() ? word : same[pick(same.size())]);
    }

    std::string_view text_, other_;
    std::minstd_rand random_;
};

}  // namespace

std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> out;
    for (std::size_t at = 0; at < text.size();) {
        const Sort sort = sort_of(text[at]);
        std::size_t end = at + 1;
        while (end < text.size() && continues(sort, text[end])) ++end;
        if (sort == Sort::Text && end < text.size()) ++end;
        out.push_back(text.substr(at, end - at));
        at = end;
    }
    return out;
}

std::vector<std::string_view> items(std::string_view text) {
    std::vector<std::string_view> out;
    const std::string_view end = text.find(".\n") == std::string_view::npos ? "\n" : ".\n";
    while (!text.empty()) {
        const std::size_t stop = text.find(end);
        const std::size_t size = stop == std::string_view::npos ? text.size() : stop + end.size();
        out.push_back(text.substr(0, size));
        text.remove_prefix(size);
    }
    return out;
}

std::string mutate(std::string_view text, std::string_view other, std::uint32_t seed, std::size_t limit) {
    std::string out = Changer(text, other, seed).run();
    if (out.size() > limit) out.resize(limit);
    return out;
}

}  // namespace meld::fuzz
