// Changes of single rows of a column: applies them and notes for the readers which rows they were. The changes of columns with lists are
// not recorded by row.
#include <cstring>

#include "runtime/engine/tuple/columns.h"

namespace meld::tuple {

namespace {

// Every group that changed, in order: visit(row, whether the group holds it now).
template <class Visit>
void each_change(const ColumnInfo& info, const RowChanges& changes, const Visit& visit) {
    const u8* removed = reinterpret_cast<const u8*>(&changes + 1);
    const u8* added = removed + std::size_t{changes.removed} * info.row_bytes;
    for (u32 r = 0, a = 0; r < changes.removed || a < changes.added;) {
        const int side = r == changes.removed ? 1 : a == changes.added ? -1 : info.compare_groups(removed, added);
        visit(side < 0 ? removed : added, side >= 0);
        if (side <= 0) removed += info.row_bytes;
        if (side >= 0) added += info.row_bytes;
        r += side <= 0;
        a += side >= 0;
    }
}

}  // namespace

void Columns::replace_rows(u32 column, u32 catom, const void* with, u32 count, int pool) {
    if (changes_.follows(column)) {
        const ColumnInfo& info = module_.columns[column];
        const RowsHead& head = rows(column, catom);
        const auto* now = static_cast<const u8*>(with);
        // Merges both, twice: once to count, once to copy.
        const auto differences = [&](const auto& lost, const auto& gained) {
            for (u32 a = 0, b = 0; a < head.count || b < count;) {
                const u8* before = head.data + std::size_t{a} * info.row_bytes;
                const u8* after = now + std::size_t{b} * info.row_bytes;
                const int side = a == head.count ? 1 : b == count ? -1 : info.compare_groups(before, after);
                if (side != 0 || std::memcmp(before, after, info.row_bytes) != 0) {
                    if (side <= 0) lost(before);
                    if (side >= 0) gained(after);
                }
                a += side <= 0;
                b += side >= 0;
            }
        };
        u32 removed = 0, added = 0;
        differences([&](const u8*) { ++removed; }, [&](const u8*) { ++added; });
        RowChanges* changes = changes_.make(column, removed, added, pool);
        u8* out[2] = {reinterpret_cast<u8*>(changes + 1), reinterpret_cast<u8*>(changes + 1) + std::size_t{removed} * info.row_bytes};
        const auto copy = [&](int side) {
            return [&out, &info, side](const u8* row) {
                std::memcpy(out[side], row, info.row_bytes);
                out[side] += info.row_bytes;
            };
        };
        differences(copy(0), copy(1));
        changes_.note(column, catom, changes, pool);
    }
    set_rows(column, catom, with, count, pool);
}

void Columns::change_rows(u32 column, u32 catom, RowChanges* changes, int pool) {
    MELD_EXPECT(changes_.follows(column), "column {}", column);
    // A few rows are found and changed in place; many are cheaper to merge at once.
    const bool few = changes->removed + changes->added <= 8;
    if (changes->placed != 0)
        insert_rows(column, catom, *changes, pool);
    else
        few ? change_in_place(column, catom, *changes, pool) : merge_changes(column, catom, *changes, pool);
    changes_.note(column, catom, changes, pool);
}

void Columns::change_in_place(u32 column, u32 catom, const RowChanges& changes, int pool) {
    const ColumnInfo& info = module_.columns[column];
    const RowsHead& head = rows(column, catom);
    const auto row_at = [&](u32 at) { return head.data + std::size_t{at} * info.row_bytes; };
    const auto find = [&](const u8* row) {
        u32 low = 0, high = head.count;
        while (low < high) {
            const u32 middle = low + (high - low) / 2;
            if (info.compare_groups(row_at(middle), row) < 0)
                low = middle + 1;
            else
                high = middle;
        }
        return low;
    };
    each_change(info, changes, [&](const u8* row, bool holds) {
        const u32 at = find(row);
        const bool there = at < head.count && info.compare_groups(row_at(at), row) == 0;
        if (!holds && there) erase_row(column, catom, at);
        if (holds && !there) insert_row(column, catom, at, row, pool);
        if (holds && there) std::memcpy(row_at(at), row, info.row_bytes);
    });
    if (!RowPool::fits(head.capacity, head.count, info.row_bytes)) set_rows(column, catom, head.data, head.count, pool);
}

void Columns::merge_changes(u32 column, u32 catom, const RowChanges& changes, int pool) {
    const ColumnInfo& info = module_.columns[column];
    const RowsHead& head = rows(column, catom);
    if (head.count == 0) {
        const auto* added = reinterpret_cast<const u8*>(&changes + 1) + std::size_t{changes.removed} * info.row_bytes;
        return set_rows(column, catom, added, changes.added, pool);
    }
    std::vector<u8> out;
    out.reserve((std::size_t{head.count} + changes.added) * info.row_bytes);
    u32 from = 0;
    const auto before = [&] { return head.data + std::size_t{from} * info.row_bytes; };
    const auto copy = [&](const u8* row) { out.insert(out.end(), row, row + info.row_bytes); };
    each_change(info, changes, [&](const u8* row, bool holds) {
        for (; from < head.count && info.compare_groups(before(), row) < 0; ++from) copy(before());
        if (from < head.count && info.compare_groups(before(), row) == 0) ++from;
        if (holds) copy(row);
    });
    for (; from < head.count; ++from) copy(before());
    set_rows(column, catom, out.data(), static_cast<u32>(out.size() / info.row_bytes), pool);
}

// From the last row on, so that each of those that were there is moved once, and rows with room stay in their block.
void Columns::insert_rows(u32 column, u32 catom, const RowChanges& changes, int pool) {
    const std::size_t size = module_.columns[column].row_bytes;
    const u32* const places = places_of(changes, size);
    MELD_EXPECT(changes.removed == 0, "column {}", column);
    RowsHead& head = *reinterpret_cast<RowsHead*>(entry(column, catom));
    const auto* const added = reinterpret_cast<const u8*>(&changes + 1);
    const u32 count = head.count + changes.added;
    u8* const from = head.data;
    u8* const to = RowPool::fits(head.capacity, count, size) ? from : pools_[static_cast<std::size_t>(pool)].take(count * size);
    u32 end = head.count;
    for (u32 k = changes.added; k-- > 0;) {
        MELD_ASSERT(places[k] <= end, "row {} of {} comes before row {} of {}", k, changes.added, places[k], end);
        u8* const place = to + (std::size_t{places[k]} + k) * size;
        if (places[k] < end) std::memmove(place + size, from + places[k] * size, (end - places[k]) * size);
        std::memcpy(place, added + k * size, size);
        end = places[k];
    }
    if (to != from) {
        if (end > 0) std::memcpy(to, from, end * size);
        if (head.capacity > 0) pools_[static_cast<std::size_t>(pool)].give(from, head.capacity * size);
        head.data = to;
        head.capacity = block_capacity(count * size, size);
    }
    head.count = count;
}

void Columns::erase_row(u32 column, u32 catom, u32 at) {
    const std::size_t size = module_.columns[column].row_bytes;
    RowsHead& head = *reinterpret_cast<RowsHead*>(entry(column, catom));
    MELD_EXPECT(at < head.count, "row {} of {}", at, head.count);
    --head.count;
    std::memmove(head.data + at * size, head.data + (at + 1) * size, (head.count - at) * size);
}

void Columns::note_added(u32 column, u32 catom, const void* row, int pool) {
    if (!changes_.follows(column)) return;
    RowChanges* changes = changes_.make(column, 0, 1, pool);
    std::memcpy(changes + 1, row, module_.columns[column].row_bytes);
    changes_.note(column, catom, changes, pool);
}

void Columns::note_woken(u32 column, u32 catom, const void* row, int pool) {
    MELD_EXPECT(changes_.follows(column), "column {}", column);
    RowChanges* changes = changes_.make(column, 0, 1, pool);
    changes->added = 0;
    changes->woken = 1;
    std::memcpy(changes + 1, row, module_.columns[column].row_bytes);
    changes_.note(column, catom, changes, pool);
}

}  // namespace meld::tuple
