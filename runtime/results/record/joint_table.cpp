#include "runtime/results/record/joint_table.h"

#include <algorithm>
#include <limits>
#include <utility>

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

bool JointTable::is(std::size_t row, const world::JointLook& joint) const {
    return kinds_[row] == static_cast<std::int64_t>(joint.kind) && first_anchors_[row] == joint.first_anchor &&
           second_anchors_[row] == joint.second_anchor && (joint.kind == world::JointLook::Kind::Ball || axes_[row] == joint.axis);
}

void JointTable::note(std::span<const world::JointLook> now, std::span<const std::uint64_t> ids) {
    const auto exists = [&](std::int64_t id) { return std::ranges::binary_search(ids, static_cast<std::uint64_t>(id)); };
    const auto order = [](const world::JointLook& joint) { return std::pair(joint.first, joint.second); };
    std::vector<bool> known(now.size());
    for (std::size_t i = 0; i < firsts_.size(); ++i) {
        if (fates_[i] != static_cast<std::int64_t>(JointFate::Holds)) continue;
        const std::pair pair(static_cast<std::uint64_t>(firsts_[i]), static_cast<std::uint64_t>(seconds_[i]));
        const auto found = std::ranges::lower_bound(now, pair, {}, order);
        if (found != now.end() && order(*found) == pair && is(i, *found)) {
            known[static_cast<std::size_t>(found - now.begin())] = true;
            continue;
        }
        const bool broken = exists(firsts_[i]) && exists(seconds_[i]);
        fates_[i] = static_cast<std::int64_t>(broken ? JointFate::Broken : JointFate::Gone);
    }
    for (std::size_t i = 0; i < now.size(); ++i)
        if (!known[i]) add(now[i]);
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
    out.write_count(firsts_.size());
    for (std::size_t i = 0; i < firsts_.size(); ++i) {
        for (const std::vector<std::int64_t>* column : {&firsts_, &seconds_, &kinds_, &fates_}) out.write((*column)[i]);
        for (const std::vector<world::Vec3>* column : {&first_anchors_, &second_anchors_, &axes_}) out.write((*column)[i]);
    }
}

void JointTable::load(ByteReader& in) {
    *this = {};
    for (auto left = in.read_count(4 * sizeof(std::int64_t) + 3 * sizeof(world::Vec3)); left > 0; --left) {
        for (std::vector<std::int64_t>* column : {&firsts_, &seconds_, &kinds_, &fates_}) column->push_back(in.read<std::int64_t>());
        for (std::vector<world::Vec3>* column : {&first_anchors_, &second_anchors_, &axes_}) column->push_back(in.read<world::Vec3>());
    }
}

}  // namespace meld::record
