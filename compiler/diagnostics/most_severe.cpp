#include "compiler/diagnostics/most_severe.h"

#include <algorithm>
#include <array>
#include <utility>

namespace meld::diagnostics {

std::vector<Diagnostic> most_severe(const std::vector<Diagnostic>& diagnostics, std::size_t most) {
    std::vector<std::size_t> chosen;
    for (const Severity severity : {Severity::Error, Severity::Warning, Severity::Note})
        for (std::size_t i = 0; i < diagnostics.size() && chosen.size() < most; ++i)
            if (info(diagnostics[i].kind).severity == severity) chosen.push_back(i);
    std::sort(chosen.begin(), chosen.end());
    std::vector<Diagnostic> result;
    for (const std::size_t i : chosen) result.push_back(diagnostics[i]);
    return result;
}

std::string count_in_words(const std::vector<Diagnostic>& diagnostics) {
    constexpr std::array kWords = {std::pair(Severity::Error, "error"), std::pair(Severity::Warning, "warning"),
                                   std::pair(Severity::Note, "note")};
    std::vector<std::string> words;
    for (const auto& [severity, word] : kWords) {
        const auto count = std::count_if(diagnostics.begin(), diagnostics.end(),
                                         [wanted = severity](const Diagnostic& d) { return info(d.kind).severity == wanted; });
        if (count > 0) words.push_back(fmt::format("{} {}{}", count, word, count == 1 ? "" : "s"));
    }
    return in_words(words);
}

}  // namespace meld::diagnostics
