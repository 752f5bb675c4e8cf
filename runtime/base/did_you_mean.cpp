// Edit distance over three rows of the usual table.
#include "runtime/base/did_you_mean.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <vector>

namespace meld {
namespace {

// Longer names are not compared letter by letter: nobody mistypes them, and the table below would be large.
constexpr std::size_t kMaxLength = 200;

bool same_letter(char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b)); }

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> above(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        next[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t change = row[j - 1] + (same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
            next[j] = std::min({row[j] + 1, next[j - 1] + 1, change});
            const bool swapped = i > 1 && j > 1 && same_letter(a[i - 1], b[j - 2]) && same_letter(a[i - 2], b[j - 1]);
            if (swapped) next[j] = std::min(next[j], above[j - 2] + 1);
        }
        std::swap(above, row);
        std::swap(row, next);
    }
    return row[b.size()];
}

// Whether one is the plural of the other in -ies, as `bodies` of `body`: a slip like one letter, though it takes three edits.
bool plural_in_ies(std::string_view many, std::string_view one) {
    return many.ends_with("ies") && one.ends_with('y') &&
           edit_distance(many.substr(0, many.size() - 3), one.substr(0, one.size() - 1)) == 0;
}

}  // namespace

std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> known) {
    if (word.empty() || word.size() > kMaxLength) return std::nullopt;
    // A third of the letters may be wrong: one for a name of up to four letters, two up to seven.
    const std::size_t limit = std::max<std::size_t>(1, (word.size() + 1) / 3);
    std::optional<std::string_view> best;
    std::size_t best_distance = limit + 1;
    for (const std::string_view candidate : known) {
        if (candidate == word || candidate.empty()) continue;
        const bool plural = plural_in_ies(word, candidate) || plural_in_ies(candidate, word);
        if (!plural && (candidate.size() > word.size() + limit || candidate.size() + limit < word.size())) continue;
        const std::size_t distance = plural ? 1 : edit_distance(word, candidate);
        // If every letter changed, it is another name, however short.
        if (distance >= std::min(word.size(), candidate.size()) && distance > 0) continue;
        if (distance < best_distance || (best && distance == best_distance && candidate < *best)) {
            best = candidate;
            best_distance = distance;
        }
    }
    return best;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> known) {
    if (const auto near = nearest_name(word, known)) return fmt::format("did you mean '{}'?", *near);
    return fmt::format("one of {}", fmt::join(known, ", "));
}

}  // namespace meld
