#include "runtime/sim/core/setup/unmatched_links.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

using world::LinkChoice;

namespace {

constexpr std::int64_t kEver = std::numeric_limits<std::int64_t>::max();

bool contains(const world::Region& region, const LinkFailures::End& end) { return region.contains(end.id, end.cell, end.position); }

}  // namespace

UnmatchedLinks::UnmatchedLinks(Subdomain& subdomain) : subdomain_(subdomain), ends_(subdomain) {
    for (const world::Event& event : subdomain.world.events)
        for (const LinkChoice& one : event.join) {
            joins_.emplace(one.pair->first, std::pair(one.pair->second, event.tick));
            joins_.emplace(one.pair->second, std::pair(one.pair->first, event.tick));
        }
}

bool UnmatchedLinks::known() const {
    const world::World& world = subdomain_.world;
    return world.motion.kind == "none" && world.components.empty() && !subdomain_.module.makes_nodes && !world.is_free();
}

bool UnmatchedLinks::joined(const Pair& pair, std::int64_t until) const {
    const auto [begin, end] = joins_.equal_range(pair.first);
    return std::any_of(begin, end, [&](const auto& one) { return one.second.first == pair.second && one.second.second <= until; });
}

template <class Test>
bool UnmatchedLinks::any_link(const Claim& claim, Catom catom, const Test& test) const {
    const world::Ensemble& ensemble = subdomain_.ensemble;
    const std::uint64_t id = ensemble.id(catom);
    bool any = false;
    if (ensemble.is_graph()) {
        const Nodes& nodes = subdomain_.nodes();
        const auto row = nodes.neighbours(*nodes.find(id));
        any = std::ranges::any_of(row, [&](graph::Node other) { return test(ends_.end_of_node(other)); });
    } else {
        for (int port = 0; port < subdomain_.lattice.ports() && !any; ++port)
            if (const auto other = ensemble.at(subdomain_.lattice.neighbour(ensemble.cell(catom), port))) any = test(ends_.end_of(*other));
    }
    if (any || claim.graph_only) return any;
    // Those that events have joined before, if the run goes on from a checkpoint.
    subdomain_.each_neighbour(catom, [&](Catom other) { any = any || test(ends_.end_of(other)); });
    const auto [begin, end] = joins_.equal_range(id);
    return any || std::any_of(begin, end, [&](const auto& one) {
               const auto node = subdomain_.nodes().find(one.second.first);
               return one.second.second <= claim.until && node && test(ends_.end_of_node(*node));
           });
}

bool UnmatchedLinks::matches_pair(const Claim& claim) const {
    const auto& [first, second] = *claim.pair;
    for (const auto& [here, there] : {std::pair(first, second), std::pair(second, first)}) {
        const std::optional<Catom> catom = subdomain_.ensemble.find(here);
        if (catom && subdomain_.owned(*catom) && any_link(claim, *catom, [&](const LinkFailures::End& end) { return end.id == there; }))
            return true;
    }
    return false;
}

bool UnmatchedLinks::matches_at(const Claim& claim, Catom catom) const {
    const bool in_first = subdomain_.members_.in_region(*claim.where, catom);
    if (claim.other == nullptr) return in_first && any_link(claim, catom, [](const LinkFailures::End&) { return true; });
    if (in_first && any_link(claim, catom, [&](const LinkFailures::End& end) { return contains(*claim.other, end); })) return true;
    return subdomain_.members_.in_region(*claim.other, catom) &&
           any_link(claim, catom, [&](const LinkFailures::End& end) { return contains(*claim.where, end); });
}

UnmatchedLinks::Claim UnmatchedLinks::claim(const LinkChoice& choice, std::int64_t until) const {
    return {.pair = choice.pair, .where = &choice.where, .other = choice.other ? &*choice.other : nullptr, .until = until};
}

