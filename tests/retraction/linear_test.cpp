// Losses and linear rules in one tick.
#include <gtest/gtest.h>

#include "compiled.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/core/tick.h"
#include "runtime/world/ensemble/target.h"

namespace meld::retraction {
namespace {

bool holds(const sim::Subdomain& subdomain, const char* predicate, sim::Catom catom) {
    bool any = false;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *tuple::find_predicate(subdomain.module, predicate, 0),
                     catom, [&](const Value*) { any = true; });
    return any;
}

// In a ring of four the catoms around a lost source still vouch for it for a while; a linear rule that fires in the tick of
// the loss, and has the rules for `reach` looked at once more, must not make it believe them.
TEST(LinearRules, DoNotEndAQuarantine) {
    const Result<Module> module = compiled("linear");
    ASSERT_TRUE(module) << module.error().message();
    world::World world;
    world.lattice = world::LatticeKind::Square;
    world.cells = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    world::sort_cells(world.cells, world::Lattice(world.lattice));
    const Result<world::Target> target = world::Target::make(world, world::Lattice(world.lattice));
    ASSERT_TRUE(target) << target.error().message();
    const auto comm = comm::make_single();
    sim::Subdomain subdomain(info_of(*module), world, *target, *comm, 1);
    ASSERT_TRUE(subdomain.populate());
    const auto base = [&](const char* name) { return subdomain.module.predicates[*tuple::find_predicate(subdomain.module, name, 0)].base; };
    sim::Tick ticks(subdomain);
    const auto tick = [&] {
        ticks.begin();
        ticks.end();
    };
    subdomain.give(base("source"), 0, nullptr);
    for (int i = 0; i < 5; ++i) tick();
    ASSERT_TRUE(holds(subdomain, "reach", 0) && holds(subdomain, "reach", 3));
    subdomain.take(base("source"), 0, nullptr);
    subdomain.give(base("token"), 0, nullptr);
    tick();
    EXPECT_TRUE(holds(subdomain, "mark", 0));
    EXPECT_FALSE(holds(subdomain, "reach", 0));
}

}  // namespace
}  // namespace meld::retraction
