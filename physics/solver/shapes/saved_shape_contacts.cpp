// The contacts of bodies with shapes in a snapshot: the batches of a block, as they lie (saved_contacts.cpp). And what is kept of them,
// contact by contact, while batches are laid out again, also on its way to another subdomain, whose batches are others.
#include <algorithm>

#include "physics/solver/body_addresses.h"
#include "physics/solver/contacts.h"
#include "physics/solver/saved_bodies.h"
#include "physics/solver/shapes/shape_contacts.h"

namespace meld::physics {

namespace {

// All that is kept of a point, in the order of its members.
constexpr std::size_t kKeptOfPoint = 11;
std::array<float, kKeptOfPoint> numbers_of(const ShapePoint& p, int i) {
    return {p.ax[i], p.ay[i], p.az[i], p.bx[i], p.by[i], p.bz[i], p.gap[i], p.normal_impulse[i], p.tx[i], p.ty[i], p.tz[i]};
}
void set_numbers(ShapePoint& p, int i, const std::array<float, kKeptOfPoint>& n) {
    p.ax[i] = n[0], p.ay[i] = n[1], p.az[i] = n[2], p.bx[i] = n[3], p.by[i] = n[4], p.bz[i] = n[5];
    p.gap[i] = n[6], p.normal_impulse[i] = n[7], p.tx[i] = n[8], p.ty[i] = n[9], p.tz[i] = n[10];
}

// Which solids a lane is of, if a body of it is a compound. False if there are none of these numbers.
bool load_solids(const ShapeContacts::Setup& setup, const ShapeBatch& batch, int i, ShapeLane& lane, ByteReader& in) {
    const auto parts_of = [&](std::uint32_t slot) {
        const BodyShapes::Index index =
            slot < setup.bodies.count() ? setup.shapes.of(setup.bodies.properties[slot].id) : BodyShapes::Index{0};
        return index == 0 ? std::size_t{0} : setup.shapes.kind(index).shape.parts.size();
    };
    // An obstacle of one solid is no compound.
    const std::size_t of_obstacle = lane.obstacle < setup.obstacles.count() ? setup.obstacles.solids(lane.obstacle) : 0;
    const std::size_t ones = parts_of(batch.a[i]), others = lane.obstacle == kNoSlot ? parts_of(batch.b[i])
                                                            : of_obstacle > 1        ? of_obstacle
                                                                                     : 0;
    lane.of_compound = ones + others > 0;
    if (!lane.of_compound) return true;
    lane.a_solid = in.read<std::uint8_t>(), lane.b_solid = in.read<std::uint8_t>();
    return lane.a_solid < std::max<std::size_t>(ones, 1) && lane.b_solid < std::max<std::size_t>(others, 1);
}

}  // namespace

void ShapeContacts::save(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block, ByteWriter& out) const {
    BodyAddresses addresses(grid, block);
    const auto stays = [&](std::uint32_t slot) { return slot < bodies.count() && (bodies.properties[slot].flags & kRemoved) == 0; };
    const std::span<const ShapeBatch> all = batches(block);
    const ShapeLane* lane = lanes(block).data();
    out.write_count(all.size());
    for (const ShapeBatch& batch : all) {
        out.write(batch.used);
        for (int i = 0; i < kLanes; ++i, ++lane) {
            const bool used = stays(batch.a[i]) && (lane->obstacle != kNoSlot || stays(batch.b[i]));
            out.write(used);
            if (!used) continue;
            out.write(addresses.address(batch.a[i]));
            out.write(lane->obstacle);
            if (lane->is_part()) out.write(lane->part);
            if (lane->obstacle == kNoSlot) out.write(addresses.address(batch.b[i]));
            if (lane->of_compound) out.write(lane->a_solid), out.write(lane->b_solid);
            out.write(lasting(lane->axis)), out.write(lane->points), out.write(lane->touching);
            out.write(std::array{batch.nx[i], batch.ny[i], batch.nz[i]});
            if (lane->points != 0) out.write(batch.same_m[i]);
            for (std::size_t p = 0; p < lane->points; ++p) out.write(numbers_of(batch.points[p], i));
        }
    }
}

bool ShapeContacts::load(const Setup& setup, std::span<const std::span<const std::byte>> of_block) {
    const Bodies& bodies = setup.bodies;
    first_.assign(of_block.size() + 1, 0);
    std::vector<ByteReader> readers;
    for (std::size_t b = 0; b < of_block.size(); ++b) {
        ByteReader& in = readers.emplace_back(of_block[b], "the contacts of a snapshot", ByteReader::Origin::Outside);
        first_[b + 1] = first_[b] + (of_block[b].empty() ? 0 : in.read_count(kLanes + sizeof(std::uint32_t)));
    }
    batches_.resize(first_.back());
    lanes_.assign(kLanes * std::size_t{first_.back()}, {});
    candidates_ = 0, has_parts_ = false;
    for (std::size_t b = 0; b < of_block.size(); ++b) {
        ByteReader& in = readers[b];
        const BodyAddresses addresses(setup.grid, static_cast<std::uint32_t>(b));
        const std::uint32_t nobody = motionless_slot(bodies, static_cast<std::uint32_t>(b));
        ShapeLane* lane = lanes(b).data();
        for (ShapeBatch& batch : batches(b)) {
            empty_batch(batch);
            batch.used = in.read<std::uint32_t>();
            if (batch.used > kMaxManifoldPoints) return false;
            for (int i = 0; i < kLanes; ++i, ++lane) {
                batch.a[i] = batch.b[i] = nobody;
                if (!in.read<bool>()) continue;
                ++candidates_;
                batch.a[i] = addresses.slot(in.read<std::uint32_t>());
                lane->obstacle = in.read<std::uint32_t>();
                if (lane->obstacle == kNoSlot) batch.b[i] = addresses.slot(in.read<std::uint32_t>());
                const bool has_part = lane->obstacle < setup.obstacles.count() && setup.obstacles.is_surface(lane->obstacle);
                if (has_part) lane->part = in.read<std::uint8_t>();
                if (has_part && lane->part >= kMaxSurfaceContacts) return false;
                has_parts_ = has_parts_ || has_part;
                if (!load_solids(setup, batch, i, *lane, in)) return false;
                has_parts_ = has_parts_ || lane->of_compound;
                lane->axis = in.read<AxisHint>(), lane->points = in.read<std::uint8_t>(), lane->touching = in.read<std::uint8_t>();
                const bool known = lane->obstacle == kNoSlot ? batch.b[i] != kNoSlot : lane->obstacle < setup.obstacles.count();
                if (in.failed() || batch.a[i] == kNoSlot || !known || lane->points > kMaxManifoldPoints || batch.a[i] == batch.b[i])
                    return false;
                if (lane->obstacle != kNoSlot)
                    batch.b[i] = slot_of_obstacle(bodies, setup.obstacles, of_block.size(), static_cast<std::uint32_t>(b), lane->obstacle);
                set_materials(setup, batch, i, *lane);
                const auto normal = in.read<std::array<float, 3>>();
                batch.nx[i] = normal[0], batch.ny[i] = normal[1], batch.nz[i] = normal[2];
                if (lane->points != 0) batch.same_m[i] = in.read<float>();
                for (std::size_t p = 0; p < lane->points; ++p) set_numbers(batch.points[p], i, in.read<std::array<float, kKeptOfPoint>>());
            }
        }
        if (in.failed() || (!of_block[b].empty() && !in.done())) return false;
    }
    prepared_ = false;
    return true;
}

std::vector<ShapeContacts::Ended> ShapeContacts::take_out(const Bodies& bodies, const Composites& composites) {
    std::vector<Ended> ended;
    kept_.clear();
    const auto gone = [&](std::uint32_t slot) { return (bodies.properties[slot].flags & kRemoved) != 0; };
    const auto indifferent = [&](std::uint32_t a, std::uint32_t b, bool obstacle) {
        if (composites.empty() && composites.joined().empty()) return false;
        return obstacle ? composites.immovable(bodies.properties[a]) : composites.indifferent(bodies.properties[a], bodies.properties[b]);
    };
    for (std::size_t n = 0; n < batches_.size(); ++n)
        for (int i = 0; i < kLanes; ++i) {
            const ShapeBatch& batch = batches_[n];
            const ShapeLane& lane = lanes_[kLanes * n + static_cast<std::size_t>(i)];
            if (batch.a[i] >= bodies.count() || (lane.points == 0 && lane.touching == 0)) continue;
            const bool obstacle = lane.obstacle != kNoSlot;
            const BodyId a = bodies.properties[batch.a[i]].id, b = obstacle ? lane.obstacle : bodies.properties[batch.b[i]].id;
            if (gone(batch.a[i]) || (!obstacle && gone(batch.b[i])) || indifferent(batch.a[i], batch.b[i], obstacle)) {
                if (lane.touching != 0 && lane.is_first()) ended.push_back({a, b, obstacle});
                continue;
            }
            const bool swapped = !obstacle && b < a;
            Kept& kept = kept_.emplace_back();
            kept.key = swapped ? key_of(b, a, false) : key_of(a, obstacle ? code_of(lane) : b, obstacle);
            kept.solids = solids_of(lane, swapped);
            kept.axis = swapped ? kNoAxis : lasting(lane.axis);
            kept.points = lane.points, kept.touching = lane.touching;
            const float sign = swapped ? -1.0f : 1.0f;
            for (std::size_t p = 0; p < lane.points; ++p) {
                const ShapePoint& point = batch.points[p];
                const float on_a[3] = {point.ax[i], point.ay[i], point.az[i]};
                const float on_b[3] = {lane.is_part() ? batch.nx[i] : point.bx[i], lane.is_part() ? batch.ny[i] : point.by[i],
                                       lane.is_part() ? batch.nz[i] : point.bz[i]};
                std::copy_n(swapped ? on_b : on_a, 3, kept.of[p].first);
                std::copy_n(swapped ? on_a : on_b, 3, kept.of[p].second);
                kept.of[p].normal_impulse = point.normal_impulse[i];
                const float tangent[3] = {sign * point.tx[i], sign * point.ty[i], sign * point.tz[i]};
                std::copy_n(tangent, 3, kept.of[p].tangent);
            }
        }
    batches_.clear(), moved_.clear(), held_.clear(), lanes_.clear(), first_.clear();
    return ended;
}

void ShapeContacts::recall(const Bodies& bodies, ShapeBatch& batch, ShapeLane& lane, int i) const {
    const bool obstacle = lane.obstacle != kNoSlot;
    const BodyId a = bodies.properties[batch.a[i]].id, b = obstacle ? lane.obstacle : bodies.properties[batch.b[i]].id;
    const bool swapped = !obstacle && b < a;
    const std::uint64_t key = swapped ? key_of(b, a, false) : key_of(a, obstacle ? code_of(lane) : b, obstacle);
    const std::pair place(key, solids_of(lane, swapped));
    const auto found = std::ranges::lower_bound(kept_, place, {}, &Kept::place);
    if (found == kept_.end() || found->place() != place) return;
    lane.touching = found->touching, lane.points = found->points;
    if (!swapped) lane.axis = found->axis;
    const float sign = swapped ? -1.0f : 1.0f;
    for (std::size_t p = 0; p < found->points; ++p) {
        ShapePoint& point = batch.points[p];
        const Kept::Point& was = found->of[p];
        const float(&on_a)[3] = swapped ? was.second : was.first, (&on_b)[3] = swapped ? was.first : was.second;
        point.ax[i] = on_a[0], point.ay[i] = on_a[1], point.az[i] = on_a[2];
        if (lane.is_part())
            batch.nx[i] = on_b[0], batch.ny[i] = on_b[1], batch.nz[i] = on_b[2];
        else
            point.bx[i] = on_b[0], point.by[i] = on_b[1], point.bz[i] = on_b[2];
        point.normal_impulse[i] = was.normal_impulse;
        point.tx[i] = sign * was.tangent[0], point.ty[i] = sign * was.tangent[1], point.tz[i] = sign * was.tangent[2];
    }
}

// Without points that a contact has not.
void ShapeContacts::pack_kept(const std::vector<bool>& ids_wanted, ByteWriter& out) const {
    const auto wanted = [&](std::uint64_t id) { return id < ids_wanted.size() && ids_wanted[id]; };
    const auto goes = [&](const Kept& kept) {
        const bool obstacle = (kept.key & 1) != 0;
        return wanted(kept.key >> 32) || (!obstacle && wanted((kept.key & 0xffffffffu) >> 1));
    };
    out.write_count(static_cast<std::size_t>(std::ranges::count_if(kept_, goes)));
    for (const Kept& kept : kept_) {
        if (!goes(kept)) continue;
        out.write(kept.key);
        out.write(kept.solids);
        out.write(kept.axis), out.write(kept.points), out.write(kept.touching);
        for (std::size_t p = 0; p < kept.points; ++p) out.write(kept.of[p]);
    }
}

void ShapeContacts::unpack_kept(ByteReader& in) {
    for (auto left = in.read_count(sizeof(std::uint64_t)); left > 0; --left) {
        Kept& kept = kept_.emplace_back();
        kept.key = in.read<std::uint64_t>();
        kept.solids = in.read<std::uint16_t>();
        kept.axis = in.read<AxisHint>(), kept.points = in.read<std::uint8_t>(), kept.touching = in.read<std::uint8_t>();
        MELD_CHECK(kept.points <= kMaxManifoldPoints, "a contact has {} points", kept.points);
        for (std::size_t p = 0; p < kept.points; ++p) kept.of[p] = in.read<Kept::Point>();
    }
}

}  // namespace meld::physics
