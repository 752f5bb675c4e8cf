// The contacts of bodies with shapes in a snapshot: the batches of a block, as they lie (saved_contacts.cpp). And on their way to another
// subdomain, whose batches are others: contact by contact.
#include <algorithm>

#include "physics/solver/body_addresses.h"
#include "physics/solver/contacts.h"
#include "physics/solver/saved_bodies.h"
#include "physics/solver/shape_contacts.h"

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
            out.write(lane->axis), out.write(lane->points), out.write(lane->touching);
            out.write(std::array{batch.nx[i], batch.ny[i], batch.nz[i]});
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
                lane->axis = in.read<AxisHint>(), lane->points = in.read<std::uint8_t>(), lane->touching = in.read<std::uint8_t>();
                const bool known = lane->obstacle == kNoSlot ? batch.b[i] != kNoSlot : lane->obstacle < setup.obstacles.count();
                if (in.failed() || batch.a[i] == kNoSlot || !known || lane->points > kMaxManifoldPoints || batch.a[i] == batch.b[i])
                    return false;
                set_materials(setup, batch, i, *lane);
                const auto normal = in.read<std::array<float, 3>>();
                batch.nx[i] = normal[0], batch.ny[i] = normal[1], batch.nz[i] = normal[2];
                for (std::size_t p = 0; p < lane->points; ++p) set_numbers(batch.points[p], i, in.read<std::array<float, kKeptOfPoint>>());
            }
        }
        if (in.failed() || (!of_block[b].empty() && !in.done())) return false;
    }
    prepared_ = false;
    return true;
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
        out.write(kept.axis), out.write(kept.points), out.write(kept.touching);
        for (std::size_t p = 0; p < kept.points; ++p) out.write(kept.of[p]);
    }
}

void ShapeContacts::unpack_kept(ByteReader& in) {
    for (auto left = in.read_count(sizeof(std::uint64_t)); left > 0; --left) {
        Kept& kept = kept_.emplace_back();
        kept.key = in.read<std::uint64_t>();
        kept.axis = in.read<AxisHint>(), kept.points = in.read<std::uint8_t>(), kept.touching = in.read<std::uint8_t>();
        MELD_CHECK(kept.points <= kMaxManifoldPoints, "a contact has {} points", kept.points);
        for (std::size_t p = 0; p < kept.points; ++p) kept.of[p] = in.read<Kept::Point>();
    }
}

}  // namespace meld::physics
