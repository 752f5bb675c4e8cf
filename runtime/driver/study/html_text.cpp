#include "runtime/driver/study/html_text.h"

#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

std::string html(const std::string& text) {
    std::string out;
    for (const char c : visible(text))
        out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : c == '\'' ? "&#39;" : std::string(1, c);
    return out;
}

}  // namespace meld::driver
