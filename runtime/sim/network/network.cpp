#include "runtime/sim/network/network.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/schema.h"
#include "runtime/engine/tuple/values.h"

namespace meld::sim {

Network::Network(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts)
    : module_(module), world_(world), members_(members), facts_(facts), ring_(world.latency() + 2) {
    for (u16 c = 0; c < module.column_count; ++c) {
        if (!module.columns[c].exported) continue;
        exported_.push_back(c);
        readers_dirty_ |= module.columns[c].reader_dirty;
    }
}

// ---- mailboxes

void Network::follow_links(i64 now) { follow(now, true); }

void Network::follow(i64 now, bool tell) {
    world::Ensemble& ensemble = members_.ensemble;
    for (const world::Links::Change& link : ensemble.links().take_changes()) {
        // What it holds of a link is there as long as it can read over it.
        facts_.touch(link.reader);
        if (!link.made) {
            if (link.read >= 0 && static_cast<Catom>(link.read) != link.other)
                close_mailbox(number_of_[static_cast<std::size_t>(link.read)]);
            continue;
        }
        // It may be gone again already.
        if (link.port >= ensemble.links().ports(link.reader) || ensemble.links().at(link.reader, link.port) != link.other) continue;
        // Before the first tick nobody has anything to tell.
        const bool tells = tell && now > 1 && !exported_.empty();
        if (ensemble.state(link.reader) != kCatomOwned) {
            // Another process has the mailbox, but both know whether what is told is lost.
            if (tells) note_loss(now - 1, link.other, link.reader);
            continue;
        }
        if (ensemble.links().read(link.reader, link.port) >= 0) continue;
        // As if the neighbour had told all of it at the end of the last tick.
        if (tells)
            tell_state(now - 1, open_mailbox(link.reader, link.port, link.other, Holds::Nothing));
        else
            ensemble.links().read_at(link.reader, link.port, static_cast<std::int32_t>(link.other));
    }
    facts_.resize(ensemble.index_count());
}

u32 Network::open_mailbox(Catom reader, world::Port port, Catom other, Holds holds) {
    world::Ensemble& ensemble = members_.ensemble;
    Catom index = 0;
    if (spare_.empty()) {
        index = ensemble.add_mailbox(other);
    } else {
        index = spare_.back();
        spare_.pop_back();
        ensemble.use_mailbox(index, other);
    }
    // Not one by one: a wave opens thousands in a tick.
    if (index >= facts_.columns.count()) facts_.resize(index + index / 64 + std::size_t{64});
    ensemble.links().read_at(reader, port, static_cast<std::int32_t>(index));
    u32 number = static_cast<u32>(mailboxes_.size());
    if (free_mailboxes_.empty()) {
        mailboxes_.emplace_back();
    } else {
        number = free_mailboxes_.back();
        free_mailboxes_.pop_back();
    }
    if (number_of_.size() <= index) number_of_.resize(index + std::size_t{1}, kNone32);
    number_of_[index] = number;
    mailboxes_[number] = {
        .reader = reader, .other = other, .port = port, .index = static_cast<std::int32_t>(index), .part = part_between(other, reader)};
    if (holds == Holds::AllThatIsSaid)
        for (const u16 column : exported_) facts_.columns.copy(column, other, index, 0);
    return number;
}

void Network::close_mailbox(u32 number) {
    Mailbox& m = mailboxes_[number];
    const auto index = static_cast<Catom>(m.index);
    facts_.columns.clear(index, 0);
    spare_.push_back(index);
    m.index = -1;
    if (m.under_way == 0) free_mailboxes_.push_back(number);
}

// Calls visit(reader, port, index) for each catom that reads over a link of this one, with its port and where it reads, or -1. They lie
// anywhere in memory: several are looked up before any of them is needed.
template <class Visit>
static void each_reader(const world::Links& links, Catom catom, const Visit& visit) {
    struct Reader {
        Catom catom;
        world::Port port;
        std::int32_t index;
    };
    std::array<Reader, 16> readers;
    const world::Port ports = links.ports(catom);
    for (world::Port from = 0; from < ports; from += static_cast<world::Port>(readers.size())) {
        std::size_t count = 0;
        for (world::Port port = from; port < std::min<std::size_t>(ports, from + readers.size()); ++port)
            if (const auto reader = links.at(catom, port)) readers[count++] = {*reader, links.port_there(catom, port), -1};
        for (std::size_t i = 0; i < count; ++i) readers[i].index = links.read(readers[i].catom, readers[i].port);
        for (std::size_t i = 0; i < count; ++i) visit(readers[i].catom, readers[i].port, readers[i].index);
    }
}

void Network::before_change(Catom catom) {
    each_reader(members_.ensemble.links(), catom, [&](Catom reader, world::Port port, std::int32_t index) {
        if (index == static_cast<std::int32_t>(catom) && members_.ensemble.state(reader) == kCatomOwned)
            open_mailbox(reader, port, catom, Holds::AllThatIsSaid);
    });
}

bool Network::has_news(const Mailbox& m) const {
    const tuple::ChangeLog& changes = facts_.columns.changes();
    return std::ranges::any_of(exported_, [&](u16 column) {
        return changes.follows(column) &&
               (changes.of(column, static_cast<Catom>(m.index)) != nullptr || changes.of(column, m.other) != nullptr);
    });
}

bool Network::holds_what_is_said(const Mailbox& m) const {
    return std::ranges::all_of(exported_, [&](u16 column) { return facts_.columns.same(column, static_cast<Catom>(m.index), m.other); });
}

void Network::settle(i64 now) {
    // A wave leaves few behind, and what comes in each tick finds its mailbox open.
    constexpr i64 kBetween = 2;
    if (now % kBetween != 0) return;
    for (u32 number = 0; number < mailboxes_.size(); ++number) {
        Mailbox& m = mailboxes_[number];
        if (m.index < 0 || m.under_way > 0 || m.last >= now || m.differs || has_news(m)) continue;
        m.differs = !holds_what_is_said(m);
        if (m.differs) continue;
        members_.ensemble.links().read_at(m.reader, m.port, static_cast<std::int32_t>(m.other));
        close_mailbox(number);
    }
}

const world::LinkTerms& Network::terms(u32 part) const {
    const world::NetworkOptions& network = world_.network;
    if (part == 0) return network.terms;
    return part <= network.parts.size() ? network.parts[part - 1].terms : network.singles[part - 1 - network.parts.size()].terms;
}

u32 Network::part_between(Catom from, Catom to) const {
    const world::NetworkOptions& network = world_.network;
    if (const auto single = network.single(members_.ensemble.id(from), members_.ensemble.id(to)))
        return static_cast<u32>(network.parts.size()) + *single + 1;
    u32 last = 0;
    for (u32 part = 0; part < network.parts.size(); ++part) {
        const world::Region& where = network.parts[part].where;
        if (members_.in_region(where, from) || members_.in_region(where, to)) last = part + 1;
    }
    return last;
}

void Network::tell_state(i64 now, u32 mailbox) {
    ByteWriter state;
    facts_.columns.pack(mailboxes_[mailbox].other, tuple::Columns::Which::Exported, state);
    const u32 parcel = take_parcel(Parcel::Kind::State, 0, state.view());
    post(now, mailbox, parcel, false);
    if (parcels_[parcel].links == 0) release_parcel(parcel);
}

std::optional<u32> Network::mailbox_at(Catom reader, world::Port port) {
    const std::int32_t index = members_.ensemble.links().read(reader, port);
    if (index < 0) return std::nullopt;
    const Catom other = *members_.ensemble.links().at(reader, port);
    if (static_cast<Catom>(index) == other) return open_mailbox(reader, port, other, Holds::AllThatIsSaid);
    return number_of_[static_cast<std::size_t>(index)];
}

template <class Visit>
void Network::each_link_read(const Visit& visit) const {
    const world::Ensemble& ensemble = members_.ensemble;
    for (Catom reader = 0; reader < ensemble.index_count(); ++reader) {
        if (ensemble.state(reader) != kCatomOwned) continue;
        ensemble.links().each(reader, [&](world::Port port, Catom other) {
            if (const std::int32_t index = ensemble.links().read(reader, port); index >= 0)
                visit(reader, port, other, static_cast<Catom>(index));
        });
    }
}

// ---- parcels

u32 Network::take_parcel(Parcel::Kind kind, u16 number, std::span<const std::byte> bytes) {
    u32 parcel = static_cast<u32>(parcels_.size());
    if (free_parcels_.empty()) {
        parcels_.emplace_back();
    } else {
        parcel = free_parcels_.back();
        free_parcels_.pop_back();
    }
    Parcel& p = parcels_[parcel];
    p.kind = kind, p.number = number, p.links = 0;
    p.bytes.assign(bytes.begin(), bytes.end());
    return parcel;
}

void Network::release_parcel(u32 parcel) {
    // What is short keeps its memory for the next.
    constexpr std::size_t kShort = 64;
    if (parcels_[parcel].bytes.capacity() > kShort) parcels_[parcel].bytes = {};
    free_parcels_.push_back(parcel);
}

void Network::put(i64 arrival, u32 mailbox, u32 parcel, bool late) {
    MELD_EXPECT(arrival >= 0, "tick {}", arrival);
    arriving(arrival).push_back({mailbox, parcel, late});
    ++mailboxes_[mailbox].under_way;
    ++parcels_[parcel].links;
    ++under_way_;
}

void Network::post(i64 now, u32 mailbox, u32 parcel, bool linear) {
    Mailbox& m = mailboxes_[mailbox];
    const world::Ensemble& ensemble = members_.ensemble;
    const world::Fate fate = world::fate(world_.network.kind, terms(m.part), world_.seed, ensemble.id(m.other), ensemble.id(m.reader), now);
    const auto arrival = [&](u32 ticks) { return world_.clock.next(world_.seed, ensemble.id(m.reader), now + ticks); };
    if (!fate.arrives) {
        lost_ += linear;
        // Whatever comes after it would be behind it, and finds the link down.
        m.last = std::max(m.last, now + fate.ticks);
        if (world_.network.kind == world::NetworkKind::Lossy)
            down_.push_back({now + fate.ticks, ensemble.id(m.other), ensemble.id(m.reader)});
        return;
    }
    // What was sent before arrives before, unless it may be overtaken.
    const i64 at = arrival(fate.ticks);
    m.last = terms(m.part).reorder ? at : std::max(m.last, at);
    put(m.last, mailbox, parcel);
    if (fate.twice_after != 0) put(std::max(terms(m.part).reorder ? 0 : m.last, arrival(fate.twice_after)), mailbox, parcel);
}

void Network::changed(i64 now, Catom catom, u16 column) {
    std::optional<u32> parcel;
    each_reader(members_.ensemble.links(), catom, [&](Catom reader, world::Port port, std::int32_t index) {
        if (members_.ensemble.state(reader) != kCatomOwned) return note_loss(now, catom, reader);
        if (index < 0) return;
        const u32 mailbox = static_cast<Catom>(index) == catom ? open_mailbox(reader, port, catom, Holds::AllThatIsSaid)
                                                               : number_of_[static_cast<std::size_t>(index)];
        if (!parcel) {
            ByteWriter bytes;
            const tuple::ChangeLog& changes = facts_.columns.changes();
            const bool rows = changes.follows(column);
            if (rows) {
                const RowChanges& c = *changes.of(column, catom);
                bytes.write(c.removed);
                bytes.write(c.added);
                bytes.write_bytes(&c + 1, module_.columns[column].row_bytes * (std::size_t{c.removed} + c.added));
            } else {
                facts_.columns.pack_column(column, catom, bytes);
            }
            parcel = take_parcel(rows ? Parcel::Kind::Rows : Parcel::Kind::Column, column, bytes.view());
        }
        post(now, mailbox, *parcel, false);
    });
    if (parcel && parcels_[*parcel].links == 0) release_parcel(*parcel);
}

void Network::note_loss(i64 now, Catom from, Catom to) {
    if (world_.network.kind != world::NetworkKind::Lossy || members_.ensemble.state(from) != kCatomOwned) return;
    const world::Ensemble& ensemble = members_.ensemble;
    const world::Fate fate =
        world::fate(world_.network.kind, terms_between(from, to), world_.seed, ensemble.id(from), ensemble.id(to), now);
    if (!fate.arrives) down_.push_back({now + fate.ticks, ensemble.id(from), ensemble.id(to)});
}

void Network::take_down(i64 now, const std::function<void(Catom)>& mark) {
    world::Ensemble& ensemble = members_.ensemble;
    const auto due = std::ranges::stable_partition(down_, [&](const Down& d) { return d.tick > now; });
    for (const Down& d : due) {
        const std::optional<Catom> from = ensemble.find(d.from), to = ensemble.find(d.to);
        const std::optional<world::Port> port = from && to ? ensemble.links().towards(*from, *to) : std::nullopt;
        if (!port) continue;
        ensemble.links().disconnect(*from, *port);
        mark(*from), mark(*to);
    }
    down_.erase(due.begin(), due.end());
}

void Network::forget_loss(u64 a, u64 b) {
    std::erase_if(down_, [&](const Down& d) { return (d.from == a && d.to == b) || (d.from == b && d.to == a); });
}

void Network::sent(i64 now, Catom to, u64 from, u16 predicate, const Value* arguments) {
    const world::Ensemble& ensemble = members_.ensemble;
    const std::optional<Catom> sender = ensemble.find(from);
    const std::optional<world::Port> port = sender ? ensemble.links().towards(to, *sender) : std::nullopt;
    const std::optional<u32> mailbox = port ? mailbox_at(to, *port) : std::nullopt;
    if (!mailbox) {
        ++lost_;
        return;
    }
    const u32 parcel = take_parcel(Parcel::Kind::Message, predicate, argument_bytes(predicate, arguments));
    post(now, *mailbox, parcel, true);
    if (parcels_[parcel].links == 0) release_parcel(parcel);
}

// ---- arrivals

i64 Network::jammed_until(i64 now, const Mailbox& m) const {
    if (world_.longest_jam == 0 || m.index < 0) return now;
    const world::Ensemble& ensemble = members_.ensemble;
    i64 until = now;
    for (const world::Event& event : world_.events) {
        if (event.jam.empty()) continue;
        const i64 begun = event.latest(now);
        for (const world::Jam& jam : event.jam)
            if (begun > 0 && begun + jam.ticks > until &&
                jam.links.contains(ensemble.id(m.other), ensemble.id(m.reader), [&](const world::Region& region, int end) {
                    return members_.in_region(region, end == 0 ? m.other : m.reader);
                }))
                until = begun + jam.ticks;
    }
    return until;
}

bool Network::comes_in(i64 now, const Entry& entry) {
    const Mailbox& m = mailboxes_[entry.mailbox];
    const i64 free = jammed_until(now, m);
    if (m.index >= 0 && free == now) return true;
    if (m.index < 0 || world_.network.kind == world::NetworkKind::Raw)
        lost_ += parcels_[entry.parcel].kind == Parcel::Kind::Message;
    else
        put(world_.clock.next(world_.seed, members_.ensemble.id(m.reader), free), entry.mailbox, entry.parcel, true);
    return false;
}

void Network::done_with(const Entry& entry) {
    Mailbox& m = mailboxes_[entry.mailbox];
    --under_way_;
    if (--m.under_way == 0 && m.index < 0) free_mailboxes_.push_back(entry.mailbox);
    if (--parcels_[entry.parcel].links == 0) release_parcel(entry.parcel);
}

// What has waited for the end of a jam was sent before what comes in its time.
std::vector<Network::Entry> Network::take_entries(i64 tick, bool linear) {
    std::vector<Entry>& here = arriving(tick);
    const auto is_other = [&](const Entry& entry) { return (parcels_[entry.parcel].kind == Parcel::Kind::Message) != linear; };
    std::vector<Entry> taken;
    if (std::ranges::none_of(here, is_other)) {
        taken.swap(here);
    } else {
        const auto others = std::ranges::stable_partition(here, is_other);
        taken.assign(others.begin(), others.end());
        here.erase(others.begin(), others.end());
    }
    if (world_.longest_jam > 0) std::ranges::stable_partition(taken, &Entry::late);
    return taken;
}

void Network::arrive(i64 now) {
    const std::vector<Entry> entries = take_entries(now, false);
    // They lie anywhere in memory, so what the next ones need is asked for ahead.
    constexpr std::size_t kFirst = 16, kThen = 8;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (i + kFirst < entries.size()) {
            __builtin_prefetch(&mailboxes_[entries[i + kFirst].mailbox]);
            __builtin_prefetch(&parcels_[entries[i + kFirst].parcel]);
        }
        if (i + kThen < entries.size()) ask_ahead(entries[i + kThen]);
        const Entry& entry = entries[i];
        mailboxes_[entry.mailbox].differs = false;
        if (comes_in(now, entry)) open(mailboxes_[entry.mailbox], parcels_[entry.parcel]);
        done_with(entry);
    }
}

