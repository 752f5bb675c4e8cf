// What is known over links and what is under way over them, for snapshots.
#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "runtime/sim/network/saved_links.h"
#include "runtime/sim/network/versions.h"

namespace meld::sim {

void Versions::save(i64 now, ByteWriter& out) const {
    const world::Ensemble& ensemble = members_.ensemble;
    const world::Links& links = ensemble.links();
    // The links with something under way, and the tick in which the last of it arrives.
    struct Busy {
        u64 link;
        i64 last;
        u32 number = kNone32;
    };
    std::vector<Busy> busy;
    for (u32 ticks = 1; ticks <= ring_.size(); ++ticks)
        for (const Entry& entry : ring_[(static_cast<std::size_t>(now) + ticks) % ring_.size()])
            if (entry.index != kGone) busy.push_back({key_of(entry.reader, entry.port), now + ticks});
    std::ranges::sort(busy, [](const Busy& a, const Busy& b) { return std::tuple(a.link, -a.last) < std::tuple(b.link, -b.last); });
    const auto same = std::ranges::unique(busy, {}, &Busy::link);
    busy.erase(same.begin(), same.end());
    u64 count = 0;
    each_link_read(members_.ensemble, [&](Catom, world::Port, Catom, Catom) { ++count; });
    out.write_count(count);
    u32 next = 0;
    auto next_busy = busy.begin();
    each_link_read(members_.ensemble, [&](Catom reader, world::Port port, Catom other, Catom index) {
        const u64 link = key_of(reader, port);
        while (next_busy != busy.end() && next_busy->link < link) ++next_busy;
        const bool is_busy = next_busy != busy.end() && next_busy->link == link;
        if (is_busy) next_busy->number = next;
        ++next;
        i64 last = is_busy ? next_busy->last : now;
        // What a jam holds up comes later than was said when it was sent, and what is lost does not come.
        if (keeps_last()) last = links.last_arrival(other, links.port_there(reader, port), now);
        out.write(ensemble.id(reader));
        out.write(ensemble.id(other));
        out.write(last > now ? last : i64{0});
        const std::size_t state = out.begin_block();
        facts_.columns.pack(index, tuple::Columns::Which::Exported, out);
        out.end_block(state);
    });
    const auto number_of = [&](const Entry& entry) {
        return std::ranges::lower_bound(busy, key_of(entry.reader, entry.port), {}, &Busy::link)->number;
    };
    // By version, what it is as a whole and in one column.
    ByteWriter parcels;
    u32 parcel_count = 0;
    std::unordered_map<u64, u32> parcel_of;
    constexpr u32 kWhole = 64;
    const auto parcel = [&](Catom version, u32 place) {
        const auto [at, made] = parcel_of.try_emplace(u64{version} << 32 | place, parcel_count);
        if (!made) return at->second;
        ++parcel_count;
        ByteWriter bytes;
        const auto kind = place == kWhole ? ParcelKind::State : ParcelKind::Column;
        if (version != kGone && place == kWhole)
            facts_.columns.pack(place_of(version), tuple::Columns::Which::Exported, bytes);
        else if (version != kGone)
            facts_.columns.pack_column(exported_[place], place_of(version), bytes);
        write(parcels, SavedParcel{kind, place == kWhole ? u16{0} : exported_[place], bytes.view()});
        return at->second;
    };
    std::vector<SavedEntry> sent;
    for (u32 ticks = 1; ticks <= ring_.size(); ++ticks)
        for (const Entry& entry : ring_[(static_cast<std::size_t>(now) + ticks) % ring_.size()]) {
            if (entry.index == kGone) {
                for (u32 i = 0; i < entry.reader; ++i) sent.push_back({ticks, kNone32, parcel(kGone, kWhole), false});
                continue;
            }
            const u32 link = number_of(entry);
            if (entry.whole != 0) {
                sent.push_back({ticks, link, parcel(entry.index, kWhole), entry.late != 0});
                continue;
            }
            for (u64 left = kinds_[version_at(entry.index).kind].columns; left != 0; left &= left - 1)
                sent.push_back({ticks, link, parcel(entry.index, static_cast<u32>(std::countr_zero(left))), entry.late != 0});
        }
    out.write_count(parcel_count);
    out.write_bytes(parcels.view().data(), parcels.view().size());
    out.write_count(sent.size());
    for (const SavedEntry& entry : sent) write(out, entry);
}

bool Versions::load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    world::Ensemble& ensemble = members_.ensemble;
    world::Links& links = ensemble.links();
    struct Known {
        Catom reader = 0, other = 0;
        world::Port port = 0;
        Catom latest = kGone;  // Of the versions that are under way over it.
    };
    std::vector<std::optional<Known>> known;
    ByteWriter said;
    each_saved_link(
        in, [&](std::size_t count) { known.resize(count); },
        [&](std::size_t number, const SavedLink& saved) {
            const auto reader = find(saved.reader);
            const auto other = ensemble.find(saved.other);
            // Else it is one of another process.
            if (!reader || !other) return;
            const std::optional<world::Port> port = links.towards(*reader, *other);
            if (!port || links.read(*reader, *port) < 0) return;
            known[number] = {*reader, *other, *port};
            said.clear();
            facts_.columns.pack(*other, tuple::Columns::Which::Exported, said);
            if (keeps_last() && saved.last > now) links.set_last_arrival(*other, links.port_there(*reader, *port), saved.last);
            if (std::ranges::equal(said.view(), saved.known)) return;
            const Catom index = take(*other, Holds::Nothing);
            version_at(index).needed = 1;
            links.read_at(*reader, *port, static_cast<std::int32_t>(index));
            ByteReader state(saved.known, "what has arrived over a link", ByteReader::Origin::Outside);
            facts_.columns.unpack(index, tuple::Columns::Which::Exported, state, 0);
        });
    if (in.failed()) return false;
    const std::vector<SavedParcel> parcels = read_parcels(in);
    std::vector<SavedEntry> entries;
    if (!each_saved_entry(in, parcels.size(), [&](const SavedEntry& entry) { entries.push_back(entry); })) return false;
    // In the order in which they were sent over each link, since a version has the columns of the one before it.
    std::ranges::stable_partition(entries, &SavedEntry::late);
    for (const SavedEntry& entry : entries) {
        // This world's network may be faster.
        const i64 arrival = now + std::min<i64>(entry.ticks, world_.latency());
        if (entry.link == kNone32) {
            if (!takes_lost) continue;
            put_gone(arriving(arrival), 1);
            ++under_way_;
            continue;
        }
        if (entry.link >= known.size() || !known[entry.link]) continue;
        Known& link = *known[entry.link];
        const SavedParcel& parcel = parcels[entry.parcel];
        // Which column changes; none: all of it is new.
        const auto column = std::ranges::find(exported_, parcel.number);
        const bool whole = parcel.kind == ParcelKind::State;
        if (!whole && (parcel.kind != ParcelKind::Column || column == exported_.end())) continue;
        const Catom before = link.latest != kGone ? link.latest : static_cast<Catom>(links.read(link.reader, link.port));
        const Catom index = take(link.other, Holds::Nothing);
        version_at(index).alone = 1;
        if (!whole) version_at(index).kind = static_cast<u32>(column - exported_.begin()) & Version::kMostKind;
        ByteReader bytes(parcel.bytes, "what is under way over a link", ByteReader::Origin::Outside);
        if (whole) {
            facts_.columns.unpack(index, tuple::Columns::Which::Exported, bytes, 0);
        } else {
            for (const u16 each : exported_) facts_.columns.copy(each, before, index, 0);
            facts_.columns.unpack_column(parcel.number, index, bytes, 0);
        }
        link.latest = index;
        put(arrival, {index, link.reader, link.port, whole, entry.late});
    }
    return true;
}

}  // namespace meld::sim
