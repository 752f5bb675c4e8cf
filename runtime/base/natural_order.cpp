#include "runtime/base/natural_order.h"

#include <algorithm>
#include <cstddef>

namespace meld {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) { return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ')'; }

struct Number {
    bool negative = false;
    std::string_view digits = {};  // Without leading zeros.
    std::size_t end = 0;           // Behind it in the text.
};

// Whether a number begins here, with its sign.
bool number_at(std::string_view text, std::size_t at, Number& out) {
    std::size_t begin = at;
    out.negative = text[at] == '-' && (at == 0 || !is_word(text[at - 1]));
    if (out.negative) ++begin;
    std::size_t end = begin;
    while (end < text.size() && is_digit(text[end])) ++end;
    if (end == begin) return false;
    const std::size_t first = std::min(text.find_first_not_of('0', begin), end);
    out.digits = text.substr(first, end - first);
    out.end = end;
    return true;
}

int compare(std::string_view a, std::string_view b) { return a.size() != b.size() ? (a.size() < b.size() ? -1 : 1) : a.compare(b); }

int compare(const Number& a, const Number& b) {
    if (a.negative != b.negative) return a.negative ? -1 : 1;
    return a.negative ? compare(b.digits, a.digits) : compare(a.digits, b.digits);
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
    std::size_t i = 0, k = 0;
    while (i < a.size() && k < b.size()) {
        Number x, y;
        if (number_at(a, i, x) && number_at(b, k, y)) {
            if (const int c = compare(x, y)) return c < 0;
            i = x.end;
            k = y.end;
            continue;
        }
        if (a[i] != b[k]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[k]);
        ++i;
        ++k;
    }
    if ((i == a.size()) != (k == b.size())) return i == a.size();
    return a < b;
}

}  // namespace meld
