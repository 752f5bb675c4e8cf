#include "runtime/results/profile/rule_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "runtime/base/terminal/terminal_text.h"

namespace meld::profile {

std::string rule_text(const nlohmann::ordered_json& rule) {
    std::string text = rule.at("text").get<std::string>();
    for (std::size_t at; (at = text.find('\n')) != std::string::npos;) {
        const std::size_t end = text.find_first_not_of(" \n", at);
        text.replace(at, (end == std::string::npos ? text.size() : end) - at, " ");
    }
    const std::string file = rule.at("file").get<std::string>();
    return visible(fmt::format("{}  {}{}", rule.at("rule").get<std::string>(), text, file.empty() ? "  (made by the compiler)" : ""));
}

}  // namespace meld::profile
