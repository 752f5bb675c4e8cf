#include "runtime/sim/network/turns.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::sim {

bool Turns::Claim::before(const Claim& other) const {
    return std::tuple(-priority, since, id) < std::tuple(-other.priority, other.since, other.id);
}

// ---- priorities

void Turns::take(const tuple::ProgramActions& program, const std::vector<eval::Action>& actions) {
    std::vector<Change> changes;
    for (const eval::Action& action : actions) {
        const ActionKind kind = program.kind_of(action.predicate);
        if (info(kind).performer != ActionInfo::Performer::Clock) continue;
        const bool valued = info(kind).arguments > 1;
        changes.push_back({members_.ensemble.id(action.catom), action.arguments[0].catom, kind, valued ? action.arguments[1].real : 0});
    }
    if (comm_.processes() > 1) {
        ByteWriter mine;
        for (const Change& change : changes) mine.write(change);
        changes.clear();
        for (const auto& bytes : comm_.allgather_any(mine.view()))
            for (ByteReader in(bytes, "changes of priorities"); !in.done();) changes.push_back(in.read<Change>());
        // As on one process; those of one catom in the order in which it asked.
        std::ranges::stable_sort(changes, {}, &Change::from);
    }
    for (const Change& change : changes) {
        const auto catom = members_.ensemble.find(change.of);
        if (catom && members_.owned(*catom)) apply(change);
    }
}

void Turns::apply(const Change& change) {
    Node& node = known_[change.of];
    const auto pass = [&](double priority) {
        node.now = priority;
        node.passing = true;
    };
    switch (change.kind) {
        case ActionKind::SetPriority:
            if (change.value > node.priority()) pass(change.value);
            return;
        case ActionKind::UpdatePriority:
            return pass(change.value);
        case ActionKind::AddPriority:
            // From the least there is no way up.
            return pass((node.priority() == kLeast ? 0 : node.priority()) + change.value);
        case ActionKind::RemovePriority:
            node.passing = false;
            return;
        case ActionKind::ScheduleNext:
            return pass(-kLeast);
        case ActionKind::SetDefaultPriority:
            node.lasting = change.value;
            return;
        default:
            MELD_CHECK(false, "the clock does not carry out {}", info(change.kind).word);
    }
}

// ---- turns

std::vector<std::pair<Catom, Turns::Claim>> Turns::claims(i64 now, const std::function<bool(Catom)>& silent) {
    std::vector<std::pair<Catom, Node*>> working;
    facts_.evaluator.agenda().each([&](Catom catom, u64) {
        if (members_.owned(catom) && !silent(catom)) working.emplace_back(catom, &known_[members_.ensemble.id(catom)]);
    });
    for (const auto& [catom, node] : working) node->works = true;
    for (auto& [id, node] : known_) {
        if (!node.works) node.since = kIdle;
        if (!node.works && node.acted) node.passing = false;
        node.acted = false;
    }
    std::vector<std::pair<Catom, Claim>> all;
    for (const auto& [catom, node] : working) {
        if (node->since == kIdle) node->since = now;
        node->works = false;
        all.push_back({catom, {node->priority(), node->since, members_.ensemble.id(catom)}});
    }
    std::erase_if(known_, [](const auto& entry) { return entry.second.plain(); });
    return all;
}

void Turns::choose(i64 now, const std::function<bool(Catom)>& silent) {
    const std::vector<std::pair<Catom, Claim>> mine = claims(now, silent);
    for (const Catom catom : acting_) acts_[catom] = false;
    acting_.clear();
    acts_.resize(std::max(acts_.size(), std::size_t{members_.ensemble.index_count()}), false);
    if (kind_ == world::ClockKind::Sequential)
        choose_one(mine);
    else
        choose_among_neighbours(mine);
    for (const auto& [catom, claim] : mine) {
        if (!acts_[catom]) continue;
        acting_.push_back(catom);
        Node& node = known_.at(claim.id);
        node.acted = true;
        node.since = kIdle;
    }
}

void Turns::choose_one(const std::vector<std::pair<Catom, Claim>>& mine) {
    const auto first = std::ranges::min_element(mine, [](const auto& a, const auto& b) { return a.second.before(b.second); });
    if (comm_.processes() > 1) {
        ByteWriter bytes;
        if (first != mine.end()) bytes.write(first->second);
        for (const auto& other : comm_.allgather_any(bytes.view()))
            for (ByteReader in(other, "who comes first on each process"); !in.done();)
                if (const auto claim = in.read<Claim>(); first == mine.end() || claim.before(first->second)) return;
    }
    if (first != mine.end()) acts_[first->first] = true;
}

void Turns::choose_among_neighbours(const std::vector<std::pair<Catom, Claim>>& mine) {
    const world::Links& links = members_.ensemble.links();
    // Of catoms, owned or ghosts.
    constexpr u32 kNoClaim = 0xffffffff;
    claim_of_.resize(std::max(claim_of_.size(), std::size_t{members_.ensemble.index_count()}), kNoClaim);
    std::vector<std::pair<Catom, Claim>> claims = mine;
    if (comm_.processes() > 1) {
        ByteWriter bytes;
        for (const auto& [catom, claim] : mine) {
            bool border = false;
            links.each(catom, [&](world::Port, Catom other) { border = border || !members_.owned(other); });
            if (border) bytes.write(claim);
        }
        const auto all = comm_.allgather_any(bytes.view());
        for (std::size_t process = 0; process < all.size(); ++process) {
            if (static_cast<int>(process) == comm_.process()) continue;
            for (ByteReader in(all[process], "who has work on another process"); !in.done();) {
                const auto claim = in.read<Claim>();
                const auto ghost = members_.ensemble.find(claim.id);
                if (!ghost) continue;
                claims.emplace_back(*ghost, claim);
            }
        }
    }
    for (u32 i = 0; i < claims.size(); ++i) claim_of_[claims[i].first] = i;
    for (const auto& [catom, claim] : mine) {
        bool first = true;
        links.each(catom, [&](world::Port, Catom other) {
            first = first && (claim_of_[other] == kNoClaim || claim.before(claims[claim_of_[other]].second));
        });
        acts_[catom] = first;
    }
    for (const auto& [catom, claim] : claims) claim_of_[catom] = kNoClaim;
}

// ---- migration and snapshots

void Turns::pack(std::uint64_t id, ByteWriter& out) const {
    const auto found = known_.find(id);
    const Node node = found == known_.end() ? Node{} : found->second;
    out.write(node.lasting), out.write(node.now), out.write(node.since);
    out.write(node.passing), out.write(node.acted);
}

void Turns::unpack(std::uint64_t id, ByteReader& in) {
    Node node;
    node.lasting = in.read<double>(), node.now = in.read<double>(), node.since = in.read<i64>();
    node.passing = in.read<bool>(), node.acted = in.read<bool>();
    if (!node.plain()) known_[id] = node;
}

void Turns::save(ByteWriter& out) const {
    std::vector<std::uint64_t> ids;
    for (const auto& [id, node] : known_) ids.push_back(id);
    std::ranges::sort(ids);
    out.write_count(ids.size());
    for (const std::uint64_t id : ids) {
        out.write(id);
        pack(id, out);
    }
}

void Turns::load(const std::function<std::optional<u32>(u64)>& find, ByteReader& in) {
    for (std::size_t left = in.read_count(sizeof(u64)); left > 0 && !in.failed(); --left) {
        const auto id = in.read<std::uint64_t>();
        unpack(id, in);
        if (!find(id)) known_.erase(id);
    }
}

}  // namespace meld::sim
