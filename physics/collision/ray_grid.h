// Bodies in a grid of cells, so that a ray looks only at those along its way. The caller numbers them.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "physics/collision/ray.h"

namespace meld::physics {

class RayGrid {
  public:
    using Index = std::uint32_t;
    static constexpr Index kNone = std::numeric_limits<Index>::max();
    struct Thing {
        Vec3 centre;
        BodyShape shape;
        Quat turn;
    };
    // The radii of the spheres around all bodies, for the size of the cells; wrong ones cost time alone.
    RayGrid(double least_radius_m, double greatest_radius_m);

    // Puts a body there, or elsewhere if the grid has it. Cost: constant on average.
    void set(Index index, const Thing& thing);
    void remove(Index index);
    const Thing& thing(Index index) const { return things_[index].thing; }
    // The first body on the way but for two. The same whatever else there is and in whatever order it came. Cost: some tens of nanoseconds
    // for each cell that the ray passes, and a few for each body there. Threads may ask at once.
    std::optional<double> first_on(const Ray& ray, Index but = kNone, Index and_but = kNone) const;
    // Whether there is one.
    bool blocks(const Ray& ray, Index but = kNone, Index and_but = kNone) const;

  private:
    using Cell = std::array<std::int64_t, 3>;
    struct HashOfCell {
        std::size_t operator()(const Cell& cell) const;
    };
    struct Cells {
        Cell low{}, high{};
        bool operator==(const Cells&) const = default;
    };
    struct Entry {
        Thing thing;
        Cells cells;
        bool here = false;
    };
    Cell cell_of(Vec3 at) const;
    Cells cells_of(const Thing& thing) const;
    template <class Visit>
    static void each_cell(const Cells& cells, const Visit& visit);
    // Calls meet(body) for those along the ray until done(share) holds behind the cells up to that share.
    template <class Meet, class Done>
    void walk(const Ray& ray, const Meet& meet, const Done& done) const;

    double side_;
    std::vector<Entry> things_;
    std::size_t count_ = 0;
    std::unordered_map<Cell, std::vector<Index>, HashOfCell> cells_;
    // Around all that has ever been here.
    Vec3 low_, high_;
};

}  // namespace meld::physics
