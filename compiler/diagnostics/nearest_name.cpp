// Finds the name somebody most likely meant: the smallest edit distance, if it is small for the length of the name.
#include <algorithm>
#include <cctype>
#include <cstddef>

#include "compiler/diagnostics/diagnostics.h"

namespace meld::diagnostics {

namespace {

// Names longer than this are not compared: nobody mistypes them, and the table below would be large.
constexpr std::size_t kMaxLength = 200;

bool same_letter(char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b)); }

// The number of letters to insert, delete, change or swap with their neighbour (optimal string alignment). A changed case costs nothing.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t change = last[j - 1] + (same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, change});
            const bool swapped = i > 1 && j > 1 && same_letter(a[i - 1], b[j - 2]) && same_letter(a[i - 2], b[j - 1]);
            if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
        std::swap(before_last, last);
        std::swap(last, row);
    }
    return last[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
    if (name.empty() || name.size() > kMaxLength) return "";
    // A third of the letters may be wrong: one for a name of up to five letters, two up to eight.
    const std::size_t limit = std::max<std::size_t>(1, (name.size() + 1) / 3);
    std::string best;
    std::size_t best_distance = limit + 1;
    for (const std::string& candidate : candidates) {
        if (candidate == name || candidate.empty() || candidate.size() > name.size() + limit || candidate.size() + limit < name.size())
            continue;
        const std::size_t distance = edit_distance(name, candidate);
        // Every letter changed is another name, however short.
        if (distance >= std::min(name.size(), candidate.size()) && distance > 0) continue;
        if (distance < best_distance || (distance == best_distance && candidate < best)) {
            best = candidate;
            best_distance = distance;
        }
    }
    return best;
}

std::string in_words(const std::vector<std::string>& words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
    return text;
}

}  // namespace meld::diagnostics
