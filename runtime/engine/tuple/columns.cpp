#include "runtime/engine/tuple/columns.h"

#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/large_array.h"
#include "runtime/base/process/deep_stack.h"
#include "runtime/engine/tuple/arrived_rows.h"

namespace meld::tuple {

namespace {

// Catoms whose entries a worker makes at once: more than a page of each column.
constexpr std::size_t kMadeAtOnce = std::size_t{1} << 15;
// Bytes; they stay in the first cache.
constexpr std::size_t kCopiedAtOnce = 8192;

const List* list_at(const u8* place) {
    const List* list = nullptr;
    std::memcpy(&list, place, sizeof list);
    return list;
}

// Puts with(type, list) in the place of each list of rows or of a record.
template <class With>
void replace_lists(const ModuleInfo& module, u32 column, u8* rows, u32 count, const With& with) {
    const ColumnInfo& info = module.columns[column];
    if (info.list_count == 0) return;
    for (u32 r = 0; r < count; ++r, rows += info.row_bytes)
        for (u32 i = 0; i < info.list_count; ++i) {
            u8* const place = rows + info.list_offsets[i];
            const List* const list = with(Type(module.types, info.list_types[i]), list_at(place));
            std::memcpy(place, &list, sizeof list);
        }
}

}  // namespace

// The block's class must depend only on that number.
u32 Columns::block_capacity(std::size_t bytes, std::size_t row_bytes) {
    const std::size_t rows = RowPool::capacity(bytes) / row_bytes;
    return static_cast<u32>(RowPool::capacity(rows * row_bytes) == RowPool::capacity(bytes) ? rows : bytes / row_bytes);
}

Columns::Columns(const ModuleInfo& module, int pools)
    : module_(module),
      pointers_(module.column_count, nullptr),
      pools_(static_cast<std::size_t>(pools)),
      lists_(pools),
      dropped_(static_cast<std::size_t>(pools)),
      changes_(module, pools),
      arrived_(std::make_unique<ArrivedRows>(module, *this)) {}

Columns::~Columns() {
    for (u32 c = 0; c < module_.column_count; ++c) {
        const ColumnInfo& info = module_.columns[c];
        for (u32 catom = 0; info.list_count > 0 && catom < count_; ++catom)
            if (info.rows)
                drop_lists(c, rows(c, catom).data, rows(c, catom).count, 0);
            else
                drop_lists(c, entry(c, catom), 1, 0);
    }
    for (std::size_t pool = 0; pool < dropped_.size(); ++pool) release_dropped(static_cast<int>(pool));
    for (u8* p : pointers_) std::free(p);
}

template <class Visit>
void Columns::each_list(u32 column, const u8* rows, u32 count, const Visit& visit) const {
    const ColumnInfo& info = module_.columns[column];
    for (u32 r = 0; r < count; ++r, rows += info.row_bytes)
        for (u32 i = 0; i < info.list_count; ++i) visit(list_at(rows + info.list_offsets[i]), info.list_types[i]);
}

void Columns::keep_lists(u32 column, u8* rows, u32 count, int pool) {
    replace_lists(module_, column, rows, count, [&](Type type, const List* list) { return lists_.keep(type, list, pool); });
}

void Columns::share_lists(u32 column, const u8* rows, u32 count) {
    each_list(column, rows, count, [&](const List* list, u16) {
        if (list != nullptr && list->stored != 0) lists_.share(list);
    });
}

void Columns::take_over_lists(u32 column, u8* rows, u32 count, int pool) {
    replace_lists(module_, column, rows, count,
                  [&](Type type, const List* list) { return list == nullptr || list->stored != 0 ? list : lists_.keep(type, list, pool); });
}

void Columns::drop_lists(u32 column, const u8* rows, u32 count, int pool) {
    if (module_.columns[column].list_count == 0) return;
    std::vector<const List*>& dropped = dropped_[static_cast<std::size_t>(pool)];
    each_list(column, rows, count, [&](const List* list, u16) {
        if (list != nullptr && list->stored != 0) dropped.push_back(list);
    });
}

void Columns::release_dropped(int pool) {
    std::vector<const List*>& dropped = dropped_[static_cast<std::size_t>(pool)];
    for (const List* list : dropped) lists_.release(list, pool);
    dropped.clear();
}

void Columns::resize(std::size_t catoms, Workers* workers) {
    if (catoms > capacity_) {
        // The first size is exact, later ones leave room: worlds are usually made at once.
        const std::size_t room = capacity_ == 0 ? catoms : std::max(catoms, capacity_ + capacity_ / 4 + 64);
        for (u32 c = 0; c < module_.column_count; ++c) {
            const std::size_t bytes = std::max<std::size_t>(1, room * module_.columns[c].stride);
            void* const bigger = std::realloc(pointers_[c], bytes);
            if (bigger == nullptr) memory_has_run_out();
            ask_for_large_pages(bigger, bytes);
            pointers_[c] = static_cast<u8*>(bigger);
        }
        capacity_ = room;
    }
    if (workers != nullptr && catoms > count_ + kMadeAtOnce) {
        workers->run((catoms - count_ + kMadeAtOnce - 1) / kMadeAtOnce, [&](int, std::size_t part) {
            const std::size_t from = count_ + part * kMadeAtOnce;
            for (u32 c = 0; c < module_.column_count; ++c) initialise(c, from, std::min(catoms, from + kMadeAtOnce));
        });
    } else {
        for (u32 c = 0; c < module_.column_count; ++c) initialise(c, count_, catoms);
    }
    count_ = std::max(count_, catoms);
    changes_.resize(count_);
}

void Columns::initialise(u32 column, std::size_t from, std::size_t to) {
    if (from >= to) return;
    const ColumnInfo& info = module_.columns[column];
    u8* at = pointers_[column] + from * info.stride;
    if (info.initial == nullptr) {
        std::memset(at, 0, (to - from) * info.stride);
        return;
    }
    // The first ones again and again, by copies of some kilobytes, not one call for each.
    std::size_t made = info.stride;
    const std::size_t all = (to - from) * info.stride, most = std::max<std::size_t>(1, kCopiedAtOnce / info.stride) * info.stride;
    std::memcpy(at, info.initial, info.stride);
    for (std::size_t more = 0; made < all; made += more) {
        more = std::min({made, most, all - made});
        std::memcpy(at + made, at, more);
    }
}

void Columns::set_record(u32 column, u32 catom, const void* record, int pool, Lists lists) {
    MELD_EXPECT(!module_.columns[column].rows && record != nullptr, "column {}", column);
    u8* to = entry(column, catom);
    drop_lists(column, to, 1, pool);
    std::memcpy(to, record, module_.columns[column].stride);
    if (lists == Lists::Keep) keep_lists(column, to, 1, pool);
}

void Columns::set_rows(u32 column, u32 catom, const void* rows, u32 count, int pool, Lists lists) {
    MELD_EXPECT(module_.columns[column].rows && (rows != nullptr || count == 0), "column {}", column);
    const ColumnInfo& info = module_.columns[column];
    RowsHead& head = *reinterpret_cast<RowsHead*>(entry(column, catom));
    if (info.list_count > 0 && (head.capacity > 0 || arrived_->owns_lists(static_cast<u16>(column))))
        drop_lists(column, head.data, head.count, pool);
    RowPool& mine = pools_[static_cast<std::size_t>(pool)];
    const std::size_t bytes = std::size_t{count} * info.row_bytes;
    u8* old = head.data;
    const std::size_t old_bytes = std::size_t{head.capacity} * info.row_bytes;
    if (RowPool::fits(head.capacity, count, info.row_bytes)) {
        std::memmove(old, rows, bytes);
    } else {
        u8* block = nullptr;
        if (count > 0) {
            block = mine.take(bytes);
            std::memcpy(block, rows, bytes);
        }
        if (head.capacity > 0) mine.give(old, old_bytes);
        head.data = block;
        head.capacity = count > 0 ? block_capacity(bytes, info.row_bytes) : 0;
    }
    head.count = count;
    MELD_ENSURE(head.count <= head.capacity && (head.data != nullptr || count == 0), "{} rows, room for {}", count, head.capacity);
    if (lists == Lists::Keep) keep_lists(column, head.data, count, pool);
}

void Columns::lie_at(u32 column, u32 catom, u8* rows, u32 count, int pool) {
    RowsHead& head = *reinterpret_cast<RowsHead*>(entry(column, catom));
    MELD_EXPECT(count > 0 && !changes_.follows(column), "column {} of catom {}, {} rows", column, catom, count);
    if (head.capacity > 0)
        pools_[static_cast<std::size_t>(pool)].give(head.data, std::size_t{head.capacity} * module_.columns[column].row_bytes);
    head = {count, 0, rows};
}

void Columns::insert_row(u32 column, u32 catom, u32 at, const void* row, int pool) {
    const std::size_t size = module_.columns[column].row_bytes;
    RowsHead& head = *reinterpret_cast<RowsHead*>(entry(column, catom));
    MELD_EXPECT(at <= head.count, "row {} of {}", at, head.count);
    const std::size_t before = at * size, behind = (head.count - at) * size;
    if (head.count >= head.capacity) {
        RowPool& mine = pools_[static_cast<std::size_t>(pool)];
        const std::size_t bytes = (std::size_t{head.count} + 1) * size;
        u8* block = mine.take(bytes);
        if (head.data != nullptr) {
            std::memcpy(block, head.data, before + behind);
            if (head.capacity > 0)
                mine.give(head.data, head.capacity * size);
            else
                take_over_lists(column, block, head.count, pool);
        }
        head.data = block;
        head.capacity = block_capacity(bytes, size);
    }
    std::memmove(head.data + before + size, head.data + before, behind);
    std::memcpy(head.data + before, row, size);
    ++head.count;
    keep_lists(column, head.data + before, 1, pool);
}

void Columns::clear(u32 catom, int pool) {
    changes_.forget(catom);
    for (u32 c = 0; c < module_.column_count; ++c) {
        if (module_.columns[c].rows)
            set_rows(c, catom, nullptr, 0, pool);
        else
            drop_lists(c, entry(c, catom), 1, pool);
        initialise(c, catom, std::size_t{catom} + 1);
    }
    release_dropped(pool);
}

void Columns::copy(u32 column, u32 from, u32 to, int pool) {
    if (!module_.columns[column].rows) return set_record(column, to, entry(column, from), pool);
    const RowsHead& head = rows(column, from);
    set_rows(column, to, head.data, head.count, pool);
}

bool Columns::same(u32 column, u32 a, u32 b) const {
    const ColumnInfo& info = module_.columns[column];
    if (info.list_count > 0) {
        ByteWriter of_a, of_b;
        pack_column(column, a, of_a), pack_column(column, b, of_b);
        return std::ranges::equal(of_a.view(), of_b.view());
    }
    if (!info.rows) return std::memcmp(entry(column, a), entry(column, b), info.stride) == 0;
    const RowsHead &of_a = rows(column, a), &of_b = rows(column, b);
    const std::size_t bytes = std::size_t{of_a.count} * info.row_bytes;
    return of_a.count == of_b.count && (bytes == 0 || std::memcmp(of_a.data, of_b.data, bytes) == 0);
}

// The bytes, followed by the lists to which words in them point; those words are not sent.
void Columns::pack_column(u32 column, u32 catom, ByteWriter& out) const {
    const ColumnInfo& info = module_.columns[column];
    const u8* from = entry(column, catom);
    u32 count = 1;
    std::size_t bytes = info.stride;
    if (info.rows) {
        count = rows(column, catom).count;
        from = rows(column, catom).data;
        bytes = std::size_t{count} * info.row_bytes;
        out.write(count);
    }
    const std::size_t start = out.size();
    out.write_bytes(from, bytes);
    if (info.list_count == 0) return;
    std::byte* const written = out.written_from(start).data();
    for (u32 r = 0; r < count; ++r)
        for (u32 i = 0; i < info.list_count; ++i)
            std::memset(written + r * std::size_t{info.row_bytes} + info.list_offsets[i], 0, sizeof(const List*));
    each_list(column, from, count, [&](const List* list, u16 type) { tuple::pack({module_.types, type}, Value{.list = list}, out); });
}

void Columns::unpack_column(u32 column, u32 catom, ByteReader& in, int pool, Unpacking& room) {
    const ColumnInfo& info = module_.columns[column];
    const u32 count = info.rows ? in.read_count(info.row_bytes) : 1;
    const std::span<const std::byte> raw = in.read_bytes(info.rows ? std::size_t{count} * info.row_bytes : info.stride);
    if (info.list_count == 0) {
        if (info.rows)
            replace_rows(column, catom, raw.data(), count, pool);
        else
            set_record(column, catom, raw.data(), pool);
        return;
    }
    const auto* from = reinterpret_cast<const u8*>(raw.data());
    std::vector<u8>& rows = room.rows;
    rows.assign(from, from + raw.size());
    room.lists.clear();
    for (u32 r = 0; r < count; ++r)
        for (u32 i = 0; i < info.list_count; ++i) {
            const Value v = tuple::unpack({module_.types, info.list_types[i]}, in, room.lists);
            std::memcpy(rows.data() + r * std::size_t{info.row_bytes} + info.list_offsets[i], &v, sizeof v);
        }
    if (info.rows)
        set_rows(column, catom, rows.data(), count, pool);
    else
        set_record(column, catom, rows.data(), pool);
    release_dropped(pool);
}

void Columns::pack(u32 catom, Which which, ByteWriter& out) const {
    for (u32 c = 0; c < module_.column_count; ++c)
        if (which == Which::All || module_.columns[c].exported) pack_column(c, catom, out);
}

void Columns::unpack(u32 catom, Which which, ByteReader& in, int pool) {
    for (u32 c = 0; c < module_.column_count; ++c)
        if (which == Which::All || module_.columns[c].exported) unpack_column(c, catom, in, pool);
}

std::size_t Columns::bytes() const {
    std::size_t total = 0;
    for (u32 c = 0; c < module_.column_count; ++c) total += capacity_ * module_.columns[c].stride;
    for (const RowPool& pool : pools_) total += pool.bytes_reserved();
    return total + lists_.bytes() + changes_.bytes() + arrived_->bytes();
}

std::size_t Columns::bytes_for(const ModuleInfo& module, std::size_t catoms) {
    std::size_t each = 0;
    for (u32 c = 0; c < module.column_count; ++c)
        each += module.columns[c].stride + (module.columns[c].compare_groups != nullptr ? sizeof(RowChanges*) : 0);
    return catoms * each;
}

}  // namespace meld::tuple
