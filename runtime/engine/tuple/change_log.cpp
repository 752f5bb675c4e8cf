#include "runtime/engine/tuple/change_log.h"

#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"

namespace meld::tuple {

namespace {

// Room for the changes of some hundred catoms; a busy tick takes more chunks and keeps the largest.
constexpr std::size_t kChunkWords = 1 << 12;

}  // namespace

u64* ChangeLog::Arena::take(std::size_t words) {
    if (left < words) {
        const std::size_t size = std::max(words, chunks.empty() ? kChunkWords : 2 * (next + left));
        chunks.push_back(std::make_unique_for_overwrite<u64[]>(size));
        next = 0;
        left = size;
    }
    u64* out = chunks.back().get() + next;
    next += words;
    left -= words;
    return out;
}

void ChangeLog::Arena::reset() {
    if (chunks.size() > 1) chunks.erase(chunks.begin(), chunks.end() - 1);
    left += next;
    next = 0;
}

ChangeLog::ChangeLog(const ModuleInfo& module, int pools)
    : module_(module), noted_(module.column_count), pointers_(module.column_count, nullptr), pools_(static_cast<std::size_t>(pools)) {}

void ChangeLog::resize(std::size_t catoms) {
    for (u32 c = 0; c < module_.column_count; ++c) {
        if (!follows(c)) continue;
        if (catoms > noted_[c].size()) noted_[c].resize(catoms, nullptr);
        pointers_[c] = noted_[c].data();
    }
}

RowChanges* ChangeLog::make(u32 column, u32 removed, u32 added, int pool) {
    MELD_EXPECT(pool >= 0 && static_cast<std::size_t>(pool) < pools_.size(), "pool {}", pool);
    const std::size_t bytes = sizeof(RowChanges) + std::size_t{module_.columns[column].row_bytes} * (std::size_t{removed} + added);
    auto* out = reinterpret_cast<RowChanges*>(pools_[static_cast<std::size_t>(pool)].arenas[filling_].take((bytes + 7) / 8));
    *out = {nullptr, removed, added, 0, 0};
    return out;
}

void ChangeLog::note(u32 column, u32 catom, RowChanges* changes, int pool) {
    MELD_EXPECT(follows(column) && catom < noted_[column].size(), "column {} of catom {}", column, catom);
    const RowChanges*& first = noted_[column][catom];
    if (first == nullptr) pools_[static_cast<std::size_t>(pool)].noted.push_back({column, catom});
    changes->next = first;
    first = changes;
}

void ChangeLog::forget(u32 catom) {
    for (auto& column : noted_)
        if (!column.empty()) column[catom] = nullptr;
}

void ChangeLog::save(u32 column, std::span<const u32> catoms, ByteWriter& out) const {
    ByteWriter noted;
    u32 count = 0;
    std::vector<const RowChanges*> chain;
    for (u32 i = 0; i < catoms.size(); ++i) {
        chain.clear();
        for (const RowChanges* c = of(column, catoms[i]); c != nullptr; c = c->next) chain.push_back(c);
        for (; !chain.empty(); chain.pop_back(), ++count) {
            const RowChanges& c = *chain.back();
            for (const u32 number : {i, c.removed, c.added, c.woken}) noted.write(number);
            noted.write_bytes(&c + 1, module_.columns[column].row_bytes * (std::size_t{c.removed} + c.added + c.woken));
        }
    }
    out.write(count);
    out.write_bytes(noted.view().data(), noted.size());
}

void ChangeLog::load(u32 column, std::span<const SavedCatom> catoms, ByteReader& in) {
    const std::size_t row_bytes = module_.columns[column].row_bytes;
    for (u32 count = in.read_count(4 * sizeof(u32)); count > 0; --count) {
        const auto at = in.read<u32>(), removed = in.read<u32>(), added = in.read<u32>(), woken = in.read<u32>();
        const std::span<const std::byte> rows = in.read_bytes(row_bytes * (std::size_t{removed} + added + woken));
        if (in.failed() || at >= catoms.size()) return;
        const SavedCatom& to = catoms[at];
        const u32 kept = to.owned ? woken : 0;
        if (!to.here() || removed + added + kept == 0) continue;
        RowChanges* changes = make(column, removed, added + kept, 0);
        changes->added = added;
        changes->woken = kept;
        std::memcpy(changes + 1, rows.data(), row_bytes * (std::size_t{removed} + added + kept));
        note(column, to.catom, changes, 0);
    }
}

void ChangeLog::end_evaluation(const std::function<bool(u32)>& waits) {
    struct Kept {
        Place place;
        RowChanges* changes;
    };
    for (std::size_t number = 0; number < pools_.size(); ++number) {
        Pool& pool = pools_[number];
        std::vector<Kept> kept;
        for (const Place& p : pool.noted) {
            const RowChanges* changes = noted_[p.column][p.catom];
            noted_[p.column][p.catom] = nullptr;
            if (!waits || !waits(p.catom)) continue;
            const auto first = static_cast<std::ptrdiff_t>(kept.size());
            for (; changes != nullptr; changes = changes->next) kept.push_back({p, copy(p.column, *changes, static_cast<int>(number))});
            std::reverse(kept.begin() + first, kept.end());  // The oldest first.
        }
        pool.noted.clear();
        pool.arenas[1 - filling_].reset();
        for (const Kept& k : kept) note(k.place.column, k.place.catom, k.changes, static_cast<int>(number));
    }
}

RowChanges* ChangeLog::copy(u32 column, const RowChanges& changes, int pool) {
    const u32 rows = changes.removed + changes.added + changes.woken;
    RowChanges* out = make(column, rows, 0, pool);
    std::memcpy(out + 1, &changes + 1, std::size_t{module_.columns[column].row_bytes} * rows);
    out->removed = changes.removed;
    out->added = changes.added;
    out->woken = changes.woken;
    return out;
}

std::size_t ChangeLog::bytes() const {
    std::size_t total = 0;
    for (const auto& column : noted_) total += column.capacity() * sizeof(column[0]);
    for (const Pool& pool : pools_)
        for (const Arena& arena : pool.arenas) total += (arena.next + arena.left) * sizeof(u64);
    return total;
}

}  // namespace meld::tuple
