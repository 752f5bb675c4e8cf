// Hinges and balls that turn freely and are the only joint of their two bodies, which are turned alike about all axes: such a joint is a
// system of three equations, and four of them are solved at once. What they do is what an assembly does (assembly.h); an assembly solves
// each joint that is not as simple at the moment, for example because it has a motor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

    void lay_out(std::span<const Assembly> assemblies, std::span<const Joint> all, const Bodies& bodies, const BodyShapes& shapes);
    // Bodies have other slots.
    void locate(std::span<const Assembly> assemblies, const Bodies& bodies, const BodyShapes& shapes);
    void places_changed();
    // Joints may have other drives.
    void drives_changed();
    std::size_t batches() const;
    // The places of the assemblies that have other joints, and of those in a batch.
    std::span<const std::uint32_t> others() const { return others_; }
    std::uint32_t assembly(std::size_t batch, std::size_t i) const;

    // Each returns those that an assembly has to do.
    Chosen warm_start(std::size_t batch, std::span<Joint> all, Bodies& bodies);
    Chosen run(std::size_t batch, Assembly::Phase phase, std::span<Joint> all, Bodies& bodies, double step_s);

    // Within a step, a batch keeps what its joints carry. At the end of one of this length they get it back, and know where they are;
    // those that are overloaded break.
    Chosen end_step(std::size_t batch, std::span<Joint> all, const Bodies& bodies, double dt_s,
                    std::span<std::optional<std::uint32_t>> breaks);
    // The impulses from which the next substep would start, or all of a step that has failed.
    void forget_impulses();
    void forget_step();
    std::size_t bytes() const;

    struct Batch;
    struct Motion;

  private:
    static void place(Batch& batch, Chosen chosen, const Bodies& bodies);
    // Those that turn freely now, and of these, those that do not sleep.
    static void choose(Batch& batch, std::span<const Joint> all);
    static Chosen awake(const Batch& batch, const Bodies& bodies);
    // Of those that are awake, those that are solved here: their places are known, and what they carry is in the batch. The other joints
    // have what they carry.
    static Chosen prepare(Batch& batch, std::span<Joint> all, const Bodies& bodies);
    static void give_back(Batch& batch, Chosen chosen, std::span<Joint> all);
    void ask_for_next(std::size_t batch, const Bodies& bodies) const;

    std::vector<Batch> batches_;
    std::vector<std::uint32_t> others_;
};

}  // namespace meld::physics
