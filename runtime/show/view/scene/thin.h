// Fewer catoms for a page that shows very many: those that others hide are left out, and if that is not enough, balls stand for several.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/show/picture/frame.h"

namespace meld::view {

// What a catom's neighbours take of its sky, in parts of 127: half the sum of the ways to them and a quarter of their number, so scaled
// that a catom between others on all sides has 127 in the last.
using Cover = std::array<std::int8_t, 4>;

// Of a catom whose neighbours are on the ways for which this says so.
template <class HasNext>
Cover cover_of(std::span<const render::Vec> ways, const HasNext& has_next);
// So many layers of catoms behind those with a free cell beside them are seen between these.
int layers_seen(render::Form form);

// Balls that stand for all catoms in a cube each.
class Balls {
  public:
    // At most `most`, for the catoms of a scene, which have these covers or none.
    Balls(const render::Scene& scene, std::span<const Cover> covers, std::size_t most);
    // The sides of cubes, in diameters.
    int coarse() const { return side_; }
    std::span<const Cover> covers() const { return covers_; }
    // Puts them in the place of these catoms, whose colours may have changed.
    void put(picture::Frame& frame) const;

  private:
    void collect(const render::Scene& scene, std::span<const Cover> covers);

    int side_ = 1;
    std::vector<std::uint32_t> ball_of_;  // By catom.
    // By ball: the first of its catoms, their number, and what is their mean.
    std::vector<std::size_t> first_;
    std::vector<std::uint32_t> counts_;
    std::vector<render::Vec> places_;
    std::vector<Cover> covers_;
};

struct Thinned {
    std::vector<Cover> covers = {};  // Of the catoms that are left; empty: nothing was left out.
    int coarse = 1;                  // Each ball that is left stands for what is in a cube with sides of so many diameters.
};

// Of a frame whose catoms have their colours and are more than `most`: leaves out those on a lattice that nobody can see, and if they are
// still more, puts one ball, in their mean colour and with the number of the first, in the place of several. Labels and values go with
// their catoms; balls have no values. Cost: some 30 ns a catom.
Thinned thin(picture::Frame& frame, std::size_t most);

template <class HasNext>
Cover cover_of(std::span<const render::Vec> ways, const HasNext& has_next) {
    render::Vec sum = render::Vec::Zero();
    float neighbours = 0;
    for (std::size_t way = 0; way < ways.size(); ++way)
        if (has_next(way)) {
            sum += ways[way];
            neighbours += 1;
        }
    const float scale = 127.0F * 4 / static_cast<float>(ways.size());
    const auto part = [&](float x) { return static_cast<std::int8_t>(std::lround(std::clamp(scale * x, -127.0F, 127.0F))); };
    return {part(0.5F * sum.x()), part(0.5F * sum.y()), part(0.5F * sum.z()), part(0.25F * neighbours)};
}

}  // namespace meld::view
