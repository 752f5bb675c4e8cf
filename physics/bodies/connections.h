// Which bodies are rigidly connected to which, and the groups that this makes: two bodies are in one group if connections lead from one to
// the other. Making a connection relabels the smaller of two groups; breaking one searches from both ends at once, so it costs as much as
// the smaller part has bodies and connections, or as the shortest way round.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/types.h"

namespace meld::physics {

class Connections {
  public:
    // Connects or releases two different bodies; false if that was so already.
    bool connect(BodyId one, BodyId other);
    bool release(BodyId one, BodyId other);
    void release_all(BodyId body);

    // Its group counts as changed.
    void touch(BodyId body) {
        if (group_of(body) != kAlone) note(group_of(body));
    }

    bool empty() const { return count_ == 0; }
    std::size_t count() const { return count_; }
    bool connected(BodyId one, BodyId other) const;
    // Whether connections lead from one to the other.
    bool together(BodyId one, BodyId other) const {
        const std::uint32_t group = group_of(one);
        return group != kAlone && group == group_of(other);
    }
    std::span<const BodyId> neighbours(BodyId body) const {
        return body < neighbours_.size() ? std::span<const BodyId>(neighbours_[body]) : std::span<const BodyId>();
    }
    // Whether its group has the bodies that it had when take_changed was last called.
    bool in_same_group(BodyId body) const { return group_of(body) != kAlone && !groups_[group_of(body)].changed; }
    // Whether these bodies, each named once, are all that are in the group of the first.
    template <class Bodies>
    bool are_a_group(const Bodies& bodies) const {
        const std::uint32_t group = group_of(*bodies.begin());
        return group != kAlone && groups_[group].count == bodies.size() &&
               std::ranges::all_of(bodies, [&](BodyId body) { return group_of(body) == group; });
    }
    // All of them, the lower number first; sorted.
    std::vector<std::pair<BodyId, BodyId>> all() const;

    // The groups of two or more that have changed since this was last called, each sorted, in the order of their lowest numbers.
    std::vector<std::vector<BodyId>> take_changed();
    std::size_t bytes() const;

  private:
    static constexpr std::uint32_t kAlone = 0xffffffff;
    // The list may name bodies that have left, and a body twice that has come back; up to `sorted` it is sorted.
    struct Group {
        std::vector<BodyId> list;
        std::size_t sorted = 0;
        std::uint32_t count = 0;
        bool changed = false;
    };

    std::uint32_t group_of(BodyId body) const { return body < group_of_.size() ? group_of_[body] : kAlone; }
    std::uint32_t new_group(std::vector<BodyId> bodies);
    void add(std::uint32_t group, BodyId body);
    void note(std::uint32_t group);
    void clean(std::uint32_t group);
    void end(std::uint32_t group);
    // The bodies on the side of one of the two that is searched completely first; empty if they are still together.
    std::vector<BodyId> smaller_side(BodyId one, BodyId other);

    std::vector<std::vector<BodyId>> neighbours_;
    std::vector<std::uint32_t> group_of_;
    std::vector<Group> groups_;
    std::vector<std::uint32_t> free_, changed_;
    // By body: twice the number of the search that has seen it last, plus the side.
    std::vector<std::uint64_t> seen_;
    std::uint64_t searches_ = 0;
    std::size_t count_ = 0;
};

}  // namespace meld::physics
