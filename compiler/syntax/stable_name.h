// stable(p(A), 5) is read as a fact of a predicate of the compiler's, p@stable5, whose name nobody else can write; it is printed as it was.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace meld::syntax {

inline constexpr std::string_view kStable = "@stable";

inline std::string stable_name(std::string_view predicate, std::int64_t ticks) { return fmt::format("{}{}{}", predicate, kStable, ticks); }

struct Stable {
    std::string_view predicate, ticks;
};
// What such a name says; nothing: it is another one. Valid as long as the name.
inline std::optional<Stable> read_stable_name(std::string_view name) {
    const std::size_t mark = name.find(kStable);
    if (mark == std::string_view::npos) return std::nullopt;
    return Stable{name.substr(0, mark), name.substr(mark + kStable.size())};
}

// A fact as people write it: of its name, and its arguments as text.
inline std::string print_fact(std::string_view name, std::string_view arguments) {
    const std::optional<Stable> stable = read_stable_name(name);
    return stable ? fmt::format("stable({}({}), {})", stable->predicate, arguments, stable->ticks) : fmt::format("{}({})", name, arguments);
}

}  // namespace meld::syntax
