// Marks the neighbours whom a change of a record concerns, for columns that say so (ColumnInfo::concerned). All records of the tick are
// visible by then: a catom is compared with what it holds when it would be evaluated. Where neighbours are read apart, this is asked when
// a reader begins to read something else.
#include <algorithm>
#include <array>
#include <span>
#include <type_traits>

#include "runtime/base/assert.h"
#include "runtime/engine/eval/worker.h"

namespace meld::eval {

namespace {

// The neighbours of a catom by port, -1 for none; in the lattice form they are looked up into `room`.
template <bool kLinks>
std::span<const i32> neighbours_of(const Geometry& g, u32 catom, std::array<i32, kMaxPorts>& room) {
    if (kLinks) return {g.link_catom + g.link_first[catom], g.link_ports[catom]};
    const u32 site = g.catom_site[catom];
    const auto ports = static_cast<std::size_t>(g.ports);
    for (std::size_t port = 0; port < ports; ++port) room[port] = catom_towards(g, site, static_cast<i32>(port));
    return {room.data(), ports};
}

}  // namespace

void Evaluator::mark_concerned(const Geometry& g, Thread& t) {
    // Catoms that change together may be anywhere in memory, so what is read of the next ones is asked for in time.
    constexpr std::size_t kFirst = 8, kSecond = 4, kNeighbours = 2, kRooms = 4;
    static_assert(kRooms > kNeighbours);
    std::array<std::array<i32, kMaxPorts>, kRooms> rooms;
    std::array<std::span<const i32>, kRooms> found;
    const auto mark_run = [&]<bool kLinks>(std::bool_constant<kLinks>, std::span<const PendingRecord> records) {
        const u16 column = records[0].column;
        const u8* const entries = columns_.entry(column, 0);
        const i64 stride = module_.columns[column].stride;
        for (std::size_t i = 0; i < records.size() + kNeighbours; ++i) {
            if (i + kFirst < records.size()) {
                const u32 catom = records[i + kFirst].catom;
                __builtin_prefetch(kLinks ? g.link_first + catom : g.catom_site + catom);
                if (kLinks) __builtin_prefetch(g.link_ports + catom);
            }
            if (i + kSecond < records.size()) {
                const u32 catom = records[i + kSecond].catom;
                __builtin_prefetch(kLinks ? g.link_catom + g.link_first[catom] : g.cell_catom + g.catom_site[catom]);
            }
            if (i < records.size()) {
                found[i % kRooms] = neighbours_of<kLinks>(g, records[i].catom, rooms[i % kRooms]);
                // -1 is asked for as well, which does nothing: to test for it takes longer.
                for (const i32 other : found[i % kRooms]) __builtin_prefetch(entries + other * stride);
            }
            if (i < kNeighbours) continue;
            const PendingRecord& now = records[i - kNeighbours];
            mark_concerned(t, found[(i - kNeighbours) % kRooms], now.catom, column, now.record);
        }
    };
    // Run by run of records of the same column.
    const std::span<const PendingRecord> all(t.records);
    for (std::size_t from = 0, to = 0; from < all.size(); from = to) {
        while (to < all.size() && all[to].column == all[from].column) ++to;
        if (!asks_concerned(all[from].column)) continue;
        if (g.link_first != nullptr)
            mark_run(std::true_type(), all.subspan(from, to - from));
        else
            mark_run(std::false_type(), all.subspan(from, to - from));
    }
}

void Evaluator::mark_concerned(Thread& t, std::span<const i32> neighbours, u32 catom, u16 column, const u8* before) {
    const ColumnInfo& info = module_.columns[column];
    if (t.concerned.size() < neighbours.size()) t.concerned.resize(neighbours.size());
    const auto ports = static_cast<u32>(neighbours.size());
    const u32 count = info.concerned(&t, catom, before, columns_.entry(column, catom), neighbours.data(), ports, t.concerned.data());
    if (threads_.size() == 1)
        agenda().mark_all({t.concerned.data(), count}, info.reader_dirty);
    else
        for (u32 i = 0; i < count; ++i) agenda().mark_shared(t.concerned[i], info.reader_dirty);
    if (!t.passed_over && count < ports)
        t.passed_over = std::ranges::count_if(neighbours, [](i32 other) { return other >= 0; }) > std::ptrdiff_t{count};
}

void Evaluator::mark_concerned(const SubdomainView& subdomain, const Change& of, const u8* before, const u8* after,
                               std::span<const i32> readers) {
    MELD_EXPECT(apart_ && can_concern(of.column), "column {} of catom {}", of.column, of.catom);
    Thread& t = *threads_[0];
    t.subdomain = &subdomain;
    if (t.concerned.size() < readers.size()) t.concerned.resize(readers.size());
    const ColumnInfo& info = module_.columns[of.column];
    const u32 count = info.concerned(&t, of.catom, before, after, readers.data(), static_cast<u32>(readers.size()), t.concerned.data());
    if (count > 0) agenda().mark_all({t.concerned.data(), count}, info.reader_dirty);
}

void Evaluator::mark_concerned(const Geometry& g, u32 catom, u16 column, const u8* before) {
    MELD_EXPECT(asks_concerned(column), "column {} of catom {}", column, catom);
    std::array<i32, kMaxPorts> room;
    const auto neighbours = g.link_first != nullptr ? neighbours_of<true>(g, catom, room) : neighbours_of<false>(g, catom, room);
    mark_concerned(*threads_[0], neighbours, catom, column, before);
}

}  // namespace meld::eval