void Network::deliver(i64 next, const Deliver& deliver) {
    std::vector<Arrived> messages;
    std::deque<std::vector<Value>> arguments;
    tuple::Arena lists;
    for (const Entry& entry : take_entries(next, true)) {
        if (comes_in(next, entry)) {
            const Mailbox& m = mailboxes_[entry.mailbox];
            const Parcel& parcel = parcels_[entry.parcel];
            messages.push_back(
                {m.reader, members_.ensemble.id(m.other), parcel.number, read_arguments(parcel.number, parcel.bytes, arguments, lists)});
        }
        done_with(entry);
    }
    deliver_far(next, messages, arguments, lists);
    // Of one sender in the order in which it sent them.
    std::ranges::stable_sort(messages, {}, [&](const Arrived& m) { return std::tuple(members_.ensemble.id(m.to), m.from); });
    deliver(messages);
}

std::vector<std::byte> Network::argument_bytes(u16 predicate, const Value* arguments) const {
    const PredicateInfo& p = module_.predicates[predicate];
    ByteWriter bytes;
    for (u32 i = 0; i < p.arity; ++i) tuple::pack(tuple::type_of(module_, p.fields[i]), arguments[i], bytes);
    return bytes.take();
}

const Value* Network::read_arguments(u16 predicate, std::span<const std::byte> bytes, std::deque<std::vector<Value>>& arguments,
                                     tuple::Arena& lists) const {
    const PredicateInfo& p = module_.predicates[predicate];
    std::vector<Value>& values = arguments.emplace_back(p.arity);
    ByteReader in(bytes, "a linear fact under way");
    for (u32 i = 0; i < p.arity; ++i) values[i] = tuple::unpack(tuple::type_of(module_, p.fields[i]), in, lists);
    return values.data();
}

