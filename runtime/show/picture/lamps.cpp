#include "runtime/show/picture/lamps.h"

namespace meld::picture {

void add_lamps(const world::World& world, render::Scene& scene) {
    if (!world.is_free()) return;
    for (const world::LampOptions& lamp : world.physics.lamps) {
        if (!lamp.position || lamp.share == 0) continue;
        const auto& [x, y, z] = *lamp.position;
        scene.lamps.push_back({{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}});
    }
}

}  // namespace meld::picture
