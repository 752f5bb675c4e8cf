#include "physics/collision/meeting.h"

#include <cmath>

#include "runtime/base/assert.h"

namespace meld::physics {

// |apart + t path| = radii, with the smaller root computed without cancellation.
std::optional<SurfaceContact> meet(Vec3 apart, double radii, Vec3 path) {
    MELD_EXPECT(radii > 0, "{} m", radii);
    const double towards = -dot(apart, path), beyond = dot(apart, apart) - radii * radii;
    if (!(towards > 0 && beyond > 0)) return std::nullopt;
    const double inside = towards * towards - dot(path, path) * beyond;
    if (inside < 0) return std::nullopt;
    const double share = beyond / (towards + std::sqrt(inside));
    if (share > 1) return std::nullopt;
    const Vec3 normal = (1 / radii) * (apart + share * path);
    return SurfaceContact{normal, -share * dot(normal, path)};
}

}  // namespace meld::physics