void UnmatchedLinks::add_events() {
    for (const world::Event& event : subdomain_.world.events) {
        if (event.last() <= subdomain_.tick()) continue;
        const auto add = [&](const LinkChoice& choice, const char* done) {
            claims_.push_back(claim(choice, event.last()));
            claims_.back().warning = [&choice, done] {
                return fmt::format("{}: there are no {}, so nothing is {}", choice.place, choice.text(), done);
            };
        };
        for (const LinkChoice& choice : event.cut) add(choice, "cut");
        for (const LinkChoice& choice : event.heal) {
            add(choice, "healed");
            claims_.back().graph_only = true;
            if (!choice.pair || !joined(*choice.pair, kEver)) continue;
            claims_.back().warning = [&choice] {
                return fmt::format(
                    "{}: @{} and @{} have no link of the graph, only one that an event joins, so nothing is healed. write join "
                    "to make it again",
                    choice.place, choice.pair->first, choice.pair->second);
            };
        }
        for (const world::Jam& jam : event.jam) add(jam.links, "jammed");
    }
}

// Of nodes; others are refused where the world is read.
void UnmatchedLinks::add_joins() {
    for (const world::Event& event : subdomain_.world.events) {
        if (event.last() <= subdomain_.tick()) continue;
        for (const LinkChoice& choice : event.join) {
            const Nodes& nodes = subdomain_.nodes();
            const std::uint64_t missing = nodes.find(choice.pair->first) ? choice.pair->second : choice.pair->first;
            if (nodes.find(missing)) continue;
            claims_.push_back(claim(choice, 0));
            claims_.back().warning = [&choice, missing] {
                return fmt::format("{}: the graph has no node @{}, so nothing is joined", choice.place, missing);
            };
        }
    }
}

void UnmatchedLinks::look_at_events() {
    if (!known()) return;
    add_events();
    add_joins();
    report();
}

void UnmatchedLinks::look_at_start() {
    const world::World& world = subdomain_.world;
    if (!known()) return;
    for (const world::Faults& faults : world.faults) {
        if (!faults.strikes_links()) continue;
        claims_.push_back({.where = &faults.where, .until = faults.until});
        claims_.back().warning = [&faults] {
            const char* const done = faults.cut > 0 && faults.heal > 0 ? "cut or healed" : faults.cut > 0 ? "cut" : "healed";
            return fmt::format("{}: there are no links of `{}`, so nothing is {}", faults.place, faults.where.text(), done);
        };
    }
    // Facts that reach any node need no link.
    for (const world::NetworkOptions::Part& part : world.network.parts) {
        if (world.network.reach == world::Reach::Any) continue;
        claims_.push_back({.where = &part.where, .until = kEver});
        claims_.back().warning = [&part] {
            return fmt::format("{}: there are no links of `{}`, so this [[network.region]] has no effect", part.place, part.where.text());
        };
    }
    for (const world::NetworkOptions::Single& one : world.network.singles) {
        claims_.push_back({.pair = Pair(one.from, one.to), .until = kEver});
        claims_.back().warning = [&one, &world] {
            return fmt::format("{}:{}: there is no link from @{} to @{}, so this line has no effect", world.network.singles_path, one.line,
                               one.from, one.to);
        };
    }
    report();
}

void UnmatchedLinks::report() {
    std::vector<Claim*> open;
    for (Claim& one : claims_) {
        if (one.pair)
            one.matched = matches_pair(one);
        else
            open.push_back(&one);
    }
    for (Catom c = 0; c < subdomain_.ensemble.index_count() && !open.empty(); ++c) {
        if (!subdomain_.owned(c)) continue;
        std::erase_if(open, [&](Claim* one) { return one->matched = matches_at(*one, c); });
    }
    Unmatched unmatched(subdomain_.comm);
    for (Claim& one : claims_) unmatched.add(one.matched, std::move(one.warning));
    claims_.clear();
    unmatched.warn();
}

}  // namespace meld::sim
