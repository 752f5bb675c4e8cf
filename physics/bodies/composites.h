// Rigid composites: bodies that connections hold together move as one body with a mass, a centre and a tensor of inertia. Members keep
// their slots; they take their places and velocities from their composite, and their inverse masses are 0, so that passes over bodies
// leave them alone. A composite with a fixed body is carried by it: nothing else moves it, so its members are like fixed bodies.
//
// Connections take effect in `settle`, before a step: whatever was made and broken since, only the bodies that are together then count.
// A composite gets its mass, centre, inertia, momentum and angular momentum from sums over its members in the order of their ids, and
// nothing else, so its bits do not depend on how it came about.
//
// In a divided world every subdomain knows all connections, and has the composites of which it has some body. A composite is made anew
// where it is, once all its bodies are there: `find_changes`, which settle does first, says whether that is needed (subdomain.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/body_shape.h"
#include "physics/bodies/connections.h"
#include "physics/bodies/joined_pairs.h"
#include "physics/bodies/symmetric.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

struct StepTimes;
struct MoveRule;

inline constexpr std::uint32_t kNoComposite = 0xffffffff;

// The world's place and motion of a composite: the fixed body's, if one carries it.
struct CompositeMotion {
    Vec3 centre_m;
    Quat turn;
    Vec3 velocity_m_s, spin_rad_s;
};

struct Composite {
    // Its members are these of Composites::members(), in the order of their ids.
    std::uint32_t first = 0, count = 0;
    // The fixed body with the lowest id among them; kMaxBodies if there is none.
    BodyId carrier = kMaxBodies;
    std::uint8_t asleep = 0;
    // Connections of it were made or broken: it is made anew, unless it has the same members again. A member was moved by the caller: it is
    // made anew in any case.
    std::uint8_t changed = 0, moved = 0, zero = 0;
    double mass_kg = 0;
    // In its own frame.
    Symmetric inertia = {}, inverse_inertia = {};
    CompositeMotion motion;
    // What the wrenches on its members added to its velocity in the last substep, m/s^2.
    Vec3 pushed_m_s2 = {};

    bool carried() const { return carrier != kMaxBodies; }
    bool moves_freely() const { return !carried() && asleep == 0; }
    // Nothing moves it now.
    bool rests() const { return asleep != 0 || (carried() && motion.velocity_m_s == Vec3{} && motion.spin_rad_s == Vec3{}); }
    Vec3 velocity_at(Vec3 arm) const { return motion.velocity_m_s + cross(motion.spin_rad_s, arm); }
    // Its attitude after it has turned freely from this one for so long, with this spin at the beginning.
    Quat turned_freely(Quat from, Vec3 spin_rad_s, double step_s) const;
};

class Composites {
  public:
    struct Member {
        BodyId id;
        std::uint32_t slot;
        // In the composite's frame.
        Vec3 offset_m;
        Quat turn;
    };
    // Changes of the graph: noted here, so that settle looks at what they touch alone.
    void connect(BodyId one, BodyId other);
    void release(BodyId one, BodyId other);
    void release_all(BodyId body);
    // The caller has given this body another place or velocity: its composite is made anew with it.
    void body_moved(BodyId body);

    // Whether no body is or was connected since the last step: then nothing here costs anything.
    bool empty() const { return composites_.empty() && connections_.empty() && !pending_; }
    bool pending() const { return pending_; }
    const Connections& connections() const { return connections_; }
    // Bodies that joints hold together collide as little as those of one composite.
    JoinedPairs& joined() { return joined_; }
    const JoinedPairs& joined() const { return joined_; }

    // Merges and splits as the connections say. Bodies that become free get their masses back. Returns whether the members of some
    // composite have changed.
    bool settle(Bodies& bodies, const BodyShapes& shapes);
    // The same in two steps: which groups of bodies, here or elsewhere, are to be composites that are none yet; whether any composite that
    // is here changes; and then the change, for which all bodies of these groups must be here. `here`: whether a body is.
    bool find_changes(const std::function<bool(BodyId)>& here);
    std::span<const std::vector<BodyId>> new_groups() const { return new_groups_; }
    void make_changes(Bodies& bodies, const BodyShapes& shapes);
    // Bodies have other slots.
    void locate(const Bodies& bodies);

