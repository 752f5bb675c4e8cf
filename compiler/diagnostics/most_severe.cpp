#include "compiler/diagnostics/most_severe.h"

#include <algorithm>
#include <array>

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

void Counts::add(const std::vector<Diagnostic>& diagnostics) {
    for (const Diagnostic& d : diagnostics) ++of_[static_cast<std::size_t>(info(d.kind).severity)];
}

std::string Counts::in_words() const {
    constexpr std::array kWords = {"error", "warning", "note"};
    std::vector<std::string> words;
    for (std::size_t i = 0; i < of_.size(); ++i)
        if (of_[i] > 0) words.push_back(fmt::format("{} {}{}", of_[i], kWords[i], of_[i] == 1 ? "" : "s"));
    return diagnostics::in_words(words);
}

std::string count_in_words(const std::vector<Diagnostic>& diagnostics) {
    Counts counts;
    counts.add(diagnostics);
    return counts.in_words();
}

}  // namespace meld::diagnostics
