// Finding the scale of a shape by bisection over the number of its cells.
#include "runtime/world/ensemble/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/shapes/shape_tree.h"

namespace meld::world {
namespace {

// Two scales nearer than this, as a share of the scale, count as one: cells that mirror each other join the shape at scales that differ
// only by rounding.
constexpr double kSameScale = 1e-12;
// The first step away from the estimated scale, as a factor; every further step squares it.
constexpr double kFirstStep = 1.02;

struct Size {
    double scale;
    std::uint64_t cells;
};

class Fitter {
  public:
    Fitter(const Shape& shape, const Lattice& lattice, std::uint64_t wanted) : shape_(shape), lattice_(lattice), wanted_(wanted) {}

    Result<FittedShape> fit() {
        const std::uint64_t unscaled = cells_at(1);
        if (unscaled == wanted_) return FittedShape{shape_, 1, {}};
        std::optional<std::pair<Size, Size>> around = bracket({estimate(unscaled), 0});
        if (!around) {
            return fail(fmt::format("the target {} cannot be scaled to hold {} cells", shape_.text(), wanted_),
                        "choose a shape around the origin that grows in all directions of the lattice");
        }
        auto [smaller, larger] = *around;
        while (larger.cells != wanted_ && larger.scale - smaller.scale > kSameScale * larger.scale) {
            const double middle = smaller.scale + (larger.scale - smaller.scale) / 2;
            const Size here{middle, cells_at(middle)};
            (here.cells < wanted_ ? smaller : larger) = here;
        }
        return FittedShape{scaled(larger.scale), larger.scale, surplus(smaller, larger)};
    }

  private:
    Shape scaled(double scale) const { return make_shape(Scaled{shape_, scale}, fmt::format("scale({}, {:.4g})", shape_.text(), scale)); }

    std::uint64_t cells_at(double scale) const {
        World alone;
        alone.body = scaled(scale);
        return count_catoms(alone, lattice_);
    }

    bool within_lattice(double scale) const {
        const Box box = scaled(scale).bounds();
        Cell first, last;
        lattice_.cells_covering(box.low, box.high, first, last);
        const auto inside = [](std::int32_t value) { return value > -kCellLimit && value < kCellLimit - 1; };
        const auto all_inside = [inside](Cell cell) { return inside(cell.x) && inside(cell.y) && inside(cell.z); };
        return box.empty() || (all_inside(first) && all_inside(last));
    }

    double estimate(std::uint64_t unscaled) const {
        return unscaled == 0 ? 1 : std::cbrt(static_cast<double>(wanted_) / static_cast<double>(unscaled));
    }

    // A scale with fewer cells than wanted, and a larger one with enough; nothing if no shape within the lattice has enough.
    std::optional<std::pair<Size, Size>> bracket(Size start) const {
        start.cells = cells_at(start.scale);
        Size smaller = start, larger = start;
        for (double step = kFirstStep; smaller.cells >= wanted_; step *= step) {
            larger = smaller;
            smaller.scale /= step;
            smaller.cells = cells_at(smaller.scale);
        }
        for (double step = kFirstStep; larger.cells < wanted_; step = std::min(step * step, 2.0)) {
            smaller = larger;
            larger.scale *= step;
            if (!within_lattice(larger.scale)) return std::nullopt;
            larger.cells = cells_at(larger.scale);
        }
        return std::pair(smaller, larger);
    }

    // The cells to leave out. Of the cells that only the larger shape has, those farthest in links from the smaller shape are left out
    // first, so that the rest stays connected; of those equally far, every n-th.
    std::vector<CellKey> surplus(const Size& smaller, const Size& larger) const {
        std::uint64_t count = larger.cells - wanted_;
        if (count == 0) return {};
        const Shape inner = scaled(smaller.scale), outer = scaled(larger.scale);
        const std::vector<std::vector<CellKey>> layers = layers_around(inner, outer, cells_gained(inner, outer));
        std::vector<CellKey> left_out;
        for (auto layer = layers.rbegin(); layer != layers.rend() && count > 0; ++layer) {
            const std::uint64_t here = std::min<std::uint64_t>(count, layer->size());
            for (std::uint64_t i = 0; i < here; ++i) left_out.push_back((*layer)[(2 * i + 1) * layer->size() / (2 * here)]);
            count -= here;
        }
        MELD_CHECK(count == 0, "{} cells of the surplus are left", count);
        std::sort(left_out.begin(), left_out.end());
        return left_out;
    }

    std::vector<CellKey> cells_gained(const Shape& inner, const Shape& outer) const {
        std::vector<CellKey> gained;
        for_each_brick(outer, lattice_, [&](Cell brick) {
            const BrickCells with = cells_in_shape(outer, lattice_, brick), without = cells_in_shape(inner, lattice_, brick);
            for (std::uint32_t word = 0; word < with.size(); ++word) {
                for (std::uint64_t rest = with[word] & ~without[word]; rest != 0; rest &= rest - 1) {
                    const auto number = word * 64 + static_cast<std::uint32_t>(std::countr_zero(rest));
                    gained.push_back(lattice_.key(lattice_.cell_in_brick(brick, number)));
                }
            }
            return true;
        });
        std::sort(gained.begin(), gained.end());
        return gained;
    }

    // The gained cells by their distance in links from the cells of both shapes, each layer ascending; cells without such a path are the
    // last layer.
    std::vector<std::vector<CellKey>> layers_around(const Shape& inner, const Shape& outer, const std::vector<CellKey>& gained) const {
        const auto in_both = [&](Cell cell) {
            const Vec3 at = lattice_.position(cell);
            return inner.contains(at) && outer.contains(at);
        };
        std::vector<std::vector<CellKey>> layers;
        std::vector<CellKey> rest = gained;
        const auto beside_last = [&](Cell cell) {
            for (int port = 0; port < lattice_.ports(); ++port) {
                const Cell there = lattice_.neighbour(cell, port);
                if (layers.empty() ? in_both(there) : std::binary_search(layers.back().begin(), layers.back().end(), lattice_.key(there)))
                    return true;
            }
            return false;
        };
        while (!rest.empty()) {
            const auto far =
                std::stable_partition(rest.begin(), rest.end(), [&](CellKey key) { return beside_last(lattice_.cell_at(key)); });
            if (far == rest.begin()) break;
            std::vector<CellKey> layer(rest.begin(), far);
            rest.erase(rest.begin(), far);
            layers.push_back(std::move(layer));
        }
        layers.push_back(std::move(rest));
        return layers;
    }

    const Shape& shape_;
    const Lattice& lattice_;
    std::uint64_t wanted_;
};

}  // namespace

Result<FittedShape> fit_shape(const Shape& shape, const Lattice& lattice, std::uint64_t wanted) {
    MELD_EXPECT(wanted > 0, "no cells are wanted");
    return Fitter(shape, lattice, wanted).fit();
}

}  // namespace meld::world
