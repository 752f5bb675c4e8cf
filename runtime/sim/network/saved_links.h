// How snapshots have what is known over links and what is under way: the links, the parcels, and which parcel is under way over which link.
// Two classes keep them in two ways (network.h, versions.h) and write the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::sim {

enum class ParcelKind : u8 { Column, Rows, State, Message };

// What the reader knows of the other; and in which tick the latest arrives that was sent to it, or some earlier one if it has arrived.
struct SavedLink {
    u64 reader, other;
    i64 last;
    std::span<const std::byte> known;
};
struct SavedParcel {
    ParcelKind kind;
    u16 number;  // Of a column or predicate.
    std::span<const std::byte> bytes;
};
struct SavedEntry {
    u32 ticks;  // Until it arrives.
    u32 link;   // kNone32: one that is gone.
    u32 parcel;
    bool late;
};

// Calls begin(number of links), and visit(number, link) for each.
template <class Begin, class Visit>
void each_saved_link(ByteReader& in, const Begin& begin, const Visit& visit) {
    const std::size_t count = in.read_count(3 * sizeof(u64));
    begin(count);
    for (std::size_t number = 0; number < count; ++number) {
        SavedLink link{};
        link.reader = in.read<u64>();
        link.other = in.read<u64>();
        link.last = in.read<i64>();
        link.known = in.read_block();
        if (in.failed()) return;
        visit(number, link);
    }
}

inline std::vector<SavedParcel> read_parcels(ByteReader& in) {
    std::vector<SavedParcel> parcels;
    for (std::size_t left = in.read_count(sizeof(u16)); left > 0 && !in.failed(); --left) {
        const auto kind = in.read<ParcelKind>();
        const auto number = in.read<u16>();
        parcels.push_back({kind, number, in.read_block()});
    }
    return parcels;
}

inline void write(ByteWriter& out, const SavedParcel& parcel) {
    out.write(parcel.kind);
    out.write(parcel.number);
    out.write_block(parcel.bytes);
}

// Returns whether all could be read.
template <class Visit>
bool each_saved_entry(ByteReader& in, std::size_t parcels, const Visit& visit) {
    for (std::size_t left = in.read_count(3 * sizeof(u32)); left > 0 && !in.failed(); --left) {
        SavedEntry entry{};
        entry.ticks = in.read<u32>();
        entry.link = in.read<u32>();
        entry.parcel = in.read<u32>();
        entry.late = in.read<bool>();
        if (entry.ticks == 0 || entry.parcel >= parcels) return false;
        visit(entry);
    }
    return true;
}

inline void write(ByteWriter& out, const SavedEntry& entry) {
    out.write(entry.ticks);
    out.write(entry.link);
    out.write(entry.parcel);
    out.write(entry.late);
}

}  // namespace meld::sim
