// A scene as something that rays meet. The only use of Embree.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/show/render/scene.h"

namespace meld::render {

class Geometry {
  public:
    struct Ray {
        Vec from, along;  // Of length 1.
    };

    // The scene must outlive it, and must not change. Errors: there is not enough memory (4).
    // Cost: about a microsecond and 100 bytes a catom; faces between two cubes that touch are left out.
    static Result<Geometry> build(const Scene& scene, int threads);
    Geometry(Geometry&& other) noexcept;
    Geometry& operator=(Geometry&&) = delete;
    ~Geometry();

    struct Hit {
        float distance;
        Vec normal;  // Towards where the ray came from; of length 1.
        Rgb colour;
        std::uint32_t thing;  // The number of the place, behind them that of the stroke, then one for all obstacles and one for all lamps.
        bool shines = false;
    };
    // What each ray meets first. Any thread may ask. Cost: some 0.1 us a ray; less if rays beside each other in the list are close together
    // and go the same way, as up to 16 go together.
    void hits(std::span<const Ray> rays, std::vector<std::optional<Hit>>& out) const;
    // Whether each meets anything within a distance.
    void meets(std::span<const Ray> rays, float within, std::vector<std::uint8_t>& out) const;

  private:
    struct Parts;
    Hit seen_by(const Ray& ray, float distance, Vec normal, std::uint32_t geometry, std::uint32_t primitive) const;
    explicit Geometry(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

}  // namespace meld::render
