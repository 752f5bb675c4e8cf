// A scene as something that rays meet. The only use of Embree.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "runtime/base/error.h"
#include "runtime/render/scene.h"

namespace meld::render {

class Geometry {
  public:
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
        std::uint32_t thing;  // The number of the place, or behind them that of the stroke.
    };
    // What a ray meets first; `along` has length 1. Any thread may ask.
    std::optional<Hit> hit(const Vec& from, const Vec& along) const;
    // Whether there is something within a distance.
    bool meets(const Vec& from, const Vec& along, float within) const;

  private:
    struct Parts;
    explicit Geometry(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

}  // namespace meld::render
