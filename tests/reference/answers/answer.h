// An answer of `why` or `why-not`, as its JSON says it (docs/reference/debugging.md, "JSON").
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace meld::reference {

struct Answer {
    struct Part {
        std::string is, text, note;
        std::optional<std::size_t> node;
        std::optional<std::int64_t> tick;
    };
    struct Way {
        std::string rule, text, file, note;
        std::int64_t line = 0;
        std::int64_t catom = -1;                  // Where a linear rule fired.
        std::map<std::string, std::string> with;  // The values of its variables.
        std::vector<Part> parts;
        bool has_rule() const { return !text.empty(); }
    };
    struct Node {
        std::string fact, is, note;
        std::int64_t tick = 0;
        std::optional<std::uint64_t> rank;
        std::vector<Way> ways;
        std::uint64_t more = 0;
        std::vector<std::string> others;
    };
    std::int64_t tick = 0;
    std::vector<std::size_t> roots;
    std::vector<Node> nodes;
    std::uint64_t more = 0;
};

// Throws what the JSON library throws if a key is missing or of another type.
Answer read_answer(const nlohmann::ordered_json& json);

inline bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

}  // namespace meld::reference