// For open().
void Network::ask_ahead(const Entry& entry) const {
    const Mailbox& m = mailboxes_[entry.mailbox];
    const Parcel& parcel = parcels_[entry.parcel];
    __builtin_prefetch(parcel.bytes.data());
    if (m.index < 0 || parcel.kind != Parcel::Kind::Column) return;
    __builtin_prefetch(facts_.columns.entry(parcel.number, static_cast<Catom>(m.index)), 1);
}

void Network::open(const Mailbox& m, const Parcel& parcel) {
    const auto index = static_cast<Catom>(m.index);
    ByteReader in(parcel.bytes, "what is under way over a link");
    switch (parcel.kind) {
        case Parcel::Kind::Column:
            facts_.columns.unpack_column(parcel.number, index, in, 0);
            break;
        case Parcel::Kind::Rows: {
            const auto removed = in.read<u32>(), added = in.read<u32>();
            RowChanges* changes = facts_.columns.changes().make(parcel.number, removed, added, 0);
            const auto rows = in.read_bytes(module_.columns[parcel.number].row_bytes * (std::size_t{removed} + added));
            std::memcpy(changes + 1, rows.data(), rows.size());
            facts_.columns.change_rows(parcel.number, index, changes, 0);
            break;
        }
        case Parcel::Kind::State:
            facts_.columns.unpack(index, tuple::Columns::Which::Exported, in, 0);
            return facts_.mark(m.reader, readers_dirty_);
        case Parcel::Kind::Message:
            MELD_CHECK(false, "a linear fact is given, not put into a mailbox");
    }
    // Nobody need look at what no rule reads.
    if (const u64 bits = module_.columns[parcel.number].reader_dirty; bits != 0) facts_.mark(m.reader, bits);
}

