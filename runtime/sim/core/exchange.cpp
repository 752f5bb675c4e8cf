#include "runtime/sim/core/exchange.h"

#include <algorithm>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/engine/tuple/field.h"

namespace meld::sim {

Exchange::Exchange(Subdomain& subdomain)
    : subdomain_(subdomain),
      exports_(static_cast<std::size_t>(subdomain.workers.threads()),
               std::vector<std::vector<Export>>(static_cast<std::size_t>(subdomain.comm.processes()))),
      packets_(static_cast<std::size_t>(subdomain.comm.processes())),
      changed_(static_cast<std::size_t>(subdomain.workers.threads())),
      births_(subdomain) {}

void Exchange::note_export(int worker, Catom catom, u16 column) {
    if (network_follows()) changed_[static_cast<std::size_t>(worker)].push_back({catom, column});
    if (subdomain_.alone()) return;
    MELD_EXPECT(subdomain_.owned(catom) && subdomain_.module.columns[column].exported, "catom {}, column {}", catom, column);
    auto& by_destination = exports_[static_cast<std::size_t>(worker)];
    subdomain_.members_.subscribers(catom, subdomain_.geometry().catom_site[catom],
                                    [&](int other) { by_destination[static_cast<std::size_t>(other)].push_back({catom, column}); });
}

void Exchange::run() {
    MELD_EXPECT(std::ranges::all_of(packets_, &ByteWriter::empty), "something of an earlier tick is still to be sent");
    sent_bytes_ = 0;
    arrivals_.clear();
    // In any order of workers: a column of a catom changes once.
    for (auto& changed : changed_) {
        if (!changed.empty()) subdomain_.network_->changed(subdomain_.tick(), changed);
        changed.clear();
    }
    if (subdomain_.alone()) {
        for (const eval::Message& m : subdomain_.facts_.evaluator.messages()) come(m.to, m.from, m.predicate, m.arguments);
        subdomain_.facts_.deliver_sent(subdomain_.geometry(), true);
        send_far();
        send_births();
        bear();
        return deliver_all();
    }
    pack();
    std::vector<comm::Packet> packets = comm::take_packets(packets_);
    for (const comm::Packet& packet : packets) sent_bytes_ += packet.bytes.size();
    const std::vector<comm::Packet> received = subdomain_.comm.exchange(std::move(packets));
    subdomain_.facts_.deliver_sent(subdomain_.geometry(), false);
    std::deque<std::vector<Value>> arguments;
    tuple::Arena lists;
    for (const comm::Packet& packet : received) unpack(packet, arguments, lists);
    bear();
    deliver_all();
}

void Exchange::pack() {
    for (auto& by_destination : exports_)
        for (std::size_t other = 0; other < by_destination.size(); ++other) {
            for (const Export& changed : by_destination[other]) pack_export(packets_[other], changed);
            by_destination[other].clear();
        }
    for (const eval::Message& m : subdomain_.facts_.evaluator.messages()) {
        if (subdomain_.owned(m.to)) {
            come(m.to, m.from, m.predicate, m.arguments);
            continue;
        }
        if (subdomain_.network_) subdomain_.network_->sent_away(subdomain_.tick(), *subdomain_.ensemble.find(m.from), m.to);
        pack_message(packets_[static_cast<std::size_t>(subdomain_.owner_of(m.to))], m);
    }
    pack_rows();
    send_far();
    send_births();
}

// Rows for catoms of other processes travel as messages do.
void Exchange::pack_rows() {
    const ModuleInfo& module = subdomain_.module;
    const eval::Evaluator& evaluator = subdomain_.facts_.evaluator;
    std::vector<Value> arguments;
    for (const u16 predicate : evaluator.linear_predicates()) {
        const PredicateInfo& p = module.predicates[predicate];
        evaluator.each_sent(p.column, [&](u32 to, u32 from, const u8* row) {
            if (subdomain_.owned(to)) return;
            tuple::read_row(p, row, arguments);
            pack_message(packets_[static_cast<std::size_t>(subdomain_.owner_of(to))],
                         {to, predicate, subdomain_.ensemble.id(from), 0, arguments.data()});
        });
    }
}

void Exchange::send_far() {
    for (const eval::FarMessage& m : subdomain_.facts_.evaluator.far_messages()) {
        // Its process may still find that it is gone.
        const int owner = subdomain_.routes_->owner(m.to).value_or(subdomain_.comm.process());
        if (owner == subdomain_.comm.process()) {
            come_far(m.to, m.from, m.predicate, m.arguments);
            continue;
        }
        pack_far(Record::Far, m, owner);
    }
}

void Exchange::pack_far(Record record, const eval::FarMessage& message, int owner) {
    ByteWriter& out = packets_[static_cast<std::size_t>(owner)];
    out.write(record);
    out.write(message.to);
    out.write(message.predicate);
    out.write(message.from);
    pack_arguments(out, message.predicate, message.arguments);
}

void Exchange::send_births() {
    for (const eval::FarMessage& m : subdomain_.facts_.evaluator.births())
        if (const int owner = Nodes::owner(m.to, subdomain_.comm.processes()); owner == subdomain_.comm.process())
            births_.take({m.to, m.from, m.predicate, m.arguments});
        else
            pack_far(Record::Birth, m, owner);
}

void Exchange::bear() {
    if (!subdomain_.module.makes_nodes || !subdomain_.world.is_graph()) return;
    for (const Births::Fact& fact : births_.run()) arrivals_.push_back({*fact.catom, fact.predicate, fact.arguments});
    births_.clear();
}

void Exchange::come_far(u64 to, u64 from, u16 predicate, const Value* arguments) {
    const std::optional<Catom> catom = subdomain_.ensemble.find(to);
    if (!catom || !subdomain_.owned(*catom)) {
        ++lost_;
        return;
    }
    if (subdomain_.network_) return subdomain_.network_->sent_far(subdomain_.tick(), *catom, from, predicate, arguments);
    arrivals_.push_back({*catom, predicate, arguments});
}

void Exchange::come(Catom to, u64 from, u16 predicate, const Value* arguments) {
    if (subdomain_.network_) return subdomain_.network_->sent(subdomain_.tick(), to, from, predicate, arguments);
    arrivals_.push_back({to, predicate, arguments});
}

// Linear facts come at the end of a tick, with or without a network: rules find them in the next.
void Exchange::deliver_all() {
    if (!subdomain_.network_) return deliver();
    subdomain_.network_->deliver(subdomain_.tick() + 1, [&](const std::vector<Network::Arrived>& facts) {
        for (const Network::Arrived& fact : facts) arrivals_.push_back({fact.to, fact.predicate, fact.arguments});
        deliver();
    });
}

// The receiver has the column as it was before this tick, so if changes are recorded by row, only the changed rows are sent.
void Exchange::pack_export(ByteWriter& out, const Export& changed) const {
    const tuple::Columns& columns = subdomain_.columns;
    const bool rows = columns.changes().follows(changed.column);
    out.write(rows ? Record::Rows : Record::Export);
    pack_name(out, changed.catom);
    out.write(changed.column);
    if (!rows) return columns.pack_column(changed.column, changed.catom, out);
    MELD_ASSERT(columns.changes().of(changed.column, changed.catom) != nullptr, "column {} of catom {} has not changed", changed.column,
                changed.catom);
    const RowChanges& changes = *columns.changes().of(changed.column, changed.catom);
    out.write(changes.removed);
    out.write(changes.added);
    const std::size_t row_bytes = subdomain_.module.columns[changed.column].row_bytes;
    out.write_bytes(&changes + 1, row_bytes * (std::size_t{changes.removed} + changes.added));
}

void Exchange::pack_message(ByteWriter& out, const eval::Message& message) const {
    out.write(Record::Message);
    pack_name(out, message.to);
    out.write(message.predicate);
    if (subdomain_.network_) out.write(message.from);
    pack_arguments(out, message.predicate, message.arguments);
}

void Exchange::pack_arguments(ByteWriter& out, u16 predicate, const Value* arguments) const {
    const PredicateInfo& p = subdomain_.module.predicates[predicate];
    for (u32 i = 0; i < p.arity; ++i) tuple::pack(tuple::type_of(subdomain_.module, p.fields[i]), arguments[i], out);
}

const Value* Exchange::unpack_arguments(u16 predicate, ByteReader& in, std::deque<std::vector<Value>>& arguments,
                                        tuple::Arena& lists) const {
    const PredicateInfo& p = subdomain_.module.predicates[predicate];
    std::vector<Value>& values = arguments.emplace_back(p.arity);
    for (u32 i = 0; i < p.arity; ++i) values[i] = tuple::unpack(tuple::type_of(subdomain_.module, p.fields[i]), in, lists);
    return values.data();
}

void Exchange::pack_name(ByteWriter& out, Catom catom) const {
    if (subdomain_.ensemble.is_free())
        out.write(subdomain_.ensemble.id(catom));
    else
        out.write(subdomain_.ensemble.cell(catom));
}

Catom Exchange::unpack_name(ByteReader& in, int sender) const {
    if (subdomain_.ensemble.is_free()) {
        const auto id = in.read<u64>();
        const std::optional<Catom> catom = subdomain_.ensemble.find(id);
        MELD_CHECK(catom.has_value(), "process {} sent a change of catom @{}, which this one does not know", sender, id);
        return *catom;
    }
    const auto cell = in.read<Cell>();
    const std::optional<Catom> catom = subdomain_.ensemble.at(cell);
    MELD_CHECK(catom.has_value(), "process {} sent a change of cell ({}, {}, {}), where this one knows no catom", sender, cell.x, cell.y,
               cell.z);
    return *catom;
}

void Exchange::unpack(const comm::Packet& packet, std::deque<std::vector<Value>>& arguments, tuple::Arena& lists) {
    const ModuleInfo& module = subdomain_.module;
    ByteReader in(packet.bytes, "a packet of exports and messages");
    while (!in.done()) {
        const auto record = in.read<Record>();
        if (record == Record::Far || record == Record::Birth) {
            const auto to = in.read<u64>();
            const auto predicate = in.read<u16>();
            const auto from = in.read<u64>();
            const Value* const values = unpack_arguments(predicate, in, arguments, lists);
            if (record == Record::Far)
                come_far(to, from, predicate, values);
            else
                births_.take({to, from, predicate, values});
            continue;
        }
        const Catom catom = unpack_name(in, packet.process);
        const auto number = in.read<u16>();
        if (record == Record::Message) {
            MELD_ASSERT(subdomain_.owned(catom) && number < module.predicate_count, "catom {}, predicate {}", catom, number);
            const u64 from = subdomain_.network_ ? in.read<u64>() : 0;
            come(catom, from, number, unpack_arguments(number, in, arguments, lists));
            continue;
        }
        MELD_ASSERT(!subdomain_.owned(catom) && subdomain_.owner_of(catom) == packet.process, "catom {} of process {}", catom,
                    packet.process);
        MELD_ASSERT(number < module.column_count, "catom {}, column {}", catom, number);
        const eval::Change change{catom, number};
        if (subdomain_.network_) subdomain_.network_->before_change(subdomain_.tick(), {&change, 1});
        const bool asks = module.columns[number].concerned != nullptr && !subdomain_.network_;
        if (asks) {
            const u8* const entry = subdomain_.columns.entry(number, catom);
            before_.assign(entry, entry + module.columns[number].stride);
        }
        if (record == Record::Rows)
            unpack_rows(number, catom, in);
        else
            subdomain_.facts_.columns.unpack_column(number, catom, in, 0);
        if (network_follows())
            subdomain_.network_->changed(subdomain_.tick(), {&change, 1});
        else if (subdomain_.network_)
            continue;
        else if (asks)
            subdomain_.facts_.evaluator.mark_concerned(subdomain_.geometry(), catom, number, before_.data());
        else
            subdomain_.mark_neighbours(catom, module.columns[number].reader_dirty);
    }
}

void Exchange::unpack_rows(u16 column, Catom catom, ByteReader& in) {
    tuple::Columns& columns = subdomain_.facts_.columns;
    const auto removed = in.read<u32>(), added = in.read<u32>();
    const std::span<const std::byte> rows =
        in.read_bytes(std::size_t{subdomain_.module.columns[column].row_bytes} * (std::size_t{removed} + added));
    RowChanges* changes = columns.changes().make(column, removed, added, 0);
    std::memcpy(changes + 1, rows.data(), rows.size());
    columns.change_rows(column, catom, changes, 0);
}

// By receiver, in the order in which this process's messages arrive; equal ones keep their order.
void Exchange::sort_arrivals() {
    const auto by_receiver = [](const Arrival& a, const Arrival& b) { return a.to < b.to; };
    if (std::is_sorted(arrivals_.begin(), arrivals_.end(), by_receiver)) return;
    order_.clear();
    for (std::size_t i = 0; i < arrivals_.size(); ++i) order_.push_back({arrivals_[i].to, static_cast<u32>(i)});
    sort_by_key(order_, spare_);
    sorted_.clear();
    for (const Keyed& k : order_) sorted_.push_back(arrivals_[k.place]);
    MELD_ENSURE(sorted_.size() == arrivals_.size(), "{} of {} facts that came", sorted_.size(), arrivals_.size());
    arrivals_.swap(sorted_);
}

void Exchange::deliver() {
    sort_arrivals();
    const auto by_predicate = [](const Arrival& a, const Arrival& b) { return a.predicate < b.predicate; };
    for (auto from = arrivals_.begin(); from != arrivals_.end();) {
        const auto to = std::find_if(from, arrivals_.end(), [&](const Arrival& a) { return a.to != from->to; });
        if (!std::is_sorted(from, to, by_predicate)) std::stable_sort(from, to, by_predicate);
        while (from != to) {
            const Arrival& first = *from;
            together_.clear();
            for (; from != to && from->predicate == first.predicate; ++from) together_.push_back(from->arguments);
            if (together_.size() > 1)
                subdomain_.facts_.give_all(first.predicate, first.to, together_);
            else
                subdomain_.facts_.give(first.predicate, first.to, together_[0]);
        }
    }
}

}  // namespace meld::sim
