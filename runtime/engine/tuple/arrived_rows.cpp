#include "runtime/engine/tuple/arrived_rows.h"

#include <algorithm>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/columns.h"
#include "runtime/engine/tuple/field.h"

namespace meld::tuple {

namespace {

// The number of rows up to which a module sorts them by insertion.
constexpr u32 kFew = 16;
// Receivers that a worker takes at a time.
constexpr std::size_t kReceivers = 1024;

}  // namespace

void ArrivedRows::open(u16 column, bool shares) {
    MELD_EXPECT(module_.columns[column].arrange != nullptr && receivers_.empty(), "column {}", column);
    column_ = column;
    filling_.owns_lists = shares;
    row_bytes_ = module_.columns[column].row_bytes;
    // A program that sends nothing needs no counts.
    if (counts_.size() < columns_.count()) counts_.resize(columns_.count(), 0);
}

RowsHead* ArrivedRows::heads(u16 column) const { return reinterpret_cast<RowsHead*>(columns_.pointers()[column]); }

void ArrivedRows::make_room() {
    starts_.resize(receivers_.size() + 1);
    const RowsHead* const heads = this->heads(column_);
    std::size_t total = 0;
    for (std::size_t i = 0; i < receivers_.size(); ++i) {
        const u32 catom = receivers_[i], held = heads[catom].count, come = counts_[catom];
        starts_[i] = static_cast<u32>(total);
        counts_[catom] = static_cast<u32>(total) + held;
        total += std::size_t{held} + come;
        if (total >= kNone32) break;
    }
    MELD_CHECK(total < kNone32, "{} facts of column {} for one process", total, column_);
    starts_.back() = static_cast<u32>(total);
    if (filling_.size < total * row_bytes_) {
        filling_.size = total * row_bytes_ + total * row_bytes_ / 4;
        filling_.bytes = std::make_unique_for_overwrite<u8[]>(filling_.size);
    }
}

void ArrivedRows::end(Workers& workers) {
    workers_.resize(std::max(workers_.size(), static_cast<std::size_t>(workers.threads())));
    const std::size_t blocks = (receivers_.size() + kReceivers - 1) / kReceivers;
    workers.run(blocks, [&](int worker, std::size_t block) {
        RowsHead* const heads = this->heads(column_);
        const auto arrange = module_.columns[column_].arrange;
        const std::size_t to = std::min(receivers_.size(), (block + 1) * kReceivers);
        for (std::size_t i = block * kReceivers; i < to; ++i) {
            RowsHead& head = heads[receivers_[i]];
            const u32 count = starts_[i + 1] - starts_[i];
            if (head.count != 0 || head.capacity != 0 || count > kFew) {
                leave(i, worker);
                continue;
            }
            // Mostly, so here: a few rows for a catom that holds none.
            MELD_ASSERT(counts_[receivers_[i]] == starts_[i + 1], "catom {} got {} rows more than were counted", receivers_[i],
                        i64{counts_[receivers_[i]]} - i64{starts_[i + 1]});
            counts_[receivers_[i]] = 0;
            u8* const rows = filling_.bytes.get() + std::size_t{starts_[i]} * row_bytes_;
            if (count > 1) arrange(rows, nullptr, 0, count);
            head = {count, 0, rows};
        }
    });
    for (Worker& worker : workers_) filling_.owns_lists |= std::exchange(worker.owns_lists, false);
    move_what_is_left(column_);
    filling_.receivers.swap(receivers_);
    std::swap(blocks_[column_], filling_);
    quiet_ticks_ = 0;
}

// Its block will be filled again, or freed.
void ArrivedRows::move_what_is_left(u16 column) {
    Block& block = blocks_[column];
    const RowsHead* const heads = this->heads(column);
    const u8 *const begin = block.bytes.get(), *const end = begin + block.size;
    for (const u32 catom : block.receivers) {
        const RowsHead& head = heads[catom];
        if (head.capacity == 0 && head.data >= begin && head.data < end) columns_.set_rows(column, catom, head.data, head.count, 0);
    }
    columns_.release_dropped(0);
    block.receivers.clear();
}

void ArrivedRows::rest() {
    if (++quiet_ticks_ != 2) return;
    for (std::size_t column = 0; column < blocks_.size(); ++column) {
        move_what_is_left(static_cast<u16>(column));
        blocks_[column] = {};
    }
    filling_ = {};
    counts_ = std::vector<u32>(), receivers_ = std::vector<u32>(), starts_ = std::vector<u32>();
    workers_.clear();
}

// The lists of rows that the catom holds already come along; those of an earlier delivery end.
void ArrivedRows::leave(std::size_t receiver, int pool) {
    const ColumnInfo& column = module_.columns[column_];
    const u32 catom = receivers_[receiver], count = starts_[receiver + 1] - starts_[receiver];
    RowsHead& head = heads(column_)[catom];
    MELD_ASSERT(counts_[catom] == starts_[receiver + 1], "catom {} got {} rows more than were counted", catom,
                i64{counts_[catom]} - i64{starts_[receiver + 1]});
    counts_[catom] = 0;
    u8* const rows = filling_.bytes.get() + std::size_t{starts_[receiver]} * row_bytes_;
    Worker& worker = workers_[static_cast<std::size_t>(pool)];
    const bool many = count - head.count > kFew;
    if (many) sort_many(rows + std::size_t{head.count} * row_bytes_, count - head.count, worker);
    if (head.count > 0 && column.list_count > 0) {
        if (head.capacity == 0) columns_.take_over_lists(column_, head.data, head.count, pool);
        worker.owns_lists = true;
    }
    if (!many || head.count > 0) column.arrange(rows, head.data, head.count, count - head.count);
    columns_.lie_at(column_, catom, rows, count, pool);
}

// A word of the first field decides most comparisons; rows with the same word are often in order already, because their sender went through
// its own facts in order.
void ArrivedRows::sort_many(u8* rows, u32 count, Worker& room) const {
    const ColumnInfo& column = module_.columns[column_];
    const PredicateInfo& p = *std::find_if(module_.predicates, module_.predicates + module_.predicate_count,
                                           [&](const PredicateInfo& one) { return one.column == column_; });
    // The runtime compares lists of ints by words, the module one element after the other.
    const auto less = [&](const Prefixed& a, const Prefixed& b) {
        if (column.list_count == 0) return column.compare_rows(a.row, b.row) < 0;
        for (u32 i = 0; i < p.arity; ++i)
            if (const int c = compare(type_of(module_, p.fields[i]), load_field(p.fields[i], a.row), load_field(p.fields[i], b.row)))
                return c < 0;
        return false;
    };
    room.unsorted.assign(rows, rows + std::size_t{count} * row_bytes_);
    std::vector<Prefixed>& order = room.order;
    order.clear();
    for (u32 i = 0; i < count; ++i) {
        const u8* const row = room.unsorted.data() + std::size_t{i} * row_bytes_;
        order.push_back({p.arity == 0 ? 0 : order_prefix(type_of(module_, p.fields[0]), load_field(p.fields[0], row)), row});
    }
    std::stable_sort(order.begin(), order.end(), [](const Prefixed& a, const Prefixed& b) { return a.prefix < b.prefix; });
    for (auto from = order.begin(); from != order.end();) {
        const auto to = std::find_if(from, order.end(), [&](const Prefixed& one) { return one.prefix != from->prefix; });
        if (!std::is_sorted(from, to, less)) std::stable_sort(from, to, less);
        from = to;
    }
    for (u32 i = 0; i < count; ++i) std::memcpy(rows + std::size_t{i} * row_bytes_, order[i].row, row_bytes_);
}

std::size_t ArrivedRows::bytes() const {
    std::size_t total = counts_.capacity() * sizeof(u32);
    const auto add = [&](const Block& block) {
        total += block.size + block.receivers.capacity() * sizeof(u32);
        for (const Arena& arena : block.lists) total += arena.bytes();
    };
    add(filling_);
    for (const Block& block : blocks_) add(block);
    for (const Worker& one : workers_) total += one.unsorted.capacity() + one.order.capacity() * sizeof(Prefixed);
    return total;
}

}  // namespace meld::tuple