// ---- snapshots

void Network::save(i64 now, ByteWriter& out) const {
    const world::Ensemble& ensemble = members_.ensemble;
    u64 count = 0;
    each_link_read([&](Catom, world::Port, Catom, Catom) { ++count; });
    out.write_count(count);
    std::vector<u32> saved(mailboxes_.size(), kNone32);
    u32 next = 0;
    each_link_read([&](Catom reader, world::Port, Catom other, Catom index) {
        const bool in_place = index == other;
        if (!in_place) saved[number_of_[index]] = next;
        ++next;
        out.write(ensemble.id(reader));
        out.write(ensemble.id(other));
        out.write(in_place ? i64{0} : mailboxes_[number_of_[index]].last);
        const std::size_t state = out.begin_block();
        facts_.columns.pack(index, tuple::Columns::Which::Exported, out);
        out.end_block(state);
    });
    out.write_count(parcels_.size());
    for (const Parcel& parcel : parcels_) {
        out.write(parcel.kind);
        out.write(parcel.number);
        out.write_block(parcel.bytes);
    }
    // By ticks until the arrival.
    out.write_count(under_way_);
    for (u32 ticks = 1; ticks <= ring_.size(); ++ticks)
        for (const Entry& entry : ring_[(static_cast<std::size_t>(now) + ticks) % ring_.size()]) {
            out.write(ticks);
            out.write(saved[entry.mailbox]);
            out.write(entry.parcel);
            out.write(entry.late);
        }
    out.write_count(down_.size());
    for (const Down& d : down_) out.write(d);
    save_far(now, out);
}

