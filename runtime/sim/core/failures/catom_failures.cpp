#include "runtime/sim/core/failures/catom_failures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/programs.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

namespace {

struct Way {
    std::vector<Killed> Struck::* struck;
    std::vector<world::CatomChoice> world::Event::* event;
    world::Fault fault;
    double world::Faults::* probability;
    const char* done;
};
constexpr std::array kWays = {
    Way{&Struck::killed, &world::Event::kill, world::Fault::Kill, &world::Faults::kill, "is killed"},
    Way{&Struck::hung, &world::Event::hang, world::Fault::Hang, &world::Faults::hang, "hangs"},
    Way{&Struck::restarted, &world::Event::restart, world::Fault::Restart, &world::Faults::restart, "restarts"},
};

}  // namespace

template <class Visit>
void CatomFailures::each(const world::CatomChoice& choice, const Visit& visit) const {
    if (choice.id) {
        const std::optional<Catom> catom = subdomain_.ensemble.find(*choice.id);
        if (catom && subdomain_.owned(*catom)) visit(*catom);
        return;
    }
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
        if (subdomain_.owned(c) && subdomain_.members_.in_region(choice.where, c)) visit(c);
}

template <class Visit>
void CatomFailures::each_struck(world::Fault fault, double world::Faults::* probability, const Visit& visit) const {
    const world::World& world = subdomain_.world;
    for (std::size_t i = 0; i < world.faults.size(); ++i) {
        const world::Faults& faults = world.faults[i];
        if (faults.*probability <= 0 || !faults.strikes_in(subdomain_.tick())) continue;
        for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
            if (subdomain_.owned(c) &&
                world::strikes(fault, faults.*probability, world.seed, i, subdomain_.ensemble.id(c), subdomain_.tick()) &&
                subdomain_.members_.in_region(faults.where, c))
                visit(c);
    }
}

void CatomFailures::look_at_events() const {
    // Catoms that move, or are made, may come to be where an event looks for them.
    if (!still()) return;
    Unmatched unmatched(subdomain_.comm);
    for (const world::Event& event : subdomain_.world.events) {
        if (event.last() <= subdomain_.tick()) continue;
        for (const Way& way : kWays)
            for (const world::CatomChoice& choice : event.*way.event)
                unmatched.add(any(choice), [&choice, &way] {
                    return choice.id ? fmt::format("{}: there is no catom @{}, so nothing {}", choice.place, *choice.id, way.done)
                                     : fmt::format("{}: `{}` matches no catom, so nothing {}", choice.place, choice.where.text(), way.done);
                });
    }
    unmatched.warn();
}

void CatomFailures::look_at_faults() const {
    if (!still()) return;
    Unmatched unmatched(subdomain_.comm);
    for (const world::Faults& faults : subdomain_.world.faults)
        for (const Way& way : kWays)
            if (faults.*way.probability > 0)
                unmatched.add(any({.where = faults.where}), [&faults, &way] {
                    return fmt::format("{}: `{}` matches no catom, so nothing {}", faults.place, faults.where.text(), way.done);
                });
    unmatched.warn();
}

bool CatomFailures::still() const {
    const world::World& world = subdomain_.world;
    return world.motion.kind == "none" && world.components.empty() && !subdomain_.module.makes_nodes;
}

bool CatomFailures::any(const world::CatomChoice& choice) const {
    bool found = false;
    each(choice, [&](Catom) { found = true; });
    return found;
}

Struck CatomFailures::of_this_tick() const {
    Struck struck;
    const std::int64_t now = subdomain_.tick();
    const world::World& world = subdomain_.world;
    const auto fails = [&](const auto& one) { return one.strikes_catoms(); };
    // The same on all processes.
    if (!std::ranges::any_of(world.events, [&](const auto& event) { return fails(event) && event.happens_in(now); }) &&
        !std::ranges::any_of(world.faults, [&](const auto& faults) { return fails(faults) && faults.strikes_in(now); }))
        return struck;
    ByteWriter mine;
    for (const Way& way : kWays) {
        std::vector<Killed>& list = struck.*way.struck;
        const auto note = [&](Catom c) {
            list.push_back({subdomain_.ensemble.id(c), subdomain_.ensemble.is_free() ? Cell{} : subdomain_.ensemble.cell(c)});
        };
        for (const world::Event& event : world.events)
            if (event.happens_in(now))
                for (const world::CatomChoice& choice : event.*way.event) each(choice, note);
        each_struck(way.fault, way.probability, note);
        mine.write_count(list.size());
        for (const Killed& one : list) {
            mine.write(one.id);
            mine.write(one.cell);
        }
    }
    if (!subdomain_.alone()) {
        struck = {};
        for (const auto& theirs : subdomain_.comm.allgather_any(mine.view())) {
            ByteReader in(theirs, "catoms that fail");
            for (const Way& way : kWays)
                for (std::size_t left = in.read_count(sizeof(std::uint64_t)); left > 0; --left) {
                    const auto id = in.read<std::uint64_t>();
                    (struck.*way.struck).push_back({id, in.read<Cell>()});
                }
        }
    }
    for (const Way& way : kWays) {
        std::vector<Killed>& list = struck.*way.struck;
        std::ranges::sort(list, {}, &Killed::id);
        const auto twice = std::ranges::unique(list, {}, &Killed::id);
        list.erase(twice.begin(), twice.end());
    }
    // Of what is gone nothing hangs.
    for (std::vector<Killed>* list : {&struck.hung, &struck.restarted})
        std::erase_if(*list, [&](const Killed& one) { return std::ranges::binary_search(struck.killed, one.id, {}, &Killed::id); });
    return struck;
}

