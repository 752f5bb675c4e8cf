// Choosing the cells of a target: by breadth-first search from the body, in a shape that may first be scaled to fit.
#include "runtime/world/ensemble/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <utility>

#include "runtime/world/description/populate.h"
#include "runtime/world/ensemble/fit.h"

namespace meld::world {
namespace {

bool bit(const BrickCells& bits, std::uint32_t number) { return bits[number / 64] >> number % 64 & 1; }
void set_bit(BrickCells& bits, std::uint32_t number) { bits[number / 64] |= std::uint64_t{1} << number % 64; }

double distance_squared(const Vec3& p) { return p[0] * p[0] + p[1] * p[1] + p[2] * p[2]; }

// The cells of a shape in a brick except those left out, which are sorted.
BrickCells cells_without(const FittedShape& fitted, const Lattice& lattice, Cell brick) {
    BrickCells bits = cells_in_shape(fitted.shape, lattice, brick);
    const CellKey first = lattice.key(lattice.cell_in_brick(brick, 0));
    for (auto at = std::lower_bound(fitted.surplus.begin(), fitted.surplus.end(), first);
         at != fitted.surplus.end() && *at - first < kBrickCells; ++at) {
        const auto number = static_cast<std::uint32_t>(*at - first);
        bits[number / 64] &= ~(std::uint64_t{1} << number % 64);
    }
    return bits;
}

// The cell of both body and target that is nearest to the origin; of equals, the one with the least key.
std::optional<Cell> starting_cell(const World& world, const FittedShape& fitted, const Lattice& lattice) {
    std::optional<std::pair<double, CellKey>> best;
    for_each_brick(fitted.shape, lattice, [&](Cell brick) {
        BrickCells both = cells_of_body(world, lattice, brick);
        if (both == BrickCells{}) return true;
        const BrickCells target = cells_without(fitted, lattice, brick);
        for (std::uint32_t word = 0; word < both.size(); ++word) {
            for (std::uint64_t rest = both[word] & target[word]; rest != 0; rest &= rest - 1) {
                const Cell cell = lattice.cell_in_brick(brick, word * 64 + static_cast<std::uint32_t>(std::countr_zero(rest)));
                const std::pair here(distance_squared(lattice.position(cell)), lattice.key(cell));
                if (!best || here < *best) best = here;
            }
        }
        return true;
    });
    if (!best) return std::nullopt;
    return lattice.cell_at(best->second);
}

// Breadth-first search over the cells of the target, which examines the shape brick by brick as it reaches the bricks.
class Search {
  public:
    Search(const FittedShape& fitted, const Lattice& lattice) : fitted_(fitted), lattice_(lattice) {}

    // Chooses up to `wanted` cells and returns how many there were.
    std::uint64_t run(Cell start, std::uint64_t wanted) {
        std::vector<std::pair<CellKey, Cell>> frontier, next;
        see(start);
        frontier.emplace_back(lattice_.key(start), start);
        std::uint64_t chosen = 0;
        while (!frontier.empty()) {
            std::sort(frontier.begin(), frontier.end());
            for (const auto& [key, cell] : frontier) {
                if (chosen == wanted) return chosen;
                set_bit(chosen_[row(cell)], lattice_.number_in_brick(cell));
                ++chosen;
                for (int port = 0; port < lattice_.ports(); ++port) {
                    const Cell there = lattice_.neighbour(cell, port);
                    if (see(there)) next.emplace_back(lattice_.key(there), there);
                }
            }
            frontier.swap(next);
            next.clear();
        }
        return chosen;
    }

    BrickTable& rows() { return rows_; }
    std::vector<BrickCells>& chosen() { return chosen_; }

  private:
    // Whether the cell is in the shape and is seen for the first time.
    bool see(Cell cell) {
        if (!Lattice::in_range(cell) || !lattice_.brick_in_range(lattice_.brick_of(cell))) return false;
        const std::uint32_t number = lattice_.number_in_brick(cell);
        BrickCells& unseen = unseen_[row(cell)];
        if (!bit(unseen, number)) return false;
        unseen[number / 64] &= ~(std::uint64_t{1} << number % 64);
        return true;
    }

    std::uint32_t row(Cell cell) {
        const Cell brick = lattice_.brick_of(cell);
        const std::uint64_t key = packed(brick);
        if (const std::uint32_t known = rows_.find(key); known != 0) return known;
        const auto made = static_cast<std::uint32_t>(chosen_.size());
        rows_.insert(key, made);
        chosen_.push_back({});
        unseen_.push_back(cells_without(fitted_, lattice_, brick));
        return made;
    }

    const FittedShape& fitted_;
    const Lattice& lattice_;
    BrickTable rows_;
    std::vector<BrickCells> chosen_ = {BrickCells{}};
    std::vector<BrickCells> unseen_ = {BrickCells{}};
};

std::uint64_t count_cells(const Shape& shape, const Lattice& lattice) {
    World alone;
    alone.body = shape;
    return count_catoms(alone, lattice);
}

Error too_small(const World& world, const Shape& shape, const Lattice& lattice, std::uint64_t connected, std::uint64_t wanted) {
    const std::uint64_t all = count_cells(shape, lattice);
    const std::string part = all > connected ? fmt::format(", {} of them connected to the body,", connected) : "";
    const bool mass = world.target_is_mass || world.target_fits_mass;
    const std::string why = mass ? "the catoms and what they hold would fill" : "[target] cells asks for";
    return {fmt::format("the target {} has {} cells{} but {} {}", shape.text(), all, part, why, wanted),
            world.target_fits_mass ? "make the shape one piece with thicker walls" : "make the shape larger, or the body smaller"};
}

}  // namespace

Result<Target> Target::make(const World& world, const Lattice& lattice) {
    Target target(lattice);
    target.shape_ = world.target;
    const bool of_mass = world.target_is_mass || world.target_fits_mass;
    if (!world.target || (!world.target_cells && !of_mass)) return target;

    const std::uint64_t wanted =
        of_mass ? count_catoms(world, lattice) * (1 + static_cast<std::uint64_t>(world.held)) : *world.target_cells;
    FittedShape fitted{*world.target, 1, {}};
    if (world.target_fits_mass) {
        Result<FittedShape> fit = fit_shape(*world.target, lattice, wanted);
        if (!fit) return tl::unexpected(fit.error());
        fitted = std::move(*fit);
    }
    const std::optional<Cell> start = starting_cell(world, fitted, lattice);
    if (!start) {
        return fail(fmt::format("no catom stands in the target {}, so its cells cannot be counted from the body", fitted.shape.text()),
                    "move the target or the body so that they overlap");
    }
    Search search(fitted, lattice);
    const std::uint64_t chosen = search.run(*start, wanted);
    if (chosen < wanted) return tl::unexpected(too_small(world, fitted.shape, lattice, chosen, wanted));
    target.shape_ = fitted.shape;
    target.cells_ = chosen;
    target.rows_ = std::move(search.rows());
    target.chosen_ = std::move(search.chosen());
    return target;
}

bool Target::contains(Cell cell) const {
    if (!shape_) return false;
    if (!cells_) return shape_->contains(lattice_.position(cell));
    return bit(chosen_[rows_.find(packed(lattice_.brick_of(cell)))], lattice_.number_in_brick(cell));
}

void Target::fill(Cell brick, std::span<std::uint64_t, 8> bits) const {
    if (!shape_) return;
    const BrickCells cells = cells_ ? chosen_[rows_.find(packed(brick))] : cells_in_shape(*shape_, lattice_, brick);
    std::copy(cells.begin(), cells.end(), bits.begin());
}

}  // namespace meld::world
