// Names and lists of words for the text of messages.
#include <optional>

#include "compiler/diagnostics/diagnostics.h"
#include "runtime/base/did_you_mean.h"

namespace meld::diagnostics {

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
    const std::vector<std::string_view> views(candidates.begin(), candidates.end());
    return std::string(meld::nearest_name(name, views).value_or(""));
}

std::string in_words(const std::vector<std::string>& words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
    return text;
}

}  // namespace meld::diagnostics
