// The part of a network that carries linear facts to nodes of a graph without a link: [network] reach = "any". Each pair of nodes has the
// terms that a link between them would have.
#include <algorithm>

#include "runtime/sim/network/network.h"

namespace meld::sim {

const world::LinkTerms& Network::terms_of_nodes(u64 a, u64 b) const {
    const auto in = [&](const world::Region& where, u64 id) {
        const graph::Point& at = members_.nodes->place(*members_.nodes->find(id));
        const world::Vec3 position = {at[0], at[1], 0};
        return where.contains(id, nearest_cell(position), position);
    };
    u32 last = 0;
    for (u32 part = 0; part < world_.network.parts.size(); ++part)
        if (in(world_.network.parts[part].where, a) || in(world_.network.parts[part].where, b)) last = part + 1;
    return fates_.terms(last);
}

void Network::sent_far(i64 now, Catom to, u64 from, u16 predicate, const Value* arguments) {
    const u64 id = members_.ensemble.id(to);
    const world::LinkTerms& terms = terms_of_nodes(from, id);
    const world::Fate fate = world::fate(world_.network.kind, terms, world_.seed, from, id, now);
    if (!fate.arrives) {
        ++lost_;
        return;
    }
    i64& last = last_far_[{from, id}];
    const auto post = [&](u32 ticks) {
        const i64 arrival = world_.clock.next(world_.seed, id, now + ticks);
        last = terms.reorder ? arrival : std::max(last, arrival);
        far_.push_back({last, id, from, predicate, argument_bytes(predicate, arguments)});
    };
    post(fate.ticks);
    if (fate.twice_after != 0) post(fate.twice_after);
}

void Network::deliver_far(i64 next, std::vector<Arrived>& messages, std::deque<std::vector<Value>>& arguments, tuple::Arena& lists) {
    std::erase_if(last_far_, [&](const auto& each) { return each.second <= next; });
    const auto due = std::ranges::stable_partition(far_, [&](const Far& far) { return far.arrival > next; });
    for (const Far& far : due) {
        const std::optional<Catom> to = members_.ensemble.find(far.to);
        if (to && members_.owned(*to))
            messages.push_back({*to, far.from, far.predicate, read_arguments(far.predicate, far.bytes, arguments, lists)});
        else
            ++lost_;
    }
    far_.erase(due.begin(), due.end());
}

void Network::save_far(i64 now, ByteWriter& out) const {
    out.write_count(far_.size());
    for (const Far& far : far_) {
        out.write(far.arrival - now);
        out.write(far.to);
        out.write(far.from);
        out.write(far.predicate);
        const std::optional<Catom> to = members_.ensemble.find(far.to);
        out.write(to && members_.owned(*to));
        out.write_block(far.bytes);
    }
}

void Network::load_far(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    for (std::size_t left = in.read_count(3 * sizeof(u64)); left > 0 && !in.failed(); --left) {
        const auto ticks = in.read<i64>();
        const auto to = in.read<u64>(), from = in.read<u64>();
        const auto predicate = in.read<u16>();
        const bool arrives = in.read<bool>();
        const std::span<const std::byte> bytes = in.read_block();
        if (in.failed() || ticks <= 0 || predicate >= module_.predicate_count) return;
        if (arrives ? !find(to) : !takes_lost) continue;
        // This world's network may be faster.
        const i64 arrival = now + std::min<i64>(ticks, world_.latency());
        i64& last = last_far_[{from, to}];
        last = std::max(last, arrival);
        far_.push_back({arrival, to, from, predicate, {bytes.begin(), bytes.end()}});
    }
}

}  // namespace meld::sim