void Network::load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    const world::Ensemble& ensemble = members_.ensemble;
    if (in.done()) {
        std::vector<Link> all;
        if (!exported_.empty())
            each_link_read([&](Catom reader, world::Port port, Catom other, Catom) { all.push_back({reader, port, other}); });
        for (const Link& link : all) tell_state(now, open_mailbox(link.reader, link.port, link.other, Holds::Nothing));
        return;
    }
    std::vector<std::optional<Link>> links(in.read_count(3 * sizeof(u64)));
    ByteWriter said;
    for (std::optional<Link>& link : links) {
        const auto reader = find(in.read<u64>());
        const auto other = ensemble.find(in.read<u64>());
        const auto last = in.read<i64>();
        const std::span<const std::byte> known = in.read_block();
        if (in.failed()) return;
        // Else it is one of another process.
        if (!reader || !other) continue;
        const std::optional<world::Port> port = ensemble.links().towards(*reader, *other);
        if (!port || ensemble.links().read(*reader, *port) < 0) continue;
        link = {*reader, *port, *other};
        // Where turns are given, changes may have arrived for a reader that has not had its own: it reads all of it.
        const bool reads_all = world_.clock.gives_turns() && readers_dirty_ != 0 && facts_.evaluator.agenda().dirty(*reader) != 0;
        said.clear();
        facts_.columns.pack(*other, tuple::Columns::Which::Exported, said);
        if (last > now || !std::ranges::equal(said.view(), known)) {
            Mailbox& m = mailboxes_[open_mailbox(*reader, *port, *other, Holds::Nothing)];
            m.last = last;
            ByteReader state(known, "what has arrived over a link", ByteReader::Origin::Outside);
            facts_.columns.unpack(static_cast<Catom>(m.index), tuple::Columns::Which::Exported, state, 0);
            // Its rows are no news to the reader.
            if (!reads_all) facts_.columns.changes().forget(static_cast<Catom>(m.index));
        }
        if (reads_all) facts_.mark(*reader, readers_dirty_);
    }
    std::vector<u32> parcels(in.read_count(sizeof(u16)), kNone32);
    struct Read {
        Parcel::Kind kind;
        u16 number;
        std::span<const std::byte> bytes;
    };
    std::vector<Read> read;
    for (std::size_t i = 0; i < parcels.size() && !in.failed(); ++i) {
        const auto kind = in.read<Parcel::Kind>();
        const auto number = in.read<u16>();
        read.push_back({kind, number, in.read_block()});
    }
    u32 gone = kNone32;  // A mailbox whose link is gone.
    for (std::size_t left = in.read_count(3 * sizeof(u32)); left > 0 && !in.failed(); --left) {
        const auto ticks = in.read<u32>(), mailbox = in.read<u32>(), parcel = in.read<u32>();
        const auto late = in.read<bool>();
        if (ticks == 0 || parcel >= read.size()) return;
        if (mailbox == kNone32 && takes_lost && gone == kNone32) {
            gone = static_cast<u32>(mailboxes_.size());
            mailboxes_.emplace_back();
        }
        u32 to = gone;
        if (mailbox != kNone32) {
            if (mailbox >= links.size() || !links[mailbox]) continue;
            to = *mailbox_at(links[mailbox]->reader, links[mailbox]->port);
        }
        if (to == kNone32) continue;
        if (parcels[parcel] == kNone32) {
            const std::span<const std::byte> bytes = read[parcel].bytes;
            parcels[parcel] = take_parcel(read[parcel].kind, read[parcel].number, bytes);
        }
        // This world's network may be faster.
        put(now + std::min<i64>(ticks, world_.latency()), to, parcels[parcel], late);
    }
    // Each process has noted those that it may have to take down.
    for (std::size_t left = in.read_count(sizeof(Down)); left > 0 && !in.failed(); --left) down_.push_back(in.read<Down>());
    load_far(now, find, takes_lost, in);
}

std::size_t Network::bytes() const {
    std::size_t all = mailboxes_.capacity() * sizeof(Mailbox) + parcels_.capacity() * sizeof(Parcel) + number_of_.capacity() * sizeof(u32);
    for (const auto& slot : ring_) all += slot.capacity() * sizeof(Entry);
    for (const Parcel& parcel : parcels_) all += parcel.bytes.capacity();
    for (const Far& far : far_) all += sizeof far + far.bytes.capacity();
    return all;
}

}  // namespace meld::sim
