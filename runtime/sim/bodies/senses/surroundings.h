// The bodies around those of this process, for line of sight, range finders and light: by where they are after the steps of a tick.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>

#include "physics/collision/sight.h"
#include "physics/scene/scene.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class BodySurroundings {
  public:
    // The radii of the spheres around all bodies of all processes.
    BodySurroundings(double least_radius_m, double greatest_radius_m)
        : least_radius_m_(least_radius_m), greatest_radius_m_(greatest_radius_m) {}
    // On every process: finds the bodies that are not farther than this from the centre of one of ours, and perhaps some more. Cost: a look
    // at each of our bodies; other processes are sent those near the box around theirs.
    // Also those that are between one of ours and one of the `lamps`, if it is within the reach of that.
    struct FarPlace {
        physics::Vec3 place_m;
        double reach_m = 0;
    };
    void gather(Subdomain& subdomain, const physics::Scene& scene, double reach_m, std::span<const FarPlace> lamps);
    // Whether nothing is between the centres of two bodies that have been gathered. The same for both ends, on any process.
    bool sees(const physics::Scene& scene, std::uint64_t one, std::uint64_t other) const;
    // What a ray of a body, that is not longer than `reach_m`, first meets, but for the body itself: an obstacle or another one.
    std::optional<double> first_on(const physics::Scene& scene, std::uint64_t own, const physics::Ray& ray) const;
    // Whether neither an obstacle nor a body that has been gathered is on a ray, but for these two; the second may be unknown here.
    bool is_free(const physics::Scene& scene, std::uint64_t own, std::optional<std::uint64_t> other, const physics::Ray& ray) const;
    const physics::RayGrid::Thing& body(std::uint64_t id) const { return bodies_->thing(index_.at(id)); }

  private:
    void add(std::uint64_t id, const physics::RayGrid::Thing& thing);
    double least_radius_m_, greatest_radius_m_;
    std::optional<physics::RayGrid> bodies_;
    std::unordered_map<std::uint64_t, physics::RayGrid::Index> index_;
};

}  // namespace meld::sim
