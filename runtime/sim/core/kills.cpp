#include "runtime/sim/core/kills.h"

#include <algorithm>
#include <optional>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/log.h"

namespace meld::sim {

template <class Visit>
void Kills::each(const world::Killing& killing, const Visit& visit) const {
    if (killing.id) {
        const std::optional<Catom> catom = subdomain_.ensemble.find(*killing.id);
        if (catom && subdomain_.owned(*catom)) visit(*catom);
        return;
    }
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
        if (subdomain_.owned(c) && subdomain_.members_.in_region(killing.where, c)) visit(c);
}

void Kills::look_at_events() const {
    // Catoms that move may come to be where an event looks for them.
    if (subdomain_.world.motion.kind != "none" || !subdomain_.world.components.empty()) return;
    for (const world::Event& event : subdomain_.world.events) {
        if (event.last() <= subdomain_.tick()) continue;
        for (const world::Killing& killing : event.kill) {
            std::uint64_t matched = 0;
            each(killing, [&](Catom) { ++matched; });
            ByteWriter mine;
            mine.write(matched);
            const std::vector<std::byte> all = subdomain_.comm.allgather(mine.view());
            for (matched = 0; const std::byte byte : all) matched += byte != std::byte{0} ? 1 : 0;
            if (matched > 0 || subdomain_.comm.process() != 0) continue;
            if (killing.id)
                log::warning("{}: there is no catom @{}, so nothing is killed", killing.place, *killing.id);
            else
                log::warning("{}: `{}` matches no catom, so nothing is killed", killing.place, killing.where.text());
        }
    }
}

std::vector<Killed> Kills::of_this_tick() const {
    std::vector<Killed> killed;
    bool any = false;
    for (const world::Event& event : subdomain_.world.events) {
        if (event.kill.empty() || !event.happens_in(subdomain_.tick())) continue;
        any = true;
        for (const world::Killing& killing : event.kill)
            each(killing, [&](Catom c) {
                killed.push_back({subdomain_.ensemble.id(c), subdomain_.ensemble.is_free() ? Cell{} : subdomain_.ensemble.cell(c)});
            });
    }
    // The same on all processes.
    if (!any) return killed;
    if (!subdomain_.alone()) {
        ByteWriter mine;
        for (const Killed& each : killed) {
            mine.write(each.id);
            mine.write(each.cell);
        }
        killed.clear();
        for (const auto& theirs : subdomain_.comm.allgather_any(mine.view()))
            for (ByteReader in(theirs, "catoms that are killed"); !in.done();) {
                const auto id = in.read<std::uint64_t>();
                killed.push_back({id, in.read<Cell>()});
            }
    }
    std::ranges::sort(killed, {}, &Killed::id);
    const auto twice = std::ranges::unique(killed, {}, &Killed::id);
    killed.erase(twice.begin(), twice.end());
    return killed;
}

// A node, and ghosts that nothing of this process has a link with any more.
void Kills::take_node(std::uint64_t id) {
    const std::optional<Catom> catom = subdomain_.ensemble.find(id);
    if (!catom) return;
    std::vector<Catom> around;
    subdomain_.each_neighbour(*catom, [&](Catom other) { around.push_back(other); });
    subdomain_.mark_neighbours(*catom, kDirtyLinks);
    subdomain_.remove_freely(*catom);
    for (const Catom other : around) {
        bool linked = false;
        subdomain_.each_neighbour(other, [&](Catom) { linked = true; });
        if (!linked && !subdomain_.owned(other)) subdomain_.remove_freely(other);
    }
}

void Kills::take_out(std::span<const Killed> killed) {
    subdomain_.note_change();
    for (const Killed& each : killed) {
        if (subdomain_.ensemble.is_graph()) {
            take_node(each.id);
            continue;
        }
        if (subdomain_.ensemble.is_free()) {
            MELD_CHECK(!subdomain_.ensemble.find(each.id), "catom @{} is still there", each.id);
            continue;
        }
        // Another process may not know the cell.
        if (const std::optional<Catom> catom = subdomain_.ensemble.at(each.cell)) subdomain_.remove_catom(*catom);
    }
    subdomain_.refresh();
}

}  // namespace meld::sim
