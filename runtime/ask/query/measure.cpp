#include "runtime/ask/query/measure.h"

namespace meld::inspect {

std::string body_of_measure(const std::string& text) {
    const std::size_t open = text.find('{');
    const std::size_t colon = open == std::string::npos ? open : text.find_last_not_of(" \t\n", open == 0 ? 0 : open - 1);
    if (colon == std::string::npos || open == 0 || text[colon] != ':') return text;
    // What stands before the colon: an aggregate, and what it is of. A body with a comparison or a fact before it names its value itself.
    const std::string before = text.substr(0, colon);
    if (before.find_first_of("=<>!,\"") != std::string::npos || before.find(":-") != std::string::npos) return text;
    int depth = 0;
    bool quoted = false;
    std::size_t end = open;
    for (; end < text.size(); ++end) {
        const char c = text[end];
        if (c == '\\' && quoted) {
            ++end;
        } else if (c == '"') {
            quoted = !quoted;
        } else if (!quoted) {
            depth += c == '{' ? 1 : c == '}' ? -1 : 0;
            if (depth == 0) break;
        }
    }
    if (end >= text.size()) return text;
    const std::string aggregate = "Measured = " + text.substr(0, end + 1);
    const std::size_t rest = text.find_first_not_of(" \t\n", end + 1);
    if (rest == std::string::npos) return aggregate;
    return text.find_first_of("=<>!", rest) == rest ? aggregate + ", Measured " + text.substr(rest) : text;
}

}  // namespace meld::inspect
