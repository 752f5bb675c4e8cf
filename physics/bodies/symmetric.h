// Symmetric 3x3 matrices: tensors of inertia and their inverses.
#pragma once

#include "physics/bodies/types.h"

namespace meld::physics {

struct Symmetric {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    bool operator==(const Symmetric&) const = default;
};

constexpr Vec3 operator*(const Symmetric& m, Vec3 v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z, m.xz * v.x + m.yz * v.y + m.zz * v.z};
}

constexpr void operator+=(Symmetric& sum, const Symmetric& m) {
    sum.xx += m.xx, sum.xy += m.xy, sum.xz += m.xz, sum.yy += m.yy, sum.yz += m.yz, sum.zz += m.zz;
}

// Of a body whose own inertia about its centre is the same about all axes, about the point at `arm` from the centre.
constexpr Symmetric inertia_about(double mass, double own, Vec3 arm) {
    const double square = dot(arm, arm);
    return {own + mass * (square - arm.x * arm.x), -mass * arm.x * arm.y, -mass * arm.x * arm.z,
            own + mass * (square - arm.y * arm.y), -mass * arm.y * arm.z, own + mass * (square - arm.z * arm.z)};
}

// The same of any body, whose own inertia is seen along the same axes.
constexpr Symmetric inertia_about(double mass, const Symmetric& own, Vec3 arm) {
    Symmetric sum = own;
    sum += inertia_about(mass, 0.0, arm);
    return sum;
}

// Of a matrix that is positive definite.
constexpr Symmetric inverse(const Symmetric& m) {
    const double a = m.yy * m.zz - m.yz * m.yz, b = m.xz * m.yz - m.xy * m.zz, c = m.xy * m.yz - m.xz * m.yy;
    const double scale = 1 / (m.xx * a + m.xy * b + m.xz * c);
    return {scale * a,
            scale * b,
            scale * c,
            scale * (m.xx * m.zz - m.xz * m.xz),
            scale * (m.xy * m.xz - m.xx * m.yz),
            scale * (m.xx * m.yy - m.xy * m.xy)};
}

// The same tensor as seen from the world, of a body that is turned by q.
constexpr Symmetric turned(const Symmetric& m, Quat q) {
    const Vec3 x = rotate(q, {1, 0, 0}), y = rotate(q, {0, 1, 0}), z = rotate(q, {0, 0, 1});
    // Columns of R m, then (R m) R^T.
    const auto column = [&](double a, double b, double c) { return a * x + (b * y + c * z); };
    const Vec3 p = column(m.xx, m.xy, m.xz), r = column(m.xy, m.yy, m.yz), s = column(m.xz, m.yz, m.zz);
    const auto entry = [&](double px, double rx, double sx, double a, double b, double c) { return px * a + (rx * b + sx * c); };
    return {entry(p.x, r.x, s.x, x.x, y.x, z.x), entry(p.x, r.x, s.x, x.y, y.y, z.y), entry(p.x, r.x, s.x, x.z, y.z, z.z),
            entry(p.y, r.y, s.y, x.y, y.y, z.y), entry(p.y, r.y, s.y, x.z, y.z, z.z), entry(p.z, r.z, s.z, x.z, y.z, z.z)};
}

constexpr Quat product(Quat a, Quat b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}

inline Quat unit(Quat q) {
    const double norm = 1 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {norm * q.w, norm * q.x, norm * q.y, norm * q.z};
}

// q turned on by a rotation vector (axis times angle), and made a unit quaternion again. Sines and cosines by their series: the same bits
// with every library. Angles are those of a substep, mostly well below one; larger ones are halved until they are small.
inline Quat turned_by(Quat q, Vec3 angle) {
    double half = 0.5, size = length(angle);
    int halvings = 0;
    for (; size > 0.5 && halvings < 60; ++halvings) size *= 0.5, half *= 0.5;
    const Vec3 v = half * angle;
    const double t = dot(v, v);
    const double sine = 1 + t * (-1.0 / 6 + t * (1.0 / 120 + t * (-1.0 / 5040 + t * (1.0 / 362880 - t / 39916800))));
    const double cosine = 1 + t * (-1.0 / 2 + t * (1.0 / 24 + t * (-1.0 / 720 + t * (1.0 / 40320 - t / 3628800))));
    Quat r{cosine, sine * v.x, sine * v.y, sine * v.z};
    for (; halvings > 0; --halvings) r = product(r, r);
    return unit(product(r, q));
}

}  // namespace meld::physics
