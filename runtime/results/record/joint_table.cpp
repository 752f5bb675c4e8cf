#include "runtime/results/record/joint_table.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/comm/transport/gather_to_root.h"

namespace meld::record {

namespace {

void write(const world::JointLook& joint, ByteWriter& out) {
    out.write(joint.kind);
    out.write(joint.first);
    out.write(joint.second);
    for (const world::Vec3& way : {joint.first_anchor, joint.second_anchor, joint.axis}) out.write(way);
}

world::JointLook read(ByteReader& in) {
    world::JointLook joint;
    joint.kind = in.read<world::JointLook::Kind>();
    joint.first = in.read<std::uint64_t>();
    joint.second = in.read<std::uint64_t>();
    for (world::Vec3* way : {&joint.first_anchor, &joint.second_anchor, &joint.axis}) *way = in.read<world::Vec3>();
    return joint;
}

}  // namespace

std::vector<world::JointLook> all_joints(sim::Subdomain& subdomain) {
    if (!subdomain.has_joints()) return {};
    std::vector<world::JointLook> joints = subdomain.joints();
    if (!subdomain.alone()) {
        ByteWriter mine;
        for (const world::JointLook& joint : joints) write(joint, mine);
        joints.clear();
        for (const auto& bytes : comm::gather_to_root(subdomain.comm, mine.take()))
            for (ByteReader in(bytes, "the joints of a process"); !in.done();) joints.push_back(read(in));
    }
    std::ranges::sort(joints, {}, [](const world::JointLook& joint) { return std::pair(joint.first, joint.second); });
    return joints;
}

void JointTable::add(const world::JointLook& joint) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    firsts_.push_back(static_cast<std::int64_t>(joint.first));
    seconds_.push_back(static_cast<std::int64_t>(joint.second));
    kinds_.push_back(static_cast<std::int64_t>(joint.kind));
    fates_.push_back(static_cast<std::int64_t>(JointFate::Holds));
    first_anchors_.push_back(joint.first_anchor);
    second_anchors_.push_back(joint.second_anchor);
    axes_.push_back(joint.kind == world::JointLook::Kind::Ball ? world::Vec3{kNone, kNone, kNone} : joint.axis);
}

// Those that are left stand in the order in which all of them stood.
void JointTable::note(std::span<const world::JointLook> now, std::span<const std::uint64_t> ids) {
    if (!begun_)
        for (const world::JointLook& joint : now) add(joint);
    begun_ = true;
    const auto exists = [&](std::int64_t id) { return std::ranges::binary_search(ids, static_cast<std::uint64_t>(id)); };
    std::size_t next = 0;
    for (std::size_t i = 0; i < firsts_.size(); ++i) {
        const bool holds = next < now.size() && static_cast<std::int64_t>(now[next].first) == firsts_[i] &&
                           static_cast<std::int64_t>(now[next].second) == seconds_[i];
        next += holds ? 1 : 0;
        if (holds || fates_[i] != static_cast<std::int64_t>(JointFate::Holds)) continue;
        const bool broken = exists(firsts_[i]) && exists(seconds_[i]);
        fates_[i] = static_cast<std::int64_t>(broken ? JointFate::Broken : JointFate::Gone);
    }
    MELD_CHECK(next == now.size(), "{} of {} joints are those of the first step", next, now.size());
}

RecordedTable JointTable::table() const {
    const auto numbers = [](const char* name, const std::vector<std::int64_t>& column) {
        return RecordedArray{.name = name, .type = RecordedArray::Int64, .data = column.data()};
    };
    const auto ways = [](const char* name, const std::vector<world::Vec3>& column) {
        return RecordedArray{.name = name, .type = RecordedArray::Float64, .data = column.data(), .components = 3};
    };
    return {.name = "joints",
            .rows = firsts_.size(),
            .columns = {numbers("first", firsts_), numbers("second", seconds_), numbers("kind", kinds_), numbers("fate", fates_),
                        ways("first_anchor", first_anchors_), ways("second_anchor", second_anchors_), ways("axis", axes_)},
            .kind = RecordedTable::Kind::Joints};
}

void JointTable::save(ByteWriter& out) const {
    out.write(begun_);
    out.write_count(firsts_.size());
    for (std::size_t i = 0; i < firsts_.size(); ++i) {
        for (const std::vector<std::int64_t>* column : {&firsts_, &seconds_, &kinds_, &fates_}) out.write((*column)[i]);
        for (const std::vector<world::Vec3>* column : {&first_anchors_, &second_anchors_, &axes_}) out.write((*column)[i]);
    }
}

void JointTable::load(ByteReader& in) {
    *this = {};
    begun_ = in.read<bool>();
    for (auto left = in.read_count(4 * sizeof(std::int64_t) + 3 * sizeof(world::Vec3)); left > 0; --left) {
        for (std::vector<std::int64_t>* column : {&firsts_, &seconds_, &kinds_, &fates_}) column->push_back(in.read<std::int64_t>());
        for (std::vector<world::Vec3>* column : {&first_anchors_, &second_anchors_, &axes_}) column->push_back(in.read<world::Vec3>());
    }
}

}  // namespace meld::record
