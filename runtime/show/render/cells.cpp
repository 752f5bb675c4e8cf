#include "runtime/show/render/cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace meld::render {

namespace {

constexpr float kNear = 1e-2F;         // Of a whole number, in catom diameters.
constexpr double kBitsToACatom = 256;  // At most, beside a small number of them.
constexpr double kFewBits = 1 << 20;

// Three ways of which every other one, and every place on the lattice, is a sum: those that span the smallest cell.
std::optional<Eigen::Matrix3f> basis_of(std::span<const Vec> ways) {
    std::optional<Eigen::Matrix3f> best;
    for (std::size_t i = 0; i < ways.size(); ++i)
        for (std::size_t j = i + 1; j < ways.size(); ++j)
            for (std::size_t k = j + 1; k < ways.size(); ++k) {
                Eigen::Matrix3f three;
                three << ways[i], ways[j], ways[k];
                const float size = std::abs(three.determinant());
                if (size > 0.1F && (!best || size < std::abs(best->determinant()) - 1e-3F)) best = three;
            }
    return best;
}

}  // namespace

std::optional<Cells::Box> Cells::box_of(std::span<const Vec> places, std::span<const Vec> ways, std::size_t catoms) {
    const std::optional<Eigen::Matrix3f> basis = basis_of(ways);
    if (!basis || places.empty()) return std::nullopt;
    Box box{.to_cells = basis->inverse()};
    for (const Vec& place : places) {
        const Eigen::Array3f at = box.cell(place - places.front());
        // One that is between two cells, or nowhere, makes this false.
        if (!((at - at.round()).abs() < kNear).all()) return std::nullopt;
        box.low = box.low.min(at);
        box.high = box.high.max(at);
    }
    // Each way leads one cell further at most, along each axis.
    for (const Vec& way : ways)
        if (box.cell(way).round().abs().maxCoeff() > 1) return std::nullopt;
    if (box.size().prod() > std::max(kBitsToACatom * static_cast<double>(catoms), kFewBits)) return std::nullopt;
    return box;
}

std::optional<Cells> Cells::of(const Scene& scene, std::span<const Vec> ways) {
    const std::optional<Box> box = box_of(scene.places, ways, scene.places.size());
    if (!box) return std::nullopt;
    const Eigen::Array3d size = box->size();
    const auto width = static_cast<std::ptrdiff_t>(size.x()), slice = width * static_cast<std::ptrdiff_t>(size.y());
    const auto number = [&](const Eigen::Array3f& at) {
        return static_cast<std::ptrdiff_t>(at.x()) + width * static_cast<std::ptrdiff_t>(at.y()) +
               slice * static_cast<std::ptrdiff_t>(at.z());
    };
    std::vector<std::ptrdiff_t> strides;
    for (const Vec& way : ways) strides.push_back(number(box->cell(way).round()));
    Cells out;
    out.bits_ = CellBits(static_cast<std::size_t>(size.prod()), std::move(strides));
    out.at_.reserve(scene.places.size());
    for (const Vec& place : scene.places) {
        out.at_.push_back(number((box->cell(place - scene.places.front()) - box->low).round() + 1));
        out.bits_.set(out.at_.back());
    }
    return out;
}

std::vector<std::uint8_t> Cells::depths(int most) const {
    std::vector<std::uint8_t> out(at_.size());
    CellBits left = bits_;
    for (int depth = 1; depth <= most; ++depth) {
        left = left.within();
        for (std::size_t i = 0; i < at_.size(); ++i)
            if (left.has(at_[i])) out[i] = static_cast<std::uint8_t>(depth);
    }
    return out;
}

}  // namespace meld::render
