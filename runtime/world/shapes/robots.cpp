#include "runtime/world/shapes/robots.h"

#include <algorithm>

namespace meld::world {

std::optional<std::uint32_t> Assembly::part_named(std::string_view part) const {
    const auto found = std::ranges::find(parts, part);
    return found == parts.end() ? std::nullopt : std::optional(static_cast<std::uint32_t>(found - parts.begin()));
}

bool Assembly::connects(std::uint32_t part) const {
    return std::ranges::any_of(connections, [&](const auto& pair) { return pair[0] == part || pair[1] == part; });
}

bool Assembly::connects(std::uint32_t one, std::uint32_t other) const {
    return std::ranges::binary_search(connections, std::array{std::min(one, other), std::max(one, other)});
}

std::optional<RobotPart> Robots::of(std::uint64_t catom) const {
    if (catom < first_listed_) return std::nullopt;
    const std::uint64_t listed = catom - first_listed_;
    auto group = std::ranges::upper_bound(groups_, listed, {}, &RobotGroup::first_catom);
    if (group == groups_.begin()) return std::nullopt;
    --group;
    const std::uint64_t parts = assemblies_[group->assembly].parts.size(), behind = listed - group->first_catom;
    if (behind / parts >= group->robots) return std::nullopt;
    return RobotPart{.group = static_cast<std::uint32_t>(group - groups_.begin()),
                     .assembly = group->assembly,
                     .part = static_cast<std::uint32_t>(behind % parts),
                     .robot = group->first_robot + behind / parts,
                     .first_catom = catom - behind % parts};
}

const Turn* Robots::turn_of(const RobotPart& part) const {
    const RobotGroup& group = groups_[part.group];
    return group.turns.empty() ? nullptr : &group.turns[part.robot - group.first_robot];
}

bool Robots::connects() const {
    return std::ranges::any_of(groups_, [&](const RobotGroup& group) { return !assemblies_[group.assembly].connections.empty(); });
}

}  // namespace meld::world
