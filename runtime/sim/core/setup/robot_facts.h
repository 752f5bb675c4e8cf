// What the robots of a world say about its catoms, as facts.
#pragma once

#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Gives facts to a program that declares them: part(A, B, Name) to each catom A of a robot for each part B of the same robot, A itself
// among them; and robot(A, Number). `only`: to no others. Cost: of part(), the parts of a robot for each catom.
void give_robot_facts(Subdomain& subdomain, const std::vector<Catom>* only = nullptr);

// Whether the robots of the world give facts of a predicate.
bool robots_give(const ModuleInfo& module, const world::World& world, u32 predicate);

}  // namespace meld::sim
