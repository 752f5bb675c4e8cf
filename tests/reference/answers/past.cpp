#include "tests/reference/answers/past.h"

#include <algorithm>
#include <string>

#include "tests/reference/trials/found.h"
#include "tests/reference/trials/run.h"

namespace meld::reference {

namespace {

bool is_link(const check::Predicate& p) { return p.world == check::WorldSource::Neighbor || p.world == check::WorldSource::NeighborPort; }

Rows links_of(const Scene& scene, const check::Predicate& p) {
    Rows out;
    for (const auto& [catom, links] : scene.links)
        for (const Link& link : links) {
            Row row{value_of(catom), value_of(link.other)};
            if (p.world == check::WorldSource::NeighborPort) row.push_back(value_of(std::int64_t{link.port}));
            out.insert(std::move(row));
        }
    return out;
}

Moment moment_of(const check::Program& program, sim::Subdomain& subdomain, const retraction::Mirror& mirror, const Trial& trial) {
    Found found = collect(subdomain, program), fronts = collect(subdomain, program, "@front");
    Moment out{.scene = make_scene(program, trial.world, mirror, subdomain.tick()),
               .given = given_facts(program, mirror),
               .facts = std::move(found.facts),
               .linear = std::move(found.linear),
               .fronts = std::move(fronts.facts)};
    for (const PredicateId id : program.predicates.ids()) {
        const check::Predicate& p = program.predicates[id];
        Rows& rows = out.facts[id.index()];
        if (p.world != check::WorldSource::None) rows = is_link(p) ? links_of(out.scene, p) : out.scene.world[id.index()];
        for (const Row& row : out.linear[id.index()]) rows.insert(row);
    }
    return out;
}

// Nodes that rules have made are not among the changes.
void note_born(const sim::Subdomain& subdomain, retraction::Mirror& mirror) {
    if (!subdomain.module.makes_nodes) return;
    for (const sim::Nodes::Made& node : subdomain.nodes().made()) {
        mirror.at[retraction::node(node.id)] = node.id;
        mirror.made[node.id] = node.place;
    }
}

}  // namespace

Past::Past(const Trial& trial, const check::Program& program, sim::Simulation& simulation, std::int64_t last)
    : program_(program), given_ever_(program.predicates.count()) {
    const sim::RunLimits limits{last};
    retraction::Mirror mirror(trial.world, trial.draft.given);
    const std::vector<retraction::Change>& changes = trial.world.bursts.at(0);
    std::size_t next = 0;
    moments_.push_back(moment_of(program, simulation.subdomain(), mirror, trial));
    while (!simulation.ended(limits) && simulation.step(limits)) {
        const std::int64_t tick = simulation.subdomain().tick();
        for (; next < changes.size() && changes[next].tick < tick; ++next) apply(changes[next], mirror);
        note_born(simulation.subdomain(), mirror);
        moments_.push_back(moment_of(program, simulation.subdomain(), mirror, trial));
    }
    quiet_ = simulation.ended(limits) == sim::Ending::Quiet;
    add_stable();
}

void Past::apply(const retraction::Change& change, retraction::Mirror& mirror) {
    const auto here = mirror.at.find(change.cell);
    const std::int64_t id = here == mirror.at.end() ? 0 : static_cast<std::int64_t>(here->second);
    if (!mirror.apply(change) || change.kind != retraction::Change::Kind::Give) return;
    const PredicateId p = predicate_of(program_, mirror.given[change.given]);
    retraction::Row raw{id};
    raw.insert(raw.end(), change.arguments.begin(), change.arguments.end());
    given_ever_[p.index()].insert(row_of(program_, p, raw));
}

bool Past::any(const Facts& facts, const Pattern& pattern) {
    const Rows& rows = facts[pattern.predicate.index()];
    const std::optional<Value>& catom = pattern.arguments[0];
    const auto [first, last] = catom ? at_catom(rows, catom->integer()) : std::pair(rows.begin(), rows.end());
    return std::any_of(first, last, [&](const Row& row) { return pattern.fits(row); });
}

// p@stable5, which the run need not store, has the facts of p that have been there in each tick since five before.
void Past::add_stable() {
    for (const PredicateId id : program_.predicates.ids()) {
        const std::string& name = program_.predicates[id].name;
        const std::size_t mark = name.find("@stable");
        if (mark == std::string::npos) continue;
        const check::Rule& rule = *std::ranges::find_if(program_.rules, [&](const check::Rule& r) {
            return r.heads.size() == 1 && r.heads[0].kind == check::Head::Kind::Fact && r.heads[0].atom.predicate == id;
        });
        const PredicateId of = rule.body.at(0).atom.predicate;
        const std::int64_t ticks = std::stoll(name.substr(mark + 7));
        for (std::int64_t tick = 0; tick <= last(); ++tick) {
            Rows& rows = moments_[static_cast<std::size_t>(tick)].facts[id.index()];
            rows = tick < ticks ? Rows{} : at(tick - ticks).facts[of.index()];
            std::erase_if(rows, [&](const Row& row) {
                for (std::int64_t t = tick - ticks + 1; t <= tick; ++t)
                    if (!holds(t, of, row)) return true;
                return false;
            });
        }
    }
}

}  // namespace meld::reference
