// The joints of a scene, by assemblies in the order of their lowest bodies. Each assembly is solved by one worker, and no two share a body
// that can be moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/joints/assembly.h"
#include "physics/joints/joint.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

class Joints {
  public:
    bool empty() const { return joints_.empty(); }
    std::span<const Joint> all() const { return joints_; }
    const Joint* find(BodyId one, BodyId other) const;
    // Of two bodies that have none yet; and all joints of a body.
    void add(const Joint& joint);
    void remove_all(BodyId body);
    void drive(BodyId one, BodyId other, const JointDrive& drive);

    // Bodies have other slots, or joints have changed. Errors: an assembly has too many loops.
    Result<void> settle(const Bodies& bodies);
    std::span<const Assembly> assemblies() const { return assemblies_; }
    // Places have changed, or which bodies can be moved.
    void places_changed();
    void forget_impulses();

    void warm_start(Bodies& bodies, const BodyShapes& shapes, Workers& workers);
    void run(Assembly::Phase phase, Bodies& bodies, const BodyShapes& shapes, double step_s, Workers& workers);

    void write(ByteWriter& out) const;
    // False if what was written is no joint; and if there is no body of one, when all are there.
    bool read(ByteReader& in);
    bool fits(const Bodies& bodies) const;
    std::size_t bytes() const;

  private:
    std::vector<Joint>::iterator place_of_pair(BodyId one, BodyId other);
    bool lay_out(const Bodies& bodies);

    // Sorted by their bodies, the lower first.
    std::vector<Joint> joints_;
    std::vector<Assembly> assemblies_;
    bool changed_ = false;
};

}  // namespace meld::physics
