#include "runtime/sim/catoms/nodes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/base/assert.h"

namespace meld::sim {

namespace {

// Of the spiral, in diameters: the first turn is that far from the maker, and points keep about that far from each other.
constexpr double kApart = 1.5;

}  // namespace

std::optional<Nodes::Node> Nodes::find(std::uint64_t id) const {
    if (made_.empty() || id < made_.front().id) return graph_.find(id);
    const auto at = std::ranges::lower_bound(made_, id, {}, &Made::id);
    if (at == made_.end() || at->id != id) return std::nullopt;
    return static_cast<Node>(graph_.nodes() + static_cast<std::uint64_t>(at - made_.begin()));
}

void Nodes::add(std::uint64_t id, Node maker) {
    MELD_EXPECT(id >= graph_.next_id() && (made_.empty() || id > made_.back().id) && maker < count(), "node @{} made by node {} of {}", id,
                maker, count());
    MELD_CHECK(count() < graph::kMaxNodes, "there are {} nodes", count());
    const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
    const double k = ++children_[maker], r = kApart * std::sqrt(k);
    const graph::Point& at = place(maker);
    made_.push_back({id, maker, {at[0] + r * std::cos(k * turn), at[1] + r * std::sin(k * turn), at[2]}});
}

std::size_t Nodes::bytes() const {
    return places_.capacity() * sizeof(graph::Point) + made_.capacity() * sizeof(Made) +
           children_.size() * (sizeof(Node) + sizeof(std::uint32_t) + 2 * sizeof(void*));
}

}  // namespace meld::sim
