// What should hold: rules as C++ functions over all facts at once, applied from nothing until nothing changes, stratum by
// stratum. Slow and obvious; it shares nothing with the compiler or the runtime.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "case.h"

namespace meld::retraction {

struct Scene {
    const Mirror& mirror;
    std::map<std::int64_t, std::vector<std::int64_t>> neighbours;  // By id.
};
Scene make_scene(const Mirror& mirror, world::LatticeKind lattice);

using Derive = std::function<void(const std::string& predicate, const Row& row)>;
using Rules = std::function<void(const Scene&, const Facts&, const Derive&)>;

struct Program {
    std::string name;  // Of the .meld file.
    std::vector<Given> given;
    std::map<std::string, std::string> aggregates;  // Of a predicate's last argument: "min", "max", "sum", "count".
    std::vector<Rules> strata;
    // Whether its groups remember losses, and whether some must wait in quarantine: only where facts can vouch for themselves.
    bool loses = true;
    bool waits = true;
    // Predicates whose rows carry one more argument, a neighbour that has this value less one.
    std::string parent_of = {};
};
const std::vector<Program>& programs();
inline void PrintTo(const Program& program, std::ostream* out) { *out << program.name; }

Facts from_scratch(const Program& program, const Scene& scene);

}  // namespace meld::retraction
