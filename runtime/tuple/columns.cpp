#include "runtime/tuple/columns.h"

#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"

namespace meld::tuple {

namespace {

template <class T>
void put(std::vector<std::byte>& out, const T& value) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof(T));
}

}  // namespace

Columns::Columns(const ModuleInfo& module, int pools) : module_(module), pointers_(module.column_count, nullptr), pools_(static_cast<std::size_t>(pools)) {}

Columns::~Columns() {
    for (u8* p : pointers_) std::free(p);
}

void Columns::resize(std::size_t catoms) {
    if (catoms > capacity_) {
        // The first size is exact, later ones leave room: worlds are mostly made at once.
        const std::size_t room = capacity_ == 0 ? catoms : std::max(catoms, capacity_ + capacity_ / 4 + 64);
        for (u32 c = 0; c < module_.column_count; ++c) {
            void* bigger = std::realloc(pointers_[c], std::max<std::size_t>(1, room * module_.columns[c].stride));
            MELD_CHECK(bigger != nullptr, "no memory for column {} of {} catoms", module_.columns[c].name, room);
            pointers_[c] = static_cast<u8*>(bigger);
        }
        capacity_ = room;
    }
    for (u32 c = 0; c < module_.column_count; ++c) initialise(c, count_, catoms);
    count_ = std::max(count_, catoms);
}

void Columns::initialise(u32 column, std::size_t from, std::size_t to) {
    if (from >= to) return;
    const ColumnInfo& info = module_.columns[column];
    u8* at = pointers_[column] + from * info.stride;
    if (info.initial == nullptr) {
        std::memset(at, 0, (to - from) * info.stride);
        return;
    }
    for (std::size_t i = from; i < to; ++i, at += info.stride) std::memcpy(at, info.initial, info.stride);
}

void Columns::set_rows(u32 column, u32 catom, const void* rows, u32 count, int pool) {
    const ColumnInfo& info = module_.columns[column];
    RowsHead& head = *reinterpret_cast<RowsHead*>(entry(column, catom));
    RowPool& mine = pools_[static_cast<std::size_t>(pool)];
    const std::size_t bytes = std::size_t{count} * info.row_bytes;
    u8* old = head.data;
    const std::size_t old_bytes = std::size_t{head.capacity} * info.row_bytes;
    // Shrinking to a quarter gives memory back; anything between stays where it is.
    const bool fits = old != nullptr && bytes <= old_bytes && (bytes * 4 >= old_bytes || old_bytes <= 64);
    if (count > 0 && fits) {
        std::memmove(old, rows, bytes);
    } else {
        u8* block = nullptr;
        if (count > 0) {
            block = mine.take(bytes);
            std::memcpy(block, rows, bytes);
        }
        if (old != nullptr) mine.give(old, old_bytes);
        head.data = block;
        head.capacity = count > 0 ? static_cast<u32>(RowPool::capacity(bytes) / info.row_bytes) : 0;
        // The block's class must follow from the capacity alone.
        if (count > 0 && RowPool::capacity(std::size_t{head.capacity} * info.row_bytes) != RowPool::capacity(bytes)) head.capacity = count;
    }
    head.count = count;
}

void Columns::clear(u32 catom, int pool) {
    for (u32 c = 0; c < module_.column_count; ++c) {
        if (module_.columns[c].rows) set_rows(c, catom, nullptr, 0, pool);
        initialise(c, catom, std::size_t{catom} + 1);
    }
}

void Columns::pack_column(u32 column, u32 catom, std::vector<std::byte>& out) const {
    const ColumnInfo& info = module_.columns[column];
    if (!info.rows) {
        const auto* bytes = reinterpret_cast<const std::byte*>(entry(column, catom));
        out.insert(out.end(), bytes, bytes + info.stride);
        return;
    }
    const RowsHead& head = rows(column, catom);
    put(out, head.count);
    const auto* bytes = reinterpret_cast<const std::byte*>(head.data);
    if (head.count > 0) out.insert(out.end(), bytes, bytes + std::size_t{head.count} * info.row_bytes);
}

const std::byte* Columns::unpack_column(u32 column, u32 catom, const std::byte* from, int pool) {
    const ColumnInfo& info = module_.columns[column];
    if (!info.rows) {
        std::memcpy(entry(column, catom), from, info.stride);
        return from + info.stride;
    }
    u32 count = 0;
    std::memcpy(&count, from, sizeof count);
    from += sizeof count;
    set_rows(column, catom, from, count, pool);
    return from + std::size_t{count} * info.row_bytes;
}

void Columns::pack(u32 catom, Which which, std::vector<std::byte>& out) const {
    for (u32 c = 0; c < module_.column_count; ++c)
        if (which == Which::All || module_.columns[c].exported) pack_column(c, catom, out);
}

const std::byte* Columns::unpack(u32 catom, Which which, const std::byte* from, int pool) {
    for (u32 c = 0; c < module_.column_count; ++c)
        if (which == Which::All || module_.columns[c].exported) from = unpack_column(c, catom, from, pool);
    return from;
}

std::size_t Columns::bytes() const {
    std::size_t total = 0;
    for (u32 c = 0; c < module_.column_count; ++c) total += capacity_ * module_.columns[c].stride;
    for (const RowPool& pool : pools_) total += pool.bytes_reserved();
    return total;
}

}  // namespace meld::tuple