std::optional<Catom> CatomFailures::here(const Killed& one) const {
    // Another process may not know the cell.
    return subdomain_.ensemble.is_free() ? subdomain_.ensemble.find(one.id) : subdomain_.ensemble.at(one.cell);
}

void CatomFailures::count_lost(Catom catom) {
    if (!subdomain_.owned(catom)) return;
    const ModuleInfo& module = subdomain_.module;
    for (u32 p = 0; p < module.predicate_count; ++p) {
        const PredicateInfo& predicate = module.predicates[p];
        if (predicate.kind != PredicateKind::Linear || predicate.column == kNone16 || predicate.auxiliary) continue;
        subdomain_.status_.lost += tuple::count_facts(module, subdomain_.columns, subdomain_.geometry(), p, catom);
    }
}

// A node, and ghosts that nothing of this process has a link with any more.
void CatomFailures::take_node(std::uint64_t id) {
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

void CatomFailures::take_out(std::span<const Killed> killed) {
    subdomain_.note_change();
    subdomain_.refresh();
    for (const Killed& each : killed) {
        subdomain_.wake_up(each.id);
        const std::optional<Catom> catom = here(each);
        if (subdomain_.ensemble.is_free() && !subdomain_.ensemble.is_graph()) {
            MELD_CHECK(!catom, "catom @{} is still there", each.id);
            continue;
        }
        if (!catom) continue;
        count_lost(*catom);
        if (subdomain_.ensemble.is_graph())
            take_node(each.id);
        else
            subdomain_.remove_catom(*catom);
    }
    subdomain_.refresh();
}

std::size_t CatomFailures::let_die(Struck& struck) {
    std::vector<Dying>& dying = subdomain_.status_.dying;
    const auto dies = [&](std::uint64_t id) { return std::ranges::find(dying, id, &Dying::id) != dying.end(); };
    std::erase_if(struck.killed, [&](const Killed& one) { return dies(one.id); });
    hang(struck.killed);
    const std::int64_t gone = subdomain_.tick() + subdomain_.world.network.detect;
    for (const Killed& one : struck.killed) dying.insert(std::ranges::upper_bound(dying, gone, {}, &Dying::tick), {gone, one.id, one.cell});
    for (std::vector<Killed>* list : {&struck.hung, &struck.restarted})
        std::erase_if(*list, [&](const Killed& one) { return dies(one.id); });
    const std::size_t count = struck.killed.size();
    struck.killed.clear();
    const auto later = std::ranges::find_if(dying, [&](const Dying& one) { return one.tick > subdomain_.tick(); });
    for (auto one = dying.begin(); one != later; ++one) struck.killed.push_back({one->id, one->cell});
    dying.erase(dying.begin(), later);
    return count;
}

void CatomFailures::hang(std::span<const Killed> hung) {
    subdomain_.note_change();
    for (const Killed& each : hung) {
        subdomain_.fall_silent(each.id);
        const std::optional<Catom> catom = here(each);
        if (catom && subdomain_.owned(*catom)) subdomain_.facts_.evaluator.timers().forget(*catom);
    }
}

std::vector<Catom> CatomFailures::restart(std::span<const Killed> restarted) {
    std::vector<Catom> mine;
    subdomain_.note_change();
    subdomain_.refresh();
    for (const Killed& each : restarted) {
        subdomain_.wake_up(each.id);
        const std::optional<Catom> catom = here(each);
        if (!catom) continue;
        count_lost(*catom);
        subdomain_.restart(*catom);
        if (subdomain_.owned(*catom)) mine.push_back(*catom);
    }
    subdomain_.refresh();
    Programs programs(subdomain_);
    for (const Catom catom : mine) programs.begin(catom);
    return mine;
}

}  // namespace meld::sim
