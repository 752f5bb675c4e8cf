// Where the parts of a rule stand in its text, as Meld prints it.
#pragma once

#include <cstddef>
#include <string_view>

namespace meld::debug {

// The first place of `what` that is not within a string; npos: there is none.
inline std::size_t find_outside_strings(std::string_view text, std::string_view what) {
    bool quoted = false;
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
        if (quoted && text[i] == '\\')
            ++i;
        else if (text[i] == '"')
            quoted = !quoted;
        else if (!quoted && text.substr(i, what.size()) == what)
            return i;
    }
    return std::string_view::npos;
}

}  // namespace meld::debug
