#include "runtime/world/file/motion_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace meld::world {

bool KeysOfKind::has(std::string_view key) const { return std::ranges::find(keys, key) != keys.end(); }

void refuse_keys_of_others(const Section& section, std::string_view kind, std::initializer_list<KeysOfKind> kinds) {
    const KeysOfKind& own = *std::find_if(kinds.begin(), kinds.end(), [&](const KeysOfKind& k) { return k.kind == kind; });
    for (const KeysOfKind& other : kinds)
        for (const std::string_view key : other.keys)
            if (!own.has(key) && section.has(key))
                section.wrong(key, fmt::format("{} {} has no {}", kind.starts_with('e') ? "an" : "a", kind, key),
                              own.keys.empty() ? fmt::format("{} is of a {}", key, other.kind)
                                               : fmt::format("it has {}; {} is of a {}", fmt::join(own.keys, ", "), key, other.kind));
}

void read_breaking(const Section& section, std::optional<double>& force, std::optional<double>& torque) {
    double value = 1;
    if (section.has("breaking_force")) section.read_positive("breaking_force", value), force = value;
    value = 1;
    if (section.has("breaking_torque")) section.read_positive("breaking_torque", value), torque = value;
}

}  // namespace meld::world
