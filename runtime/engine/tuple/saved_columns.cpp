// Columns in a snapshot: what many catoms hold, a column at a time, so that a column of numbers is one run of bytes.
#include <cstring>

#include "runtime/engine/tuple/columns.h"

namespace meld::tuple {

void Columns::save(std::span<const u32> catoms, ByteWriter& out) const {
    for (u32 c = 0; c < module_.column_count; ++c) {
        if (module_.columns[c].list_count > 0) {
            for (const u32 catom : catoms) {
                const std::size_t begun = out.begin_block();
                pack_column(c, catom, out);
                out.end_block(begun);
            }
        } else if (module_.columns[c].rows) {
            save_rows(c, catoms, out);
        } else {
            save_records(c, catoms, out);
        }
        if (changes_.follows(c)) changes_.save(c, catoms, out);
    }
}

void Columns::load(std::span<const SavedCatom> catoms, ByteReader& in) {
    Unpacking room;
    for (u32 c = 0; c < module_.column_count; ++c) {
        if (module_.columns[c].list_count > 0) {
            for (const SavedCatom& each : catoms) {
                ByteReader one(in.read_block(), "a column of a snapshot");
                if (each.owned || (each.here() && module_.columns[c].exported)) unpack_column(c, each.catom, one, 0, room);
            }
        } else if (module_.columns[c].rows) {
            load_rows(c, catoms, in);
        } else {
            load_records(c, catoms, in);
        }
        if (changes_.follows(c)) changes_.load(c, catoms, in);
    }
}

void Columns::save_records(u32 column, std::span<const u32> catoms, ByteWriter& out) const {
    const std::size_t stride = module_.columns[column].stride;
    // Runs of catoms that stand next to each other in memory; mostly all are one.
    for (std::size_t from = 0, to = 0; from < catoms.size(); from = to) {
        for (to = from + 1; to < catoms.size() && catoms[to] == catoms[to - 1] + 1;) ++to;
        out.write_bytes(entry(column, catoms[from]), (to - from) * stride);
    }
}

void Columns::load_records(u32 column, std::span<const SavedCatom> catoms, ByteReader& in) {
    const ColumnInfo& info = module_.columns[column];
    const std::span<const std::byte> all = in.read_bytes(catoms.size() * info.stride);
    if (all.empty()) return;
    const auto follows = [&](std::size_t i) {
        return catoms[i].catom == catoms[i - 1].catom + 1 && catoms[i].owned == catoms[i - 1].owned;
    };
    for (std::size_t from = 0, to = 0; from < catoms.size(); from = to) {
        for (to = from + 1; to < catoms.size() && catoms[from].here() && follows(to);) ++to;
        if (catoms[from].owned || (catoms[from].here() && info.exported))
            std::memcpy(entry(column, catoms[from].catom), all.data() + from * info.stride, (to - from) * info.stride);
    }
}

void Columns::save_rows(u32 column, std::span<const u32> catoms, ByteWriter& out) const {
    for (const u32 catom : catoms) out.write(rows(column, catom).count);
    for (const u32 catom : catoms) {
        const RowsHead& head = rows(column, catom);
        out.write_bytes(head.data, std::size_t{head.count} * module_.columns[column].row_bytes);
    }
}

void Columns::load_rows(u32 column, std::span<const SavedCatom> catoms, ByteReader& in) {
    const ColumnInfo& info = module_.columns[column];
    const std::span<const std::byte> counts = in.read_bytes(catoms.size() * sizeof(u32));
    if (counts.empty()) return;
    for (std::size_t i = 0; i < catoms.size(); ++i) {
        u32 count = 0;
        std::memcpy(&count, counts.data() + i * sizeof count, sizeof count);
        const std::span<const std::byte> all = in.read_bytes(std::size_t{count} * info.row_bytes);
        if (!all.empty() && (catoms[i].owned || (catoms[i].here() && info.exported)))
            set_rows(column, catoms[i].catom, all.data(), count, 0);
    }
}

}  // namespace meld::tuple
