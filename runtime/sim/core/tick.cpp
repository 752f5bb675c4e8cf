// The tick of a part: timers, evaluation, delivery, and what the parts tell each other.
#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/stage_clock.h"
#include "runtime/comm/packets.h"
#include "runtime/sim/core/part_state.h"
#include "runtime/tuple/facts.h"

namespace meld::sim {

namespace {

enum class Record : std::uint8_t { Export, Rows, Message };

}  // namespace

void PartState::begin_tick() {
    ++abi.now;
    const auto here = [&](u32 catom) { return catom < ensemble.index_count() && owned(catom); };
    const auto wake = [&](u32 catom, u64 bits) {
        if (here(catom)) mark(catom, bits);
    };
    const auto wake_group = [&](u32 catom, u16 column, const u8* row) {
        if (!here(catom)) return;
        columns.tell_woken(column, catom, row, 0);
        mark(catom, kDirtyGroups);
    };
    evaluator.timers().fire(abi.now, wake, wake_group);
}

const Totals& PartState::end_tick() {
    refresh();
    abi.greatest_rank = totals.greatest_rank;
    {
        const StageClock clock(evaluation_s);
        totals.failure =
            evaluator.evaluate(abi, [&](int thread, u32 catom, u16 column) { note_export(thread, catom, column, Pushed::Changed); });
    }
    const StageClock clock(exchange_s);
    sent_bytes_ = dropped_ = 0;
    if (alone()) {
        std::vector<Arrival>& arrivals = delivery_.arrivals;
        arrivals.clear();
        for (const eval::Message& m : evaluator.messages()) arrivals.push_back({m.to, m.predicate, m.arguments});
        deliver(arrivals);
    } else {
        exchange();
    }
    agree();
    return totals;
}

void PartState::end_early() {
    abi.now = last_tick;
    if (alone()) return;
    ByteWriter mine;
    mine.write(half_way);
    for (const std::byte each : comm.allgather(mine.view())) half_way = half_way || each != std::byte{0};
}

void PartState::deliver(std::vector<Arrival>& arrivals) {
    // By receiver, as what this part has sent comes, and for each by predicate; what is equal stays in order.
    const auto by_receiver = [](const Arrival& a, const Arrival& b) { return a.to < b.to; };
    const auto by_predicate = [](const Arrival& a, const Arrival& b) { return a.predicate < b.predicate; };
    if (!std::is_sorted(arrivals.begin(), arrivals.end(), by_receiver)) {
        std::vector<Keyed>& order = delivery_.order;
        order.clear();
        for (std::size_t i = 0; i < arrivals.size(); ++i) order.push_back({arrivals[i].to, static_cast<u32>(i)});
        sort_by_key(order, delivery_.spare);
        delivery_.sorted.clear();
        for (const Keyed& k : order) delivery_.sorted.push_back(arrivals[k.place]);
        arrivals.swap(delivery_.sorted);
    }
    std::vector<const Value*>& together = delivery_.together;
    for (auto from = arrivals.begin(); from != arrivals.end();) {
        const auto to = std::find_if(from, arrivals.end(), [&](const Arrival& a) { return a.to != from->to; });
        if (!std::is_sorted(from, to, by_predicate)) std::stable_sort(from, to, by_predicate);
        while (from != to) {
            const Arrival& first = *from;
            together.clear();
            for (; from != to && from->predicate == first.predicate; ++from) together.push_back(from->arguments);
            if (together.size() > 1)
                give_all(first.predicate, first.to, together);
            else
                give(first.predicate, first.to, together[0]);
        }
    }
}

void PartState::note_export(int thread, Catom catom, u16 column, Pushed what) {
    if (alone()) return;
    auto& lists = outgoing_[static_cast<std::size_t>(thread)];
    listeners(catom, [&](int other) { lists[static_cast<std::size_t>(other)].push_back({catom, column, what}); });
}

template <class Visit>
void PartState::listeners(Catom catom, const Visit& visit) const {
    if (!ensemble.is_free()) return halo->subscribers(abi.geometry.catom_site[catom], visit);
    // The owners of its neighbours, each once; there are few.
    int told[kMaxPorts];
    int count = 0;
    for (int port = 0; port < kMaxPorts; ++port) {
        const std::optional<Catom> other = ensemble.linked(catom, port);
        if (!other || owned(*other) || std::find(told, told + count, owners[*other]) != told + count) continue;
        told[count++] = owners[*other];
        visit(owners[*other]);
    }
}

void PartState::write_name(ByteWriter& out, Catom catom) const {
    if (ensemble.is_free())
        out.write(ensemble.id(catom));
    else
        out.write(ensemble.cell(catom));
}

Catom PartState::read_name(ByteReader& in, int sender) const {
    if (ensemble.is_free()) {
        const auto id = in.read<u64>();
        const std::optional<Catom> catom = ensemble.find(id);
        MELD_CHECK(catom.has_value(), "part {} told of catom {}, which this one does not know", sender, id);
        return *catom;
    }
    const auto cell = in.read<Cell>();
    const std::optional<Catom> catom = ensemble.at(cell);
    MELD_CHECK(catom.has_value(), "part {} told of a cell where this one knows no catom: ({}, {}, {})", sender, cell.x, cell.y, cell.z);
    return *catom;
}

void PartState::write_export(ByteWriter& out, Catom catom, u16 column, Pushed what) const {
    const bool rows = what == Pushed::Changed && columns.changes().follows(column);
    out.write(rows ? Record::Rows : Record::Export);
    write_name(out, catom);
    out.write(column);
    if (!rows) return columns.pack_column(column, catom, out);
    const RowChanges& changes = *columns.changes().of(column, catom);
    out.write(changes.removed);
    out.write(changes.added);
    out.write_bytes(&changes + 1, std::size_t{module.columns[column].row_bytes} * (std::size_t{changes.removed} + changes.added));
}

// Changed exports to the parts that hold ghosts of them, and facts for catoms of other parts, a packet a destination.
void PartState::exchange() {
    std::vector<Arrival>& arrivals = delivery_.arrivals;
    arrivals.clear();
    for (auto& lists : outgoing_)
        for (std::size_t other = 0; other < lists.size(); ++other) {
            for (const Export& e : lists[other]) write_export(packets_[other], e.catom, e.column, e.what);
            lists[other].clear();
        }
    for (const eval::Message& m : evaluator.messages()) {
        if (owned(m.to)) {
            arrivals.push_back({m.to, m.predicate, m.arguments});
            continue;
        }
        ByteWriter& out = packets_[static_cast<std::size_t>(owner_of(m.to))];
        out.write(Record::Message);
        write_name(out, m.to);
        out.write(m.predicate);
        const PredicateInfo& p = module.predicates[m.predicate];
        for (u32 i = 0; i < p.arity; ++i) tuple::pack(tuple::type_of(module, p.fields[i]), m.arguments[i], out);
    }
    std::vector<comm::Packet> packets = comm::take_packets(packets_);
    for (const comm::Packet& packet : packets) sent_bytes_ += packet.bytes.size();
    std::deque<std::vector<Value>> arguments;
    tuple::Arena lists;
    const std::vector<comm::Packet> received = comm.exchange(std::move(packets));
    for (const comm::Packet& packet : received) receive(packet, arrivals, arguments, lists);
    deliver(arrivals);
}

void PartState::receive(const comm::Packet& packet, std::vector<Arrival>& arrivals, std::deque<std::vector<Value>>& arguments,
                        tuple::Arena& lists) {
    ByteReader in(packet.bytes, "a packet of exports and messages");
    while (!in.done()) {
        const auto record = in.read<Record>();
        const Catom catom = read_name(in, packet.part);
        const auto number = in.read<u16>();
        if (record == Record::Export) {
            columns.unpack_column(number, catom, in, 0);
            mark_neighbours(catom, module.columns[number].reader_dirty);
        } else if (record == Record::Rows) {
            const auto removed = in.read<u32>(), added = in.read<u32>();
            RowChanges* changes = columns.changes().make(number, removed, added, 0);
            const std::size_t bytes = std::size_t{module.columns[number].row_bytes} * (std::size_t{removed} + added);
            std::memcpy(changes + 1, in.read_bytes(bytes).data(), bytes);
            columns.change_rows(number, catom, changes, 0);
            mark_neighbours(catom, module.columns[number].reader_dirty);
        } else {
            const PredicateInfo& p = module.predicates[number];
            std::vector<Value>& values = arguments.emplace_back(p.arity);
            for (u32 i = 0; i < p.arity; ++i) values[i] = tuple::unpack(tuple::type_of(module, p.fields[i]), in, lists);
            arrivals.push_back({catom, number, values.data()});
        }
    }
}

// One small exchange tells all parts what all did, so that they end, fail and count together.
void PartState::agree() {
    Totals mine;
    mine.tick = evaluator.statistics();
    mine.tick.dropped += dropped_;
    mine.catoms = ensemble.owned_count();
    mine.bytes = bytes();
    mine.actions = evaluator.actions().size();
    for (const eval::Action& a : evaluator.actions()) {
        const std::string_view name = module.predicates[a.predicate].name;
        mine.births_wanted += name == "create";
        mine.teleports += name == "moveTo";
        mine.finished = mine.finished || name == "stop-program";
    }
    mine.sent_bytes = sent_bytes_;
    mine.awake = !evaluator.agenda().empty() || mine.actions > 0 || moving;
    mine.waiting = !evaluator.timers().empty() ||
                   std::any_of(world.events.begin(), world.events.end(), [&](const world::Event& e) { return e.last() > abi.now; });
    mine.stop = stop_requested;
    mine.greatest_rank = evaluator.greatest_rank();
    mine.failure = totals.failure;
    if (alone()) {
        totals = mine;
        return;
    }
    ByteWriter bytes;
    bytes.write(mine);
    const std::vector<std::byte> all = comm.allgather(bytes.view());
    Totals sum;
    ByteReader in(all, "the totals of all parts");
    for (int part = 0; part < comm.parts(); ++part) {
        const auto t = in.read<Totals>();
        sum.tick.awake += t.tick.awake;
        sum.tick.derivations += t.tick.derivations;
        sum.tick.changes += t.tick.changes;
        sum.tick.messages += t.tick.messages;
        sum.tick.dropped += t.tick.dropped;
        sum.catoms += t.catoms;
        sum.bytes += t.bytes;
        sum.actions += t.actions;
        sum.births_wanted += t.births_wanted;
        sum.teleports += t.teleports;
        sum.sent_bytes += t.sent_bytes;
        sum.awake = sum.awake || t.awake;
        sum.waiting = sum.waiting || t.waiting;
        sum.stop = sum.stop || t.stop;
        sum.finished = sum.finished || t.finished;
        sum.greatest_rank = std::max(sum.greatest_rank, t.greatest_rank);
        const bool earlier = t.failure.trap != Trap::None && (sum.failure.trap == Trap::None || t.failure.catom < sum.failure.catom);
        if (earlier) sum.failure = t.failure;
    }
    totals = sum;
}

}  // namespace meld::sim
