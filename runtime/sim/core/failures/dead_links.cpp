#include "runtime/sim/core/failures/dead_links.h"

#include <fmt/format.h>

#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::sim {

void DeadLinks::look_at_text() {
    const ModuleInfo& module = subdomain_.module;
    for (u32 i = 0; i < module.link_count; ++i) {
        const LinkInfo& link = module.links[i];
        // warn_of_missing_catoms() reports catoms that do not exist.
        const std::optional<Catom> from = subdomain_.ensemble.find(link.from);
        if (!from || !subdomain_.owned(*from) || !dead(*from, link.to)) continue;
        found({0, i}, *from, link.to, link.predicate, fmt::format("{}:{}", link.file, link.line));
    }
}

void DeadLinks::look_at_given(std::size_t fact, Catom from, u32 predicate, u64 to) {
    if (dead(from, to)) found({1 + fact, subdomain_.ensemble.id(from)}, from, to, predicate, subdomain_.world.facts[fact].place);
}

// A catom may point to itself, for example at the root of a tree. In a program that makes nodes, facts along its own routes need no links.
bool DeadLinks::dead(Catom from, u64 to) const {
    if (subdomain_.module.makes_nodes) return false;
    const world::Ensemble& ensemble = subdomain_.ensemble;
    if (ensemble.id(from) == to) return false;
    const std::optional<Catom> other = ensemble.find(to);
    if (!other) return true;
    const Geometry& g = subdomain_.geometry();
    bool touches = false;
    each_link(g, from, [&](i32, u32 neighbour) { touches = touches || neighbour == *other; });
    return !touches;
}

void DeadLinks::found(Order order, Catom from, u64 to, u32 predicate, const std::string& place) {
    ++count_;
    if (first_ && first_->order < order) return;
    const PredicateInfo& p = subdomain_.module.predicates[predicate];
    const u64 id = subdomain_.ensemble.id(from);
    const std::string why = to < subdomain_.next_id() ? fmt::format("@{} and @{} do not touch", id, to)
                                                      : fmt::format("the world has only @0 to @{}", subdomain_.next_id() - 1);
    first_ = {order, fmt::format("{}{}(@{}, @{}{}) is a route that leads nowhere, since {}", place.empty() ? "" : place + ": ", p.name, id,
                                 to, p.arity > 1 ? ", ..." : "", why)};
}

void DeadLinks::look_at_all() {
    for (u32 i = 0; i < subdomain_.module.predicate_count; ++i) {
        const PredicateInfo& p = subdomain_.module.predicates[i];
        if (!p.route || p.auxiliary || p.column == kNone16 || p.kind == PredicateKind::Linear) continue;
        for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c) {
            if (!subdomain_.owned(c)) continue;
            tuple::each_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), i, c, [&](const Value* values) {
                const u64 to = values[0].catom;
                if (dead(c, to)) found({i, subdomain_.ensemble.id(c)}, c, to, i, "");
            });
        }
    }
}

std::string describe(const DeadRoutes& routes) {
    return routes.first + (routes.count > 1 ? fmt::format(" (and {} more)", routes.count - 1) : "");
}

Result<void> DeadLinks::verdict() const {
    const DeadRoutes all = of_all_processes();
    if (all.count == 0) return {};
    return fail(describe(all),
                "Nothing would be read or sent along it: link catoms that touch, choose a lattice or a [[body]] in which these do, list "
                "the links of a world that is a graph, or declare the predicate without `route`");
}

DeadRoutes DeadLinks::of_all_processes() const {
    ByteWriter mine;
    mine.write(count_);
    mine.write(first_ ? first_->order.first : ~u64{0});
    mine.write(first_ ? first_->order.second : ~u64{0});
    mine.write_string(first_ ? first_->text : "");
    u64 count = 0;
    Order least{~u64{0}, ~u64{0}};
    std::string text;
    for (const auto& bytes : subdomain_.comm.allgather_any(mine.view())) {
        ByteReader in(bytes, "routes that lead nowhere");
        count += in.read<u64>();
        const auto major = in.read<u64>(), minor = in.read<u64>();
        std::string theirs = in.read_string();
        if (Order{major, minor} >= least) continue;
        least = {major, minor};
        text = std::move(theirs);
    }
    return {count, text};
}

}  // namespace meld::sim
