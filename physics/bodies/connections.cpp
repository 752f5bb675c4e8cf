// The graph of connections and its groups.
#include "physics/bodies/connections.h"

#include <algorithm>
#include <array>

#include "runtime/base/assert.h"

namespace meld::physics {

bool Connections::connected(BodyId one, BodyId other) const { return std::ranges::find(neighbours(one), other) != neighbours(one).end(); }

void Connections::note(std::uint32_t group) {
    if (groups_[group].changed) return;
    groups_[group].changed = true;
    changed_.push_back(group);
}

std::uint32_t Connections::new_group(std::vector<BodyId> bodies) {
    std::uint32_t group = static_cast<std::uint32_t>(groups_.size());
    if (free_.empty())
        groups_.emplace_back();
    else
        group = free_.back(), free_.pop_back();
    for (const BodyId body : bodies) group_of_[body] = group;
    groups_[group].count = static_cast<std::uint32_t>(bodies.size());
    groups_[group].list = std::move(bodies);
    groups_[group].sorted = 0;
    note(group);
    return group;
}

void Connections::end(std::uint32_t group) {
    groups_[group].list = {};
    groups_[group].sorted = groups_[group].count = 0;
    free_.push_back(group);
}

void Connections::add(std::uint32_t group, BodyId body) {
    // Bodies that come and go within a tick leave their names behind.
    constexpr std::size_t kFew = 64;
    if (groups_[group].list.size() > 2 * std::size_t{groups_[group].count} + kFew) clean(group);
    group_of_[body] = group;
    groups_[group].list.push_back(body);
    ++groups_[group].count;
    note(group);
}

void Connections::clean(std::uint32_t index) {
    Group& group = groups_[index];
    std::vector<BodyId>& list = group.list;
    const auto gone = [&](BodyId body) { return group_of_[body] != index; };
    group.sorted -= static_cast<std::size_t>(std::count_if(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(group.sorted), gone));
    std::erase_if(list, gone);
    const auto tail = list.begin() + static_cast<std::ptrdiff_t>(group.sorted);
    std::sort(tail, list.end());
    std::inplace_merge(list.begin(), tail, list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    group.sorted = list.size();
    MELD_ENSURE(list.size() == group.count, "{} of {} bodies", list.size(), group.count);
}

bool Connections::connect(BodyId one, BodyId other) {
    MELD_EXPECT(one != other, "body {}", one);
    const std::size_t size = std::max(one, other) + std::size_t{1};
    if (size > group_of_.size()) neighbours_.resize(size), group_of_.resize(size, kAlone), seen_.resize(size);
    if (connected(one, other)) return false;
    neighbours_[one].push_back(other), neighbours_[other].push_back(one);
    ++count_;
    std::uint32_t to = group_of_[one], from = group_of_[other];
    if (to == kAlone && from == kAlone) {
        new_group({one, other});
    } else if (to == kAlone || from == kAlone) {
        add(to == kAlone ? from : to, to == kAlone ? one : other);
    } else if (to != from) {
        if (groups_[to].count < groups_[from].count) std::swap(to, from);
        for (const BodyId body : groups_[from].list)
            if (group_of_[body] == from) add(to, body);
        end(from);
    }
    return true;
}

bool Connections::release(BodyId one, BodyId other) {
    if (!connected(one, other)) return false;
    std::erase(neighbours_[one], other), std::erase(neighbours_[other], one);
    --count_;
    std::vector<BodyId> side = smaller_side(one, other);
    if (side.empty()) return true;
    const std::uint32_t group = group_of_[one];
    const BodyId rest = side.front() == one ? other : one;
    groups_[group].count -= static_cast<std::uint32_t>(side.size());
    note(group);
    if (side.size() == 1)
        group_of_[side.front()] = kAlone;
    else
        new_group(std::move(side));
    if (groups_[group].count > 1) return true;
    group_of_[rest] = kAlone;
    end(group);
    return true;
}

void Connections::release_all(BodyId body) {
    while (!neighbours(body).empty()) release(body, neighbours(body).back());
}

std::vector<BodyId> Connections::smaller_side(BodyId one, BodyId other) {
    const std::uint64_t mark = 2 * ++searches_;
    std::array<std::vector<BodyId>, 2> found{{{one}, {other}}};
    std::array<std::size_t, 2> next{};
    seen_[one] = mark, seen_[other] = mark + 1;
    for (std::size_t side = 0;; side = 1 - side) {
        if (next[side] == found[side].size()) return std::move(found[side]);
        for (const BodyId body : neighbours_[found[side][next[side]++]]) {
            if (seen_[body] == mark + 1 - side) return {};
            if (seen_[body] == mark + side) continue;
            seen_[body] = mark + side;
            found[side].push_back(body);
        }
    }
}

std::vector<std::pair<BodyId, BodyId>> Connections::all() const {
    std::vector<std::pair<BodyId, BodyId>> pairs;
    pairs.reserve(count_);
    for (BodyId body = 0; body < neighbours_.size(); ++body)
        for (const BodyId other : neighbours_[body])
            if (body < other) pairs.emplace_back(body, other);
    std::ranges::sort(pairs);
    return pairs;
}

std::vector<std::vector<BodyId>> Connections::take_changed() {
    std::vector<std::vector<BodyId>> taken;
    for (const std::uint32_t group : changed_) {
        groups_[group].changed = false;
        if (groups_[group].count == 0) continue;
        clean(group);
        taken.push_back(groups_[group].list);
    }
    changed_.clear();
    std::ranges::sort(taken, {}, [](const std::vector<BodyId>& group) { return group.front(); });
    return taken;
}

std::size_t Connections::bytes() const {
    std::size_t sum = group_of_.capacity() * sizeof(std::uint32_t) + seen_.capacity() * sizeof(std::uint64_t) +
                      neighbours_.capacity() * sizeof(neighbours_[0]) + groups_.capacity() * sizeof(Group);
    for (const Group& group : groups_) sum += group.list.capacity() * sizeof(BodyId);
    for (const auto& list : neighbours_) sum += list.capacity() * sizeof(BodyId);
    return sum;
}

}  // namespace meld::physics
