// Open addressing with at least half of the rows free; the number of rows is a power of two.
#include "runtime/world/ensemble/brick_table.h"

#include <bit>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"

namespace meld::world {

std::uint32_t BrickTable::find(std::uint64_t key) const {
    if (rows_.empty()) return 0;
    const std::size_t mask = rows_.size() - 1;
    for (std::size_t at = mix64(key) & mask;; at = (at + 1) & mask) {
        if (rows_[at].slot == 0 || rows_[at].key == key) return rows_[at].slot;
    }
}

void BrickTable::insert(std::uint64_t key, std::uint32_t slot) {
    MELD_EXPECT(slot != 0 && find(key) == 0, "slot {}", slot);
    if (2 * (used_ + 1) > rows_.size()) grow(rows_.empty() ? 64 : 2 * rows_.size());
    place({key, slot});
    ++used_;
}

void BrickTable::reserve(std::size_t count) {
    if (const std::size_t rows = rows_for(count); rows > rows_.size()) grow(rows);
}

void BrickTable::place(Row row) {
    const std::size_t mask = rows_.size() - 1;
    std::size_t at = mix64(row.key) & mask;
    while (rows_[at].slot != 0) at = (at + 1) & mask;
    rows_[at] = row;
}

void BrickTable::grow(std::size_t rows) {
    std::vector<Row> old = std::exchange(rows_, std::vector<Row>(rows));
    for (const Row& row : old) {
        if (row.slot != 0) place(row);
    }
}

std::uint32_t IdTable::find(std::uint64_t id, std::span<const std::uint64_t> ids) const {
    if (rows_.empty()) return kAbsent;
    const std::size_t mask = rows_.size() - 1;
    for (std::size_t at = mix64(id) & mask;; at = (at + 1) & mask) {
        if (rows_[at] == kAbsent || ids[rows_[at]] == id) return rows_[at];
    }
}

void IdTable::insert(std::uint32_t index, std::span<const std::uint64_t> ids) {
    MELD_EXPECT(find(ids[index], ids) == kAbsent, "id {} is known already", ids[index]);
    if (2 * (used_ + 1) > rows_.size()) reserve(used_ + 1, ids);
    place(index, ids);
    ++used_;
}

void IdTable::erase(std::uint32_t index, std::span<const std::uint64_t> ids) {
    MELD_EXPECT(find(ids[index], ids) == index, "id {}", ids[index]);
    const std::size_t mask = rows_.size() - 1;
    std::size_t hole = mix64(ids[index]) & mask;
    while (rows_[hole] != index) hole = (hole + 1) & mask;
    // Rows after the hole move up into it unless they would then be before the row where their search begins.
    for (std::size_t at = (hole + 1) & mask; rows_[at] != kAbsent; at = (at + 1) & mask) {
        const std::size_t home = mix64(ids[rows_[at]]) & mask;
        if (((at - home) & mask) < ((at - hole) & mask)) continue;
        rows_[hole] = rows_[at];
        hole = at;
    }
    rows_[hole] = kAbsent;
    --used_;
}

void IdTable::reserve(std::size_t count, std::span<const std::uint64_t> ids) {
    const std::size_t rows = std::bit_ceil(2 * count + 2);
    if (rows <= rows_.size()) return;
    const std::vector<std::uint32_t> old = std::exchange(rows_, std::vector<std::uint32_t>(rows, kAbsent));
    for (const std::uint32_t index : old) {
        if (index != kAbsent) place(index, ids);
    }
}

void IdTable::shift(std::uint32_t by) {
    for (std::uint32_t& row : rows_)
        if (row != kAbsent) row += by;
}

void IdTable::place(std::uint32_t index, std::span<const std::uint64_t> ids) {
    const std::size_t mask = rows_.size() - 1;
    std::size_t at = mix64(ids[index]) & mask;
    while (rows_[at] != kAbsent) at = (at + 1) & mask;
    rows_[at] = index;
}

}  // namespace meld::world
