// What this extension adds: an interface and a name for each implementation, which worlds choose in [components].
#include "examples.h"

using meld::Result;
using meld::world::World;

CLAYMELD_EXTENSION(registry) {
    registry.add_sim("census", "plain", [](const World&) -> Result<std::unique_ptr<meld::sim::SimModule>> { return make_census(); });
    registry.add_code("odometer", "steps", [](const World&) -> Result<std::unique_ptr<meld::sim::CodeModule>> { return make_odometer(); });
    registry.add_code("pile", "tower", [](const World&) -> Result<std::unique_ptr<meld::sim::CodeModule>> { return make_pile(); });
    registry.add_component("tide", "spring", [](const World&) -> Result<std::unique_ptr<meld::sim::Component>> { return make_tide(); });
}
