#include "runtime/sim/network/network.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/prefetch.h"
#include "runtime/engine/tuple/schema.h"
#include "runtime/engine/tuple/values.h"

namespace meld::sim {

Network::Network(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, const SubdomainView& subdomain)
    : module_(module),
      world_(world),
      members_(members),
      facts_(facts),
      fates_(world, members),
      indices_(members, facts),
      ring_(world.latency() + 2) {
    if (Versions::suit(module, world)) versions_.emplace(module, world, members, facts, fates_, subdomain);
    for (u16 c = 0; c < module.column_count; ++c) {
        if (!module.columns[c].exported) continue;
        exported_.push_back(c);
        readers_dirty_ |= module.columns[c].reader_dirty;
    }
}

// ---- mailboxes

void Network::follow_links(i64 now) { follow(now, true); }

void Network::follow(i64 now, bool tell) {
    if (constexpr i64 kBetween = i64{1} << 30; now % kBetween == 0) fates_.forget_turns();
    if (versions_) return versions_->follow_links(now, tell);
    world::Ensemble& ensemble = members_.ensemble;
    for (const world::Links::Change& link : ensemble.links().take_changes()) {
        // What it holds of a link is there as long as it can read over it.
        facts_.touch(link.reader);
        fates_.forget_turn(link.reader);
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
            if (tells) fates_.note_loss(now - 1, link.other, link.reader);
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
    const Catom index = indices_.take(other);
    members_.ensemble.links().read_at(reader, port, static_cast<std::int32_t>(index));
    u32 number = static_cast<u32>(mailboxes_.size());
    if (free_mailboxes_.empty()) {
        mailboxes_.emplace_back();
    } else {
        number = free_mailboxes_.back();
        free_mailboxes_.pop_back();
    }
    if (number_of_.size() <= index) number_of_.resize(index + std::size_t{1}, kNone32);
    number_of_[index] = number;
    mailboxes_[number] = {.reader = reader,
                          .other = other,
                          .port = port,
                          .index = static_cast<std::int32_t>(index),
                          .part = fates_.part_between(other, reader)};
    if (holds == Holds::AllThatIsSaid)
        for (const u16 column : exported_) facts_.columns.copy(column, other, index, 0);
    return number;
}

void Network::close_mailbox(u32 number) {
    Mailbox& m = mailboxes_[number];
    indices_.give_back(static_cast<Catom>(m.index));
    m.index = -1;
    if (m.under_way == 0) free_mailboxes_.push_back(number);
}

// Calls visit(reader, port, index) for each catom that reads over a link of this one, with its port and where it reads, or -1.
template <class Visit>
static void each_reader(const world::Links& links, Catom catom, const Visit& visit) {
    each_readers(links, catom, [&](std::span<const Reader> readers) {
        for (const Reader& reader : readers) visit(reader.catom, reader.port, reader.index);
    });
}

void Network::before_change(i64 now, std::span<const eval::Change> changes) {
    if (versions_) return versions_->change(now, changes);
    const world::Links& links = members_.ensemble.links();
    constexpr std::size_t kAhead = 8;
    for (std::size_t i = 0; i < changes.size(); ++i) {
        const eval::Change& change = changes[i];
        if (i + kAhead < changes.size()) links.ask_ahead(changes[i + kAhead].catom);
        each_reader(links, change.catom, [&](Catom reader, world::Port port, std::int32_t index) {
            if (index == static_cast<std::int32_t>(change.catom) && members_.ensemble.state(reader) == kCatomOwned)
                open_mailbox(reader, port, change.catom, Holds::AllThatIsSaid);
        });
    }
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
    if (versions_ || now % kBetween != 0) return;
    for (u32 number = 0; number < mailboxes_.size(); ++number) {
        Mailbox& m = mailboxes_[number];
        if (m.index < 0 || m.under_way > 0 || m.last >= now || m.differs || has_news(m)) continue;
        m.differs = !holds_what_is_said(m);
        if (m.differs) continue;
        members_.ensemble.links().read_at(m.reader, m.port, static_cast<std::int32_t>(m.other));
        close_mailbox(number);
    }
}

void Network::tell_state(i64 now, u32 mailbox) {
    ByteWriter state;
    facts_.columns.pack(mailboxes_[mailbox].other, tuple::Columns::Which::Exported, state);
    const u32 parcel = take_parcel(ParcelKind::State, 0, state.view());
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

// ---- parcels

u32 Network::take_parcel(ParcelKind kind, u16 number, std::span<const std::byte> bytes) {
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

void Network::put_at(std::size_t slot, u32 mailbox, u32 parcel, bool late) {
    MELD_EXPECT(slot < ring_.size(), "slot {} of {}", slot, ring_.size());
    ring_[slot].push_back({mailbox, parcel, late});
    ++mailboxes_[mailbox].under_way;
    ++parcels_[parcel].links;
    ++under_way_;
}

void Network::post(i64 now, u32 mailbox, u32 parcel, bool linear) {
    const Mailbox& m = mailboxes_[mailbox];
    post(now, slot(now), mailbox, parcel, linear, fates_.of(m.part, m.other, m.reader, now));
}

void Network::post(i64 now, std::size_t slot_now, u32 mailbox, u32 parcel, bool linear, const world::Fate& fate) {
    Mailbox& m = mailboxes_[mailbox];
    const bool reorder = fates_.terms(m.part).reorder;
    const auto arrival = [&](u32 ticks) { return fates_.acts_from(m.reader, now + ticks); };
    if (!fate.arrives) {
        lost_ += linear;
        // Whatever comes after it would be behind it, and finds the link down.
        m.last = std::max(m.last, now + fate.ticks);
        return fates_.lose(now + fate.ticks, m.other, m.reader);
    }
    // A division takes longer than all else here.
    const auto put_after = [&](i64 tick) {
        const std::size_t at = slot_now + static_cast<std::size_t>(tick - now);
        put_at(at < ring_.size() ? at : at - ring_.size(), mailbox, parcel, false);
    };
    // What was sent before arrives before, unless it may be overtaken.
    const i64 at = arrival(fate.ticks);
    m.last = reorder ? at : std::max(m.last, at);
    put_after(m.last);
    if (fate.twice_after != 0) put_after(std::max(reorder ? 0 : m.last, arrival(fate.twice_after)));
}

void Network::changed(i64 now, std::span<const eval::Change> changes) {
    MELD_EXPECT(follows_changes(), "{} changes", changes.size());
    // Their readers and mailboxes lie anywhere in memory: those of so many are asked for, one step after the other, before any is needed.
    constexpr std::size_t kTogether = 16;
    const world::Links& links = members_.ensemble.links();
    std::array<std::size_t, kTogether> ends;
    std::vector<Reader> readers;
    Posting posting{.now = now, .slot = slot(now)};
    for (std::size_t first = 0; first < changes.size(); first += kTogether) {
        const std::span<const eval::Change> some = changes.subspan(first, std::min(kTogether, changes.size() - first));
        for (const eval::Change& each : some) links.ask_ahead(each.catom);
        readers.clear();
        std::size_t place = 0;
        for (const eval::Change& each : some) {
            links.each(each.catom, [&](world::Port port, Catom other) {
                const Reader& reader = readers.emplace_back(other, links.port_there(each.catom, port), -1, port);
                links.ask_ahead_read(reader.catom, reader.port);
            });
            ends[place++] = readers.size();
        }
        const auto number_at = [&](const Reader& reader) -> const u32* {
            const std::int32_t index = links.read(reader.catom, reader.port);
            return index >= 0 && static_cast<std::size_t>(index) < number_of_.size() ? &number_of_[static_cast<std::size_t>(index)]
                                                                                     : nullptr;
        };
        for (const Reader& reader : readers)
            if (const u32* const number = number_at(reader)) ask_for(number);
        for (const Reader& reader : readers)
            if (const u32* const number = number_at(reader); number != nullptr && *number != kNone32) ask_for(&mailboxes_[*number]);
        std::size_t from = 0;
        for (place = 0; place < some.size(); ++place) {
            const std::size_t to = ends[place];
            changed(posting, some[place], std::span<const Reader>(readers).subspan(from, to - from));
            from = to;
        }
    }
}

void Network::changed(Posting& posting, const eval::Change& change, std::span<const Reader> readers) {
    const auto [catom, column] = change;
    const i64 now = posting.now;
    const world::Links& links = members_.ensemble.links();
    std::optional<u32> parcel;
    std::array<world::Fate, kReadersAtOnce> fates;
    for (std::size_t i = 0; i < readers.size(); ++i) {
        const std::size_t place = i % kReadersAtOnce;
        if (fates_.same_terms() && place == 0) {
            const std::size_t count = std::min<std::size_t>(kReadersAtOnce, readers.size() - i);
            fates_.of(catom, readers.subspan(i, count), now, {fates.data(), count});
        }
        const auto [reader, port, _, from] = readers[i];
        if (members_.ensemble.state(reader) != kCatomOwned) {
            fates_.note_loss(now, catom, reader);
            continue;
        }
        // Another column of this catom may have opened it.
        const std::int32_t index = links.read(reader, port);
        if (index < 0) continue;
        const u32 mailbox = static_cast<Catom>(index) == catom ? open_mailbox(reader, port, catom, Holds::AllThatIsSaid)
                                                               : number_of_[static_cast<std::size_t>(index)];
        if (!parcel) {
            ByteWriter& bytes = posting.bytes;
            bytes.clear();
            const tuple::ChangeLog& log = facts_.columns.changes();
            const bool rows = log.follows(column);
            if (rows) {
                const RowChanges& c = *log.of(column, catom);
                bytes.write(c.removed);
                bytes.write(c.added);
                bytes.write_bytes(&c + 1, module_.columns[column].row_bytes * (std::size_t{c.removed} + c.added));
            } else {
                facts_.columns.pack_column(column, catom, bytes);
            }
            parcel = take_parcel(rows ? ParcelKind::Rows : ParcelKind::Column, column, bytes.view());
        }
        if (fates_.same_terms())
            post(now, posting.slot, mailbox, *parcel, false, fates[place]);
        else
            post(now, mailbox, *parcel, false);
    }
    if (parcel && parcels_[*parcel].links == 0) release_parcel(*parcel);
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
    const u32 parcel = take_parcel(ParcelKind::Message, predicate, argument_bytes(predicate, arguments));
    post(now, *mailbox, parcel, true);
    if (parcels_[parcel].links == 0) release_parcel(parcel);
}

// ---- arrivals

bool Network::comes_in(i64 now, const Entry& entry) {
    const Mailbox& m = mailboxes_[entry.mailbox];
    const i64 free = m.index < 0 ? now : fates_.jammed_until(now, m.other, m.reader);
    if (m.index >= 0 && free == now) return true;
    if (m.index < 0 || world_.network.kind == world::NetworkKind::Raw)
        lost_ += parcels_[entry.parcel].kind == ParcelKind::Message;
    else
        put(fates_.acts_from(m.reader, free), entry.mailbox, entry.parcel, true);
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
    const auto is_other = [&](const Entry& entry) { return (parcels_[entry.parcel].kind == ParcelKind::Message) != linear; };
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

void Network::give_back_entries(i64 tick, std::vector<Entry>&& entries) {
    std::vector<Entry>& here = arriving(tick);
    if (!here.empty() || entries.capacity() <= here.capacity()) return;
    entries.clear();
    here.swap(entries);
}

void Network::arrive(i64 now) {
    if (versions_) return versions_->arrive(now);
    std::vector<Entry> entries = take_entries(now, false);
    // They lie anywhere in memory, so what the next ones need is asked for ahead.
    constexpr std::size_t kFirst = 24, kThen = 16, kLast = 8;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (i + kFirst < entries.size()) {
            __builtin_prefetch(&mailboxes_[entries[i + kFirst].mailbox]);
            __builtin_prefetch(&parcels_[entries[i + kFirst].parcel]);
        }
        if (i + kThen < entries.size()) ask_ahead(entries[i + kThen]);
        if (i + kLast < entries.size()) ask_ahead_rows(entries[i + kLast]);
        const Entry& entry = entries[i];
        mailboxes_[entry.mailbox].differs = false;
        if (comes_in(now, entry)) open(mailboxes_[entry.mailbox], parcels_[entry.parcel]);
        done_with(entry);
    }
    give_back_entries(now, std::move(entries));
}

void Network::deliver(i64 next, const Deliver& deliver) {
    std::vector<Arrived> messages;
    std::deque<std::vector<Value>> arguments;
    tuple::Arena lists;
    std::vector<Entry> entries = take_entries(next, true);
    for (const Entry& entry : entries) {
        if (comes_in(next, entry)) {
            const Mailbox& m = mailboxes_[entry.mailbox];
            const Parcel& parcel = parcels_[entry.parcel];
            messages.push_back(
                {m.reader, members_.ensemble.id(m.other), parcel.number, read_arguments(parcel.number, parcel.bytes, arguments, lists)});
        }
        done_with(entry);
    }
    give_back_entries(next, std::move(entries));
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

// For open(), in two steps.
void Network::ask_ahead(const Entry& entry) const {
    const Mailbox& m = mailboxes_[entry.mailbox];
    const Parcel& parcel = parcels_[entry.parcel];
    ask_for(parcel.bytes.data());
    if (m.index < 0 || parcel.kind != ParcelKind::Column) return;
    ask_for(facts_.columns.entry(parcel.number, static_cast<Catom>(m.index)));
}

void Network::ask_ahead_rows(const Entry& entry) const {
    const Mailbox& m = mailboxes_[entry.mailbox];
    const Parcel& parcel = parcels_[entry.parcel];
    if (m.index < 0 || parcel.kind != ParcelKind::Column || !module_.columns[parcel.number].rows) return;
    ask_for(facts_.columns.rows(parcel.number, static_cast<Catom>(m.index)).data);
}

void Network::open(const Mailbox& m, const Parcel& parcel) {
    const auto index = static_cast<Catom>(m.index);
    ByteReader in(parcel.bytes, "what is under way over a link");
    switch (parcel.kind) {
        case ParcelKind::Column:
            facts_.columns.unpack_column(parcel.number, index, in, 0);
            break;
        case ParcelKind::Rows: {
            const auto removed = in.read<u32>(), added = in.read<u32>();
            RowChanges* changes = facts_.columns.changes().make(parcel.number, removed, added, 0);
            const auto rows = in.read_bytes(module_.columns[parcel.number].row_bytes * (std::size_t{removed} + added));
            std::memcpy(changes + 1, rows.data(), rows.size());
            facts_.columns.change_rows(parcel.number, index, changes, 0);
            break;
        }
        case ParcelKind::State:
            facts_.columns.unpack(index, tuple::Columns::Which::Exported, in, 0);
            return facts_.mark(m.reader, readers_dirty_);
        case ParcelKind::Message:
            MELD_CHECK(false, "a linear fact is given, not put into a mailbox");
    }
    // Nobody need look at what no rule reads.
    if (const u64 bits = module_.columns[parcel.number].reader_dirty; bits != 0) facts_.mark(m.reader, bits);
}

// ---- snapshots

void Network::save(i64 now, ByteWriter& out) const {
    if (versions_)
        versions_->save(now, out);
    else
        save_mailboxes(now, out);
    fates_.save(out);
    save_far(now, out);
}

void Network::save_mailboxes(i64 now, ByteWriter& out) const {
    const world::Ensemble& ensemble = members_.ensemble;
    u64 count = 0;
    each_link_read(members_.ensemble, [&](Catom, world::Port, Catom, Catom) { ++count; });
    out.write_count(count);
    std::vector<u32> saved(mailboxes_.size(), kNone32);
    u32 next = 0;
    each_link_read(members_.ensemble, [&](Catom reader, world::Port, Catom other, Catom index) {
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
    for (const Parcel& parcel : parcels_) write(out, SavedParcel{parcel.kind, parcel.number, parcel.bytes});
    out.write_count(under_way_);
    for (u32 ticks = 1; ticks <= ring_.size(); ++ticks)
        for (const Entry& entry : ring_[(static_cast<std::size_t>(now) + ticks) % ring_.size()])
            write(out, SavedEntry{ticks, saved[entry.mailbox], entry.parcel, entry.late});
}

void Network::load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    if (in.done()) {
        if (versions_) return versions_->tell_all(now);
        std::vector<Link> all;
        if (!exported_.empty())
            each_link_read(members_.ensemble,
                           [&](Catom reader, world::Port port, Catom other, Catom) { all.push_back({reader, port, other}); });
        for (const Link& link : all) tell_state(now, open_mailbox(link.reader, link.port, link.other, Holds::Nothing));
        return;
    }
    if (!(versions_ ? versions_->load(now, find, takes_lost, in) : load_mailboxes(now, find, takes_lost, in))) return;
    // Each process has noted those that it may have to take down.
    fates_.load(in);
    load_far(now, find, takes_lost, in);
}

bool Network::load_mailboxes(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    const world::Ensemble& ensemble = members_.ensemble;
    std::vector<std::optional<Link>> links;
    ByteWriter said;
    each_saved_link(
        in, [&](std::size_t count) { links.resize(count); },
        [&](std::size_t number, const SavedLink& saved) {
            const auto reader = find(saved.reader);
            const auto other = ensemble.find(saved.other);
            // Else it is one of another process.
            if (!reader || !other) return;
            const std::optional<world::Port> port = ensemble.links().towards(*reader, *other);
            if (!port || ensemble.links().read(*reader, *port) < 0) return;
            links[number] = {*reader, *port, *other};
            // Where turns are given, changes may have arrived for a reader that has not had its own: it reads all of it.
            const bool reads_all = world_.clock.gives_turns() && readers_dirty_ != 0 && facts_.evaluator.agenda().dirty(*reader) != 0;
            said.clear();
            facts_.columns.pack(*other, tuple::Columns::Which::Exported, said);
            if (saved.last > now || !std::ranges::equal(said.view(), saved.known)) {
                Mailbox& m = mailboxes_[open_mailbox(*reader, *port, *other, Holds::Nothing)];
                m.last = saved.last;
                ByteReader state(saved.known, "what has arrived over a link", ByteReader::Origin::Outside);
                facts_.columns.unpack(static_cast<Catom>(m.index), tuple::Columns::Which::Exported, state, 0);
                // Its rows are no news to the reader.
                if (!reads_all) facts_.columns.changes().forget(static_cast<Catom>(m.index));
            }
            if (reads_all) facts_.mark(*reader, readers_dirty_);
        });
    if (in.failed()) return false;
    const std::vector<SavedParcel> read = read_parcels(in);
    std::vector<u32> parcels(read.size(), kNone32);
    u32 gone = kNone32;  // A mailbox whose link is gone.
    return each_saved_entry(in, read.size(), [&](const SavedEntry& entry) {
        if (entry.link == kNone32 && takes_lost && gone == kNone32) {
            gone = static_cast<u32>(mailboxes_.size());
            mailboxes_.emplace_back();
        }
        u32 to = gone;
        if (entry.link != kNone32) {
            if (entry.link >= links.size() || !links[entry.link]) return;
            to = *mailbox_at(links[entry.link]->reader, links[entry.link]->port);
        }
        if (to == kNone32) return;
        u32& parcel = parcels[entry.parcel];
        if (parcel == kNone32) parcel = take_parcel(read[entry.parcel].kind, read[entry.parcel].number, read[entry.parcel].bytes);
        // This world's network may be faster.
        put(now + std::min<i64>(entry.ticks, world_.latency()), to, parcel, entry.late);
    });
}

std::size_t Network::bytes() const {
    std::size_t all = mailboxes_.capacity() * sizeof(Mailbox) + parcels_.capacity() * sizeof(Parcel) + number_of_.capacity() * sizeof(u32);
    for (const auto& slot : ring_) all += slot.capacity() * sizeof(Entry);
    for (const Parcel& parcel : parcels_) all += parcel.bytes.capacity();
    for (const Far& far : far_) all += sizeof far + far.bytes.capacity();
    return all + fates_.bytes() + (versions_ ? versions_->bytes() : 0);
}

}  // namespace meld::sim
