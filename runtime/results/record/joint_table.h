// The joints of a run as a recording keeps them: all that any of its steps has had so far, and in each step which of them hold.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/results/record/recording.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/shapes/joint_look.h"

namespace meld::record {

// Collective. Process 0 receives the joints that hold now, of all processes, in the order of their catoms; the others receive none.
// Nothing is sent where the world has none.
std::vector<world::JointLook> all_joints(sim::Subdomain& subdomain);

// What became of a joint. Broken: or a program took it off. Gone: with one of its catoms.
enum class JointFate : std::int64_t { Holds = 0, Broken = 1, Gone = 2 };

class JointTable {
  public:
    // A step with these joints and catoms (sorted). Joints that are new follow those before.
    void note(std::span<const world::JointLook> now, std::span<const std::uint64_t> ids);
    // Of the step that was noted last; valid until the next one. What does not change is the same in all steps, so the file has it once.
    RecordedTable table() const;

    void save(ByteWriter& out) const;
    void load(ByteReader& in);

  private:
    void add(const world::JointLook& joint);

    // Whether a row is of this joint, which has the same catoms: a program may have made another one of them.
    bool is(std::size_t row, const world::JointLook& joint) const;

    std::vector<std::int64_t> firsts_, seconds_, kinds_, fates_;
    std::vector<world::Vec3> first_anchors_, second_anchors_, axes_;
};

}  // namespace meld::record
