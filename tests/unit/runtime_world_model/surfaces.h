// Triangles of bodies whose volume is known, and files of them.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "runtime/world/model/triangles.h"

namespace meld::model {

// Each face of the box of two triangles.
inline Triangles box_surface(const Vec3& low, const Vec3& high) {
    Triangles out;
    for (unsigned corner = 0; corner < 8; ++corner)
        out.points.push_back({corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2]});
    out.corners = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    return out;
}

// A tube of radius `small` around a circle of radius `large` in the plane z = 0, as `rings` times `sides` quadrangles; closed.
inline Triangles torus_surface(double large, double small, std::uint32_t rings, std::uint32_t sides) {
    Triangles out;
    for (std::uint32_t i = 0; i < rings; ++i) {
        for (std::uint32_t k = 0; k < sides; ++k) {
            const double a = 2 * std::numbers::pi * i / rings, b = 2 * std::numbers::pi * k / sides;
            const double from_axis = large + small * std::cos(b);
            out.points.push_back({from_axis * std::cos(a), from_axis * std::sin(a), small * std::sin(b)});
            const std::uint32_t i1 = (i + 1) % rings, k1 = (k + 1) % sides;
            const std::uint32_t p = i * sides + k, q = i1 * sides + k, r = i1 * sides + k1, s = i * sides + k1;
            out.corners.push_back({p, q, r});
            out.corners.push_back({p, r, s});
        }
    }
    return out;
}

// A sphere of `rings` rows of `rings` * 2 quadrangles between two fans at the poles; closed.
inline Triangles sphere_surface(double radius, std::uint32_t rings) {
    Triangles out;
    const std::uint32_t around = 2 * rings;
    out.points = {{0, 0, -radius}, {0, 0, radius}};
    for (std::uint32_t i = 1; i < rings; ++i) {
        for (std::uint32_t k = 0; k < around; ++k) {
            const double height = std::numbers::pi * (static_cast<double>(i) / rings - 0.5), turn = std::numbers::pi * k / rings;
            out.points.push_back(
                {radius * std::cos(height) * std::cos(turn), radius * std::cos(height) * std::sin(turn), radius * std::sin(height)});
        }
    }
    const auto at = [&](std::uint32_t ring, std::uint32_t k) { return 2 + (ring - 1) * around + k % around; };
    for (std::uint32_t k = 0; k < around; ++k) {
        out.corners.push_back({0, at(1, k + 1), at(1, k)});
        out.corners.push_back({1, at(rings - 1, k), at(rings - 1, k + 1)});
        for (std::uint32_t i = 1; i + 1 < rings; ++i) {
            out.corners.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
            out.corners.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
        }
    }
    return out;
}

// The volume inside a closed surface.
inline double volume_of(const Triangles& all) {
    double sum = 0;
    for (const auto& [i, j, k] : all.corners) {
        const Vec3 &a = all.points[i], &b = all.points[j], &c = all.points[k];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

inline std::string obj_of(const Triangles& all) {
    std::string out;
    for (const Vec3& p : all.points) out += fmt::format("v {} {} {}\n", p[0], p[1], p[2]);
    for (const auto& c : all.corners) out += fmt::format("f {} {} {}\n", c[0] + 1, c[1] + 1, c[2] + 1);
    return out;
}

inline std::string binary_stl_of(const Triangles& all) {
    std::string out(80, ' ');
    const auto append = [&out](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
    append(static_cast<std::uint32_t>(all.corners.size()));
    for (const auto& corners : all.corners) {
        for (int i = 0; i < 3; ++i) append(0.0F);
        for (const std::uint32_t corner : corners)
            for (const double x : all.points[corner]) append(static_cast<float>(x));
        append(std::uint16_t{0});
    }
    return out;
}

inline std::string ply_of(const Triangles& all) {
    std::string out = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list "
        "uchar int "
        "vertex_indices\nend_header\n",
        all.points.size(), all.corners.size());
    for (const Vec3& p : all.points) out += fmt::format("{} {} {}\n", p[0], p[1], p[2]);
    for (const auto& c : all.corners) out += fmt::format("3 {} {} {}\n", c[0], c[1], c[2]);
    return out;
}

inline std::string ascii_stl_of(const Triangles& all) {
    std::string out = "solid part\n";
    for (const auto& corners : all.corners) {
        out += "facet normal 0 0 0\nouter loop\n";
        for (const std::uint32_t corner : corners) {
            const Vec3& p = all.points[corner];
            out += fmt::format("vertex {} {} {}\n", p[0], p[1], p[2]);
        }
        out += "endloop\nendfacet\n";
    }
    return out + "endsolid part\n";
}

}  // namespace meld::model
