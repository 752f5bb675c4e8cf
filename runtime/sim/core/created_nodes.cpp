#include "runtime/sim/core/created_nodes.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/sim/core/programs.h"

namespace meld::sim {

u64 Births::number(const Membership& members, Catom maker, u32 number) {
    return members.next_id + number * members.nodes->count() + *members.nodes->find(members.ensemble.id(maker));
}

// Of all processes, in the order of their numbers. The next number is above all that have been given away, also to no node.
std::vector<Births::Newborn> Births::all() {
    std::vector<Newborn> born;
    for (const Fact& fact : facts_)
        if (born.empty() || born.back().id != fact.to) born.push_back({fact.to, fact.from});
    u64 next = std::max(subdomain_.next_id(), subdomain_.facts_.evaluator.greatest_new_node() + 1);
    if (!subdomain_.alone()) {
        ByteWriter mine;
        mine.write(next);
        for (const Newborn& one : born) mine.write(one);
        born.clear();
        for (const auto& theirs : subdomain_.comm.allgather_any(mine.view())) {
            ByteReader in(theirs, "nodes that have been made");
            next = std::max(next, in.read<u64>());
            while (!in.done()) born.push_back(in.read<Newborn>());
        }
        std::ranges::sort(born, {}, &Newborn::id);
    }
    subdomain_.take_ids(next - subdomain_.next_id());
    return born;
}

void Births::place(u64 id) {
    Membership& m = subdomain_.members_;
    const graph::Point& at = m.nodes->place(*m.nodes->find(id));
    const Catom catom = subdomain_.add_freely(id, at, kCatomOwned, subdomain_.comm.process());
    m.ensemble.links().room(catom, 0);
    Programs(subdomain_).begin(catom);
    subdomain_.mark(catom, kDirtyBirths);
    ++subdomain_.status_.nodes_made;
}

const std::vector<Births::Fact>& Births::run() {
    Membership& m = subdomain_.members_;
    std::ranges::stable_sort(facts_, {}, &Fact::to);
    for (const Newborn& one : all()) {
        m.nodes->add(one.id, *m.nodes->find(one.maker));
        if (Nodes::owner(one.id, subdomain_.comm.processes()) == subdomain_.comm.process()) place(one.id);
    }
    if (facts_.empty()) return facts_;
    subdomain_.refresh();
    for (Fact& fact : facts_) fact.catom = m.ensemble.find(fact.to);
    return facts_;
}

}  // namespace meld::sim
