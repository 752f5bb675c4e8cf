// Marks the neighbours whom a change of a record concerns, for columns that say so (ColumnInfo::concerned). All records of the tick are
// visible by then: a catom is compared with what it holds when it would be evaluated.
#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/eval/worker.h"

namespace meld::eval {

void Evaluator::mark_concerned(const Geometry& g, Thread& t) {
    // Nodes that change together are anywhere in memory, so what is read of the next ones is asked for in time.
    constexpr std::size_t kRows = 8, kRow = 4, kNeighbours = 2;
    const auto ahead = [&](std::size_t i) -> const PendingRecord* {
        return i < t.records.size() && asks_concerned(t.records[i].column) ? &t.records[i] : nullptr;
    };
    for (std::size_t i = 0; i < t.records.size(); ++i) {
        if (const PendingRecord* r = ahead(i + kRows)) {
            __builtin_prefetch(g.link_first + r->catom);
            __builtin_prefetch(g.link_ports + r->catom);
        }
        if (const PendingRecord* r = ahead(i + kRow)) __builtin_prefetch(g.link_catom + g.link_first[r->catom]);
        if (const PendingRecord* r = ahead(i + kNeighbours))
            each_link(g, r->catom, [&](i32, u32 other) { __builtin_prefetch(columns_.entry(r->column, other)); });
        if (const PendingRecord* r = ahead(i)) mark_concerned(g, t, r->catom, r->column, r->record);
    }
}

void Evaluator::mark_concerned(const Geometry& g, Thread& t, u32 catom, u16 column, const u8* before) {
    MELD_EXPECT(asks_concerned(column) && g.link_first != nullptr, "column {} of catom {}", column, catom);
    const ColumnInfo& info = module_.columns[column];
    const i32* const row = g.link_catom + g.link_first[catom];
    const u32 ports = g.link_ports[catom];
    if (t.concerned.size() < ports) t.concerned.resize(std::max(ports, g.most_ports));
    const u32 count = info.concerned(&t, before, columns_.entry(column, catom), row, ports, t.concerned.data());
    const bool shared = threads_.size() > 1;
    for (u32 i = 0; i < count; ++i)
        if (shared)
            agenda().mark_shared(t.concerned[i], info.reader_dirty);
        else
            agenda().mark(t.concerned[i], info.reader_dirty);
    if (!t.passed_over && count < ports)
        t.passed_over = std::count_if(row, row + ports, [](i32 other) { return other >= 0; }) > std::ptrdiff_t{count};
}

void Evaluator::mark_concerned(const Geometry& geometry, u32 catom, u16 column, const u8* before) {
    mark_concerned(geometry, *threads_[0], catom, column, before);
}

}  // namespace meld::eval
