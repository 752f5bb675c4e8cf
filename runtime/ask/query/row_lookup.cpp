#include "runtime/ask/query/row_lookup.h"

#include <bit>

#include "runtime/base/hash.h"
#include "runtime/engine/tuple/field.h"

namespace meld::inspect {

namespace {

constexpr u32 kLookupAfterScans = 2;
// Some 12 bytes each.
constexpr std::size_t kMostLookupRows = 8'000'000;

}  // namespace

u64 RowLookup::hash(std::span<const i64> key) {
    u64 h = 0;
    for (const i64 value : key) h = hash_combine(h, static_cast<u64>(value));
    return h;
}

void RowLookup::build(const RowsHead& table, std::size_t row_bytes, std::span<const Instruction::Field> key) {
    first_.assign(std::bit_ceil(std::size_t{table.count} + 1), kNone32);
    next_.resize(table.count);
    std::vector<i64> values(key.size());
    for (u32 row = table.count; row-- > 0;) {
        for (std::size_t i = 0; i < key.size(); ++i) values[i] = tuple::load_field(*key[i].info, table.data + row * row_bytes).integer;
        u32& chain = first_[hash(values) & (first_.size() - 1)];
        next_[row] = chain;
        chain = row;
    }
}

const RowLookup* RowLookups::at(u32 catom, const RowsHead& table, std::size_t row_bytes, std::span<const Instruction::Field> key) {
    Table& known = tables_[catom];
    if (known.lookup.is_built()) return &known.lookup;
    if (known.scans < kLookupAfterScans || rows_ >= kMostLookupRows) {
        ++known.scans;
        return nullptr;
    }
    known.lookup.build(table, row_bytes, key);
    rows_ += table.count;
    return &known.lookup;
}

void RowLookups::clear() {
    tables_.clear();
    rows_ = 0;
}

}  // namespace meld::inspect
