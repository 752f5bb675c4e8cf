// Lines at edges: where what is seen changes to another catom, to one far behind it, or to another side of the same one.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "runtime/show/render/camera.h"
#include "runtime/show/render/geometry.h"

namespace meld::render {

class Lines {
  public:
    // For pixels with so many rays along each side. Lines are about `width` pixels wide. Both must outlive it.
    Lines(const Geometry& geometry, const Camera& camera, std::size_t side, float width);

    // Room that is used again.
    struct Room {
        std::vector<Geometry::Ray> rays;
        std::vector<std::optional<Geometry::Hit>> hits;
    };
    // How dark lines are at the rays through some pixels, from 0 to 1: pixel by pixel in rows of `width`, in a pixel also in rows.
    // Cost: a ray for each, and for those around them. Any thread may call it, with room of its own.
    void at(std::size_t left, std::size_t top, std::size_t width, std::size_t height, std::vector<float>& out, Room& room) const;

  private:
    // Steps to the other side of a line and back, in rays.
    struct Step {
        std::ptrdiff_t x, y;
    };
    const Geometry& geometry_;
    const Camera& camera_;
    std::size_t side_;
    std::vector<Step> steps_;
    std::size_t margin_;  // Pixels around that are looked at too.
    float near_;          // How much lines between catoms that touch are shown: not at all where catoms are too small for them.
};

}  // namespace meld::render
