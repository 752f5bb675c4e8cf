#include "runtime/sim/contact_links.h"

#include "runtime/base/assert.h"

namespace meld::sim {

void ContactLinks::update(PartState& part, std::span<const physics::TouchEvent> events) {
    // What has ended makes room for what has begun.
    for (const physics::TouchEvent& e : events)
        if (!e.began && !e.touch.other_is_obstacle) end(part, {e.touch.body, e.touch.other});
    for (const physics::TouchEvent& e : events)
        if (e.began && !e.touch.other_is_obstacle) waiting_.insert({e.touch.body, e.touch.other});
    for (auto it = waiting_.begin(); it != waiting_.end();) it = begin(part, *it) ? waiting_.erase(it) : std::next(it);
}

void ContactLinks::end(PartState& part, Pair ids) {
    if (waiting_.erase(ids) > 0) return;
    const Catom a = *part.ensemble.find(ids.first), b = *part.ensemble.find(ids.second);
    const std::optional<int> port = part.ensemble.port_towards(a, b);
    MELD_CHECK(port.has_value(), "catoms {} and {} part and were never linked", ids.first, ids.second);
    part.ensemble.unlink(a, *port);
    for (const Catom catom : {a, b}) part.mark(catom, kDirtyLinks);
}

bool ContactLinks::begin(PartState& part, Pair ids) {
    const Catom a = *part.ensemble.find(ids.first), b = *part.ensemble.find(ids.second);
    const std::optional<int> port_of_a = part.ensemble.vacant_port(a), port_of_b = part.ensemble.vacant_port(b);
    if (!port_of_a || !port_of_b) return false;
    part.ensemble.link(a, *port_of_a, b, *port_of_b);
    for (const Catom catom : {a, b}) part.mark(catom, kDirtyLinks);
    return true;
}

}  // namespace meld::sim
