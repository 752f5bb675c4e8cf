#include "runtime/sim/catoms/status.h"

#include <algorithm>

#include "runtime/base/assert.h"

namespace meld::sim {

void Totals::add(const Totals& other) {
    tick.awake += other.tick.awake;
    tick.derivations += other.tick.derivations;
    tick.changes += other.tick.changes;
    tick.messages += other.tick.messages;
    tick.dropped += other.tick.dropped;
    tick.far_facts += other.tick.far_facts;
    tick.far_hops += other.tick.far_hops;
    tick.cut = tick.cut || other.tick.cut;
    catoms += other.catoms;
    bytes += other.bytes;
    actions += other.actions;
    creations_requested += other.creations_requested;
    teleports += other.teleports;
    sent_bytes += other.sent_bytes;
    lost += other.lost;
    links_cut += other.links_cut;
    links_made += other.links_made;
    nodes_made += other.nodes_made;
    awake = awake || other.awake;
    waiting = waiting || other.waiting;
    timers = timers || other.timers;
    quarantines = quarantines || other.quarantines;
    undefined = undefined || other.undefined;
    stop = stop || other.stop;
    save = save || other.save;
    finished = finished || other.finished;
    greatest_rank = std::max(greatest_rank, other.greatest_rank);
    const bool earlier = other.failure.trap != Trap::None && (failure.trap == Trap::None || other.failure.catom < failure.catom);
    if (earlier) failure = other.failure;
}

void Status::end_tick(std::int64_t tick, bool well) {
    MELD_EXPECT(tick > last_tick_, "tick {} after tick {}", tick, last_tick_);
    half_way_ = !well;
    if (well) last_tick_ = tick;
}

}  // namespace meld::sim
