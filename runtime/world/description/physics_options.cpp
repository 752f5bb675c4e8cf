#include "runtime/world/description/physics_options.h"

#include <algorithm>

namespace meld::world {

BodyForm::Core BodyForm::core(double radius) const {
    constexpr double kRoundedShare = 0.02;
    if (kind == "sphere") return {{}, radius};
    if (kind == "capsule") return {{0, 0, std::max(length / 2 - radius, 0.0)}, radius};
    if (kind == "cylinder") {
        const double least = std::min(2 * radius, length), round = std::min(rounding.value_or(kRoundedShare * least), 0.49 * least);
        return {{radius - round, 0, length / 2 - round}, round};
    }
    const Vec3 whole = kind == "cube" ? Vec3{2 * radius, 2 * radius, 2 * radius} : edges;
    const double least = std::ranges::min(whole), round = std::min(rounding.value_or(kRoundedShare * least), 0.49 * least);
    return {{whole[0] / 2 - round, whole[1] / 2 - round, whole[2] / 2 - round}, round};
}

}  // namespace meld::world