    std::span<const Composite> all() const { return composites_; }
    std::span<Composite> all() { return composites_; }
    std::span<const Member> members() const { return members_; }
    std::span<const Member> members(const Composite& composite) const {
        return std::span(members_).subspan(composite.first, composite.count);
    }
    // The body is a member of a composite.
    const Member& member_of(BodyId body) const;
    std::uint32_t composite_of(BodyId body) const { return body < of_id_.size() ? of_id_[body] : kNoComposite; }
    // The composite that moves a body; none for free bodies, and for those that a fixed body carries.
    std::uint32_t mover_of(BodyId body) const {
        const std::uint32_t composite = composite_of(body);
        return composite == kNoComposite || composites_[composite].carried() ? kNoComposite : composite;
    }
    // Whether nothing can happen between two bodies: they are of one composite, or joined, or neither can be moved.
    bool indifferent(const BodyProperties& one, const BodyProperties& other) const {
        if (joined_.has(one.id, other.id)) return true;
        const std::uint32_t a = composite_of(one.id);
        return (a != kNoComposite && a == composite_of(other.id)) || (immovable(one) && immovable(other));
    }
    bool immovable(const BodyProperties& one) const {
        const std::uint32_t composite = composite_of(one.id);
        return (one.flags & kFixed) != 0 || (composite != kNoComposite && composites_[composite].carried());
    }

    // The inertia of a member about its own centre, in the composite's frame.
    static Symmetric own_inertia(const Member& member, const Bodies& bodies, const BodyShapes& shapes);

    // The passes of a step (composite_motion.cpp). Velocities under gravity, wrenches (null: none) and damping; then the composites'
    // places after a step, and the velocities that bring their members there; then exactly those places, and the members' velocities.
    void accelerate(const Wrench* first_wrench, const Wrench* second_wrench, const Bodies& bodies, const MoveRule& rule, Workers& workers);
    void move(Bodies& bodies, double step_s, Workers& workers);
    void place_members(Bodies& bodies, Workers& workers) const;
    void set_velocities(Bodies& bodies, Workers& workers) const;
    // The same after settle() too, for composites that rest from now on: their members have moved until then.
    void set_all_velocities(Bodies& bodies, Workers& workers) const;

    // Before a step that may fail, and after it.
    void keep();
    void restore();

    // Of a divided world: a composite on its way to another subdomain, or in a snapshot; leaves those that are chosen here, by their places
    // in all(). Then, when the bodies of all are in their slots, `arrange`.
    void write(const Composite& composite, ByteWriter& out) const;
    bool read_one(ByteReader& in);
    void keep(const std::vector<bool>& chosen);
    void arrange(Bodies& bodies);

    // Those for which `ours` says so of the lowest body of a composite, and of the lower body of a connection. A composite that ends in the
    // next step is left out: its members, some of which may have been killed, are free bodies from then on or are made another one.
    void write(ByteWriter& out, const std::function<bool(BodyId)>& ours) const;
    // Adds what was written, several times in a divided world. Connections come before the bodies; `loaded` follows when all bodies are in
    // their slots. False if they name what is not there; connections may lead to bodies elsewhere if `divided`.
    bool read(ByteReader& in);
    bool loaded(Bodies& bodies, bool divided);
    std::size_t bytes() const;

  private:
    // Members first .. end - 1, all of one composite.
    struct Range {
        std::uint32_t composite, first, end;
    };
    void note(BodyId body);
    // Whether the next step keeps it as it is: nothing has touched it, or it has the same members again.
    bool stays(const Composite& composite) const;
    // In the order of their lowest bodies, with their members.
    void sort_all();
    void make(const Bodies& bodies, const BodyShapes& shapes, const std::vector<BodyId>& group, Composite& made,
              std::vector<Member>& members) const;
    // Which composite each member belongs to, and its slot; members lose their masses.
    void index(Bodies& bodies);
    // Calls f(composite) for each, and f(composite, its members of a range).
    template <class F>
    void each_composite(Workers& workers, const F& f);
    // Leaves out those for which `left_out` says so.
    template <class LeftOut, class F>
    void each_range(Workers& workers, const LeftOut& left_out, const F& f) const;
    static void set_velocities(Bodies& bodies, const Composite& composite, std::span<const Member> some);

    Connections connections_;
    JoinedPairs joined_;
    std::vector<Composite> composites_;
    std::vector<Member> members_;
    // All members, in ranges short enough for a job; of short ones, several make a job. The first range of each job, and their number.
    std::vector<Range> ranges_;
    std::vector<std::uint32_t> jobs_;
    std::vector<std::uint32_t> of_id_;
    std::vector<CompositeMotion> kept_;
    // Between find_changes and make_changes: groups that become composites, in the order of their lowest bodies; and by composite, whether
    // it ends.
    std::vector<std::vector<BodyId>> new_groups_;
    std::vector<std::uint8_t> ends_;
    bool pending_ = false;
    bool left_out_ = false;  // One that ends was left out of the snapshot that was read.
};

}  // namespace meld::physics
