// The joints of a scene, by assemblies in the order of their lowest bodies. Each assembly is solved by one worker, and no two share a body
// or composite that can be moved. A joint within a composite, or between two that nothing can move, is idle: it is in no assembly, carries
// nothing, and acts again when its bodies move apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/joints/assembly.h"
#include "physics/joints/joint.h"
#include "physics/joints/lone_joints.h"
#include "physics/joints/movers.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

class Joints {
  public:
    bool empty() const { return joints_.empty(); }
    std::span<const Joint> all() const { return joints_; }
    // For an engine that solves them itself.
    std::span<Joint> each() { return joints_; }
    const Joint* find(BodyId one, BodyId other) const;
    // Of two bodies that have none yet; and all joints of a body.
    void add(const Joint& joint);
    void remove_all(BodyId body);
    void remove(BodyId one, BodyId other);
    void drive(BodyId one, BodyId other, const JointDrive& drive);
    // Joints of bodies that have none with each other yet, in any order; and leaves those that are chosen here, by their places in all().
    void add_all(std::span<const Joint> more);
    void keep(const std::vector<bool>& chosen);

    // Which joints hang together: their places in all(), by the lowest of what moves their bodies, as `mover` says (Movers::of). What
    // nothing can move joins nothing; joints between two such bodies go by the first of them.
    using Groups = std::map<BodyId, std::vector<std::uint32_t>>;
    Groups groups(const std::function<BodyId(BodyId)>& mover) const;
    Groups groups(const Movers& movers) const;

    // Composites have been made or have ended: assemblies are laid out anew.
    void recomposed() { changed_ = true; }
    // Bodies have other slots, or joints or composites have changed. Errors: a body or composite has too many joints, or an assembly too
    // many loops.
    Result<void> settle(const Movers& movers);
    std::span<const Assembly> assemblies() const { return assemblies_; }
    // Places have changed, or which bodies can be moved.
    void places_changed();
    void forget_impulses();
    // A step has failed: what joints have carried in it does not count.
    void forget_step();

    // After a step of this length: finds what joints have carried, and takes out those that break: of each assembly the one that carried
    // too much by the greatest factor.
    void end_step(const Movers& movers, double dt_s, Workers& workers);
    // Those that broke in the last step, the lower body first; sorted.
    std::span<const std::pair<BodyId, BodyId>> broken() const { return broken_; }
    // Takes the loads of the steps since the last call, as means. Joints that slept keep theirs.
    void take_loads();

    void warm_start(const Movers& movers, Workers& workers);
    void run(Assembly::Phase phase, const Movers& movers, double step_s, Workers& workers);

    void write(ByteWriter& out) const;
    // Those that are chosen, by their places in all().
    void write(ByteWriter& out, const std::vector<bool>& chosen) const;
    // Adds what was written, several times in a divided world. False if that is no joint; and if there is no body of one, when all are
    // there.
    bool read(ByteReader& in);
    bool fits(const Bodies& bodies) const;
    std::size_t bytes() const;

  private:
    std::vector<Joint>::iterator place_of_pair(BodyId one, BodyId other);
    bool lay_out(const Movers& movers);
    // `of_batch` returns which joints of a batch are left to their assemblies; `of_assembly` gets the place of one.
    template <class OfBatch, class OfAssembly>
    void for_assemblies(Workers& workers, const OfBatch& of_batch, const OfAssembly& of_assembly);

    // Sorted by their bodies, the lower first.
    std::vector<Joint> joints_;
    std::vector<Assembly> assemblies_;
    LoneJoints lone_;
    // By assembly: which of its joints breaks.
    std::vector<std::optional<std::uint32_t>> breaks_;
    std::vector<std::pair<BodyId, BodyId>> broken_;
    // Drives have changed since the last pass.
    bool driven_ = false;
    bool changed_ = false;
};

}  // namespace meld::physics
