#include "runtime/show/render/cells.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

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

std::optional<Cells> Cells::of(const Scene& scene, std::span<const Vec> ways) {
    const std::optional<Eigen::Matrix3f> basis = basis_of(ways);
    if (!basis || scene.places.empty()) return std::nullopt;
    const Eigen::Matrix3f to_cells = basis->inverse();
    const Vec origin = scene.places.front();
    const auto cell = [&](const Vec& place) { return Eigen::Array3f(to_cells * (place - origin)); };
    Eigen::Array3f low = Eigen::Array3f::Zero(), high = low;
    for (const Vec& place : scene.places) {
        const Eigen::Array3f at = cell(place);
        // One that is between two cells, or nowhere, makes this false.
        if (!((at - at.round()).abs() < kNear).all()) return std::nullopt;
        low = low.min(at);
        high = high.max(at);
    }
    // Each way leads one cell further at most, along each axis.
    const Eigen::Array3d size = (high - low).round().cast<double>() + 3;
    if (size.prod() > std::max(kBitsToACatom * static_cast<double>(scene.places.size()), kFewBits)) return std::nullopt;
    const auto width = static_cast<std::ptrdiff_t>(size.x()), slice = width * static_cast<std::ptrdiff_t>(size.y());
    const auto number = [&](const Eigen::Array3f& at) {
        return static_cast<std::ptrdiff_t>(at.x()) + width * static_cast<std::ptrdiff_t>(at.y()) +
               slice * static_cast<std::ptrdiff_t>(at.z());
    };
    Cells out;
    out.bits_.resize(static_cast<std::size_t>(size.prod()) / 64 + 1);
    out.at_.reserve(scene.places.size());
    for (const Vec& place : scene.places) {
        const std::ptrdiff_t at = number((cell(place) - low).round() + 1);
        out.at_.push_back(at);
        out.bits_[static_cast<std::size_t>(at) / 64] |= std::uint64_t{1} << (at % 64);
    }
    for (const Vec& way : ways) {
        const Eigen::Array3f step = Eigen::Array3f(to_cells * way).round();
        if (step.abs().maxCoeff() > 1) return std::nullopt;
        out.ways_.push_back(number(step));
    }
    return out;
}

Cells::Bits Cells::within(const Bits& bits) const {
    Bits out = bits;
    const auto words = static_cast<std::ptrdiff_t>(bits.size());
    for (const std::ptrdiff_t way : ways_) {
        // The bit of the neighbour comes to the place of the catom.
        const std::ptrdiff_t shift = way >= 0 ? way / 64 : -((-way + 63) / 64), rest = way - 64 * shift;
        const auto word = [&](std::ptrdiff_t i) { return i >= 0 && i < words ? bits[static_cast<std::size_t>(i)] : 0; };
        for (std::ptrdiff_t i = 0; i < words; ++i) {
            std::uint64_t& here = out[static_cast<std::size_t>(i)];
            if (here == 0) continue;
            const std::uint64_t next = rest == 0 ? 0 : word(i + shift + 1) << (64 - rest);
            here &= word(i + shift) >> rest | next;
        }
    }
    return out;
}

std::vector<std::uint8_t> Cells::depths(int most) const {
    std::vector<std::uint8_t> out(at_.size());
    Bits left = bits_;
    for (int depth = 1; depth <= most; ++depth) {
        left = within(left);
        for (std::size_t i = 0; i < at_.size(); ++i)
            if (bit(left, at_[i])) out[i] = static_cast<std::uint8_t>(depth);
    }
    return out;
}

}  // namespace meld::render
