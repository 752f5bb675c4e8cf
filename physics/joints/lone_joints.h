// Hinges and balls that turn freely and are the only joint of their two bodies, which are turned alike about all axes: such a joint is a
// system of three equations, and four of them are solved at once. What they do is what an assembly does (assembly.h); an assembly solves
// each joint that is not as simple at the moment, for example because it has a motor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/joints/assembly.h"
#include "physics/joints/joint.h"

namespace meld::physics {

class LoneJoints {
  public:
    static constexpr std::size_t kAtOnce = 4;
    // Bit i: the i-th of a batch.
    using Chosen = std::uint32_t;

    LoneJoints();
    ~LoneJoints();
    LoneJoints(const LoneJoints&) = delete;
    LoneJoints& operator=(const LoneJoints&) = delete;

    void lay_out(std::span<const Assembly> assemblies);
    // Bodies have other slots.
    void locate(std::span<const Assembly> assemblies);
    void places_changed();
    std::size_t batches() const;
    // The places of the assemblies that have other joints, and of those in a batch.
    std::span<const std::uint32_t> others() const { return others_; }
    std::uint32_t assembly(std::size_t batch, std::size_t i) const;

    // Each returns those that an assembly has to do.
    Chosen warm_start(std::size_t batch, std::span<Joint> all, Bodies& bodies, const BodyShapes& shapes);
    Chosen run(std::size_t batch, Assembly::Phase phase, std::span<Joint> all, Bodies& bodies, const BodyShapes& shapes, double step_s);
    std::size_t bytes() const;

    struct Batch;
    struct Motion;

  private:
    void place(Batch& batch, Chosen chosen, std::span<Joint> all, const Bodies& bodies, const BodyShapes& shapes) const;
    // Those that turn freely now, and of these, those that do not sleep.
    static void choose(Batch& batch, std::span<const Joint> all);
    static Chosen awake(const Batch& batch, const Bodies& bodies);
    static Motion read(const Batch& batch, const Bodies& bodies);
    static void write(const Batch& batch, Chosen chosen, const Motion& motion, std::span<Joint> all, Bodies& bodies);

    std::vector<Batch> batches_;
    std::vector<std::uint32_t> others_;
};

}  // namespace meld::physics
