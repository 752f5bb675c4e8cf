#include "runtime/driver/study/shell_words.h"

#include <cctype>
#include <string_view>

namespace meld::driver {

std::string shell_words(const std::vector<std::string>& words) {
    constexpr std::string_view kPlain = "_-./=:,+@%";
    std::string text;
    for (const std::string& word : words) {
        bool plain = !word.empty();
        for (const char c : word)
            plain = plain && (std::isalnum(static_cast<unsigned char>(c)) || kPlain.find(c) != std::string_view::npos);
        text += text.empty() ? "" : " ";
        if (plain) {
            text += word;
            continue;
        }
        text += "'";
        for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
        text += "'";
    }
    return text;
}

}  // namespace meld::driver
