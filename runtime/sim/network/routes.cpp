#include "runtime/sim/network/routes.h"

#include <algorithm>
#include <limits>

#include "runtime/base/assert.h"

namespace meld::sim {
namespace {

constexpr std::int32_t kGone = -1;
constexpr std::uint32_t kFar = std::numeric_limits<std::uint32_t>::max();
// Of distances that are kept, on each process.
constexpr std::size_t kMaxKept_bytes = std::size_t{64} << 20;

}  // namespace

Routes::Routes(bool anywhere, const Membership& members, const comm::Communicator& comm)
    : anywhere_(anywhere), members_(members), process_(comm.process()) {}

std::int32_t Routes::known_owner(Node node) const { return node < owner_.size() ? owner_[node] : kGone; }

std::span<const Routes::Node> Routes::neighbours(Node node) const {
    if (!neighbours_.empty())
        if (const auto found = neighbours_.find(node); found != neighbours_.end()) return found->second;
    return members_.nodes->neighbours(node);
}

std::vector<Routes::Node> Routes::neighbours_now(Catom catom) const {
    std::vector<Node> nodes;
    members_.ensemble.links().each(catom,
                                   [&](world::Port, Catom other) { nodes.push_back(*members_.nodes->find(members_.ensemble.id(other))); });
    std::ranges::sort(nodes);
    return nodes;
}

void Routes::report(ByteWriter& out) const {
    std::vector<Node> come, gone;
    std::vector<std::pair<Node, std::vector<Node>>> rows;
    if (!seen_ || *seen_ != now()) {
        const world::Ensemble& ensemble = members_.ensemble;
        for (Catom c = 0; c < ensemble.index_count(); ++c) {
            if (ensemble.state(c) != kCatomOwned) continue;
            const Node node = *members_.nodes->find(ensemble.id(c));
            if (known_owner(node) != process_) come.push_back(node);
            std::vector<Node> row = neighbours_now(c);
            if (!std::ranges::equal(row, neighbours(node))) rows.emplace_back(node, std::move(row));
        }
        for (Node node = 0; node < owner_.size(); ++node)
            if (owner_[node] == process_ && !ensemble.find(members_.nodes->id(node))) gone.push_back(node);
    }
    const auto write = [&](const std::vector<Node>& nodes) {
        out.write_count(nodes.size());
        for (const Node node : nodes) out.write(node);
    };
    write(come);
    write(gone);
    out.write_count(rows.size());
    for (const auto& [node, row] : rows) {
        out.write(node);
        write(row);
    }
}

void Routes::take(int process, ByteReader& in) {
    const auto read = [&] {
        std::vector<Node> nodes(in.read_count(sizeof(Node)));
        for (Node& node : nodes) node = in.read<Node>();
        return nodes;
    };
    owner_.resize(members_.nodes->count(), kGone);
    const std::vector<Node> come = read(), gone = read();
    for (const Node node : come) owner_[node] = process;
    for (const Node node : gone) {
        owner_[node] = kGone;
        neighbours_[node] = {};
    }
    const std::size_t rows = in.read_count(sizeof(Node));
    for (std::size_t i = 0; i < rows; ++i) {
        const auto node = in.read<Node>();
        neighbours_[node] = read();
    }
    changed_ = changed_ || !come.empty() || !gone.empty() || rows > 0;
}

void Routes::settle() {
    seen_ = now();
    if (std::exchange(changed_, false)) distances_.clear();
}

const std::vector<std::uint32_t>& Routes::distances_from(Node target) const {
    const auto found = distances_.find(target);
    if (found != distances_.end()) return found->second;
    if ((distances_.size() + 1) * owner_.size() * sizeof(std::uint32_t) > kMaxKept_bytes) distances_.clear();
    std::vector<std::uint32_t> distance(owner_.size(), kFar);
    std::vector<Node> todo{target};
    distance[target] = 0;
    for (std::size_t i = 0; i < todo.size(); ++i)
        for (const Node other : neighbours(todo[i]))
            if (distance[other] == kFar) {
                distance[other] = distance[todo[i]] + 1;
                todo.push_back(other);
            }
    return distances_.emplace(target, std::move(distance)).first->second;
}

u64 Routes::next_hop(Catom from, u64 target) const {
    const u64 here = members_.ensemble.id(from);
    if (target == here || !owner(target)) return here;
    if (anywhere_) return target;
    const std::scoped_lock lock(mutex_);
    const std::vector<std::uint32_t>& distance = distances_from(*members_.nodes->find(target));
    std::uint32_t least = kFar;
    u64 next = here;
    members_.ensemble.links().each(from, [&](world::Port, Catom other) {
        const u64 id = members_.ensemble.id(other);
        const std::uint32_t its = distance[*members_.nodes->find(id)];
        if (its < least || (its == least && its != kFar && id < next)) {
            least = its;
            next = id;
        }
    });
    return next;
}

std::optional<int> Routes::owner(u64 id) const {
    const std::optional<Node> node = members_.nodes->find(id);
    const std::int32_t known = node ? known_owner(*node) : kGone;
    return known != kGone ? std::optional<int>(known) : std::nullopt;
}

double Routes::most_distances_bytes(double nodes) {
    const double one = static_cast<double>(sizeof(std::uint32_t)) * nodes;
    return std::min(one * nodes, std::max(static_cast<double>(kMaxKept_bytes), one));
}

std::size_t Routes::bytes() const {
    std::size_t all = owner_.capacity() * sizeof(std::int32_t);
    for (const auto& [node, row] : neighbours_) all += row.capacity() * sizeof(Node) + sizeof(row);
    for (const auto& [node, row] : distances_) all += row.capacity() * sizeof(std::uint32_t);
    return all;
}

}  // namespace meld::sim
