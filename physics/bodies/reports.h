// What a step reports: touches, their forces, and what the step cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "physics/bodies/types.h"

namespace meld::physics {

// A body and what it touches: another body, or an obstacle.
struct Touch {
    Touch() = default;
    Touch(BodyId body_id, std::uint32_t other_number, bool is_obstacle)
        : body(body_id), other(other_number & (kMaxBodies - 1)), other_is_obstacle(is_obstacle) {}
    BodyId body = 0;
    // 31 bits, because in the first step of a pile there are three touches per body.
    std::uint32_t other : 31 = 0;
    bool other_is_obstacle : 1 = false;
    // Ordered by body, other, and whether it is an obstacle.
    constexpr std::uint64_t key() const { return std::uint64_t{body} << 32 | std::uint64_t{other} << 1 | std::uint64_t{other_is_obstacle}; }
    bool operator==(const Touch& that) const { return key() == that.key(); }
    auto operator<=>(const Touch& that) const { return key() <=> that.key(); }
};
struct TouchEvent {
    Touch touch;
    bool began;
    auto operator<=>(const TouchEvent&) const = default;
};

struct ContactReport {
    Touch touch;
    // From the body to the other.
    Vec3 normal;
    double gap_m;
    // The force on the other, averaged over the step; the body feels the opposite. Negative: a latch holds.
    double normal_force_n;
    Vec3 friction_n;
};

using ContactVisitor = std::function<void(const ContactReport&)>;

struct StepReport {
    std::uint64_t tick = 0;
    std::size_t bodies = 0;
    std::size_t awake_bodies = 0;
    std::size_t blocks = 0;
    std::size_t candidates = 0;
    bool rebuilt = false;
    // The members of some composite have changed.
    bool recomposed = false;
};

// Wall-clock seconds that a stage has taken since the scene was made.
struct StageTimes {
    double sort = 0, pairs = 0, actuation = 0, refresh = 0, solve = 0, move = 0, events = 0;
    double total() const { return sort + pairs + actuation + refresh + solve + move + events; }
};

}  // namespace meld::physics
