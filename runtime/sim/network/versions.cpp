#include "runtime/sim/network/versions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "runtime/base/prefetch.h"
#include "runtime/engine/tuple/copy_record.h"

namespace meld::sim {

bool Versions::suit(const ModuleInfo& module, const world::World& world) {
    if (world.network.kind == world::NetworkKind::Raw || world.clock.gives_turns()) return false;
    for (u32 p = 0; p < module.predicate_count; ++p)
        if (module.predicates[p].kind == PredicateKind::Linear && module.predicates[p].column != kNone16) return false;
    constexpr u32 kMostColumns = 64;
    u32 exported = 0;
    for (u32 c = 0; c < module.column_count; ++c) {
        if (!module.columns[c].exported) continue;
        // Readers are told which of its rows have changed, which is not known of those that follow another version.
        if (module.columns[c].compare_groups != nullptr) return false;
        ++exported;
    }
    return exported > 0 && exported <= kMostColumns;
}

// The ticks that every message takes, if that is known; otherwise 0.
static u32 same_ticks(const world::World& world) {
    const world::NetworkOptions& network = world.network;
    const bool same = network.kind != world::NetworkKind::Lossy && network.terms.least == network.terms.most && network.parts.empty() &&
                      network.singles.empty() && world.clock.synchronous() && world.longest_jam == 0;
    return same ? network.terms.least : 0;
}

Versions::Versions(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, Fates& fates,
                   const SubdomainView& subdomain)
    : module_(module),
      world_(world),
      members_(members),
      facts_(facts),
      fates_(fates),
      subdomain_(subdomain),
      same_ticks_(same_ticks(world)),
      indices_(members, facts),
      ring_(world.latency() + std::size_t{2}) {
    if (keeps_last()) members_.ensemble.links().keep_last_arrivals();
    for (u16 c = 0; c < module.column_count; ++c) {
        const ColumnInfo& column = module.columns[c];
        if (!column.exported) continue;
        exported_.push_back(c);
        readers_dirty_ |= column.reader_dirty;
        has_lists_ = has_lists_ || column.list_count > 0;
        has_rows_ = has_rows_ || column.rows;
        if (column.reader_dirty != 0 && facts.evaluator.can_concern(c)) asked_.push_back(c);
    }
    for (std::size_t place = 0; place < exported_.size(); ++place) add_kind(u64{1} << place);
    add_kind(0);
}

// ---- versions

// For one more, without doubling what is large.
template <class Array>
static void make_room(Array& all) {
    constexpr std::size_t kLeast = 64, kShare = 8;
    if (all.size() == all.capacity()) all.reserve(all.size() + all.size() / kShare + kLeast);
}

void Versions::add_kind(u64 columns) {
    Kind kind{columns};
    for (u64 left = columns; left != 0; left &= left - 1) {
        const u16 column = exported_[static_cast<std::size_t>(std::countr_zero(left))];
        if (std::ranges::binary_search(asked_, column))
            kind.asks |= left & -left;
        else
            kind.marks |= module_.columns[column].reader_dirty;
    }
    kind_of_[columns] = static_cast<u32>(kinds_.size());
    kinds_.push_back(kind);
}

u32 Versions::kind_with(u32 kind, u32 place) {
    const u64 columns = kinds_[kind].columns | u64{1} << place;
    if (!kind_of_.contains(columns)) add_kind(columns);
    return kind_of_[columns];
}

u32 Versions::place(u16 column) const { return static_cast<u32>(std::ranges::lower_bound(exported_, column) - exported_.begin()); }

Catom Versions::take(Catom catom, Holds holds) {
    const Catom index = indices_.take(catom);
    if (versions_.empty()) first_ = index;
    // A catom that has gone may have left an index before the first.
    if (index < first_) {
        versions_.insert(versions_.begin(), first_ - index, Version());
        first_ = index;
    }
    while (!is_version(index)) {
        make_room(versions_);
        versions_.emplace_back();
    }
    // Word by word, also where it is set and read: what has just been written in parts is not there yet for whoever reads the whole.
    Version& version = version_at(index);
    version.catom = catom;
    version.needed = version.since = 0;
    version.kind = no_kind() & Version::kMostKind;
    version.said = version.dated = version.alone = 0;
    if (const auto soon = indices_.soon(); soon && is_version(*soon)) ask_for(&version_at(*soon));
    if (holds == Holds::Nothing) facts_.columns.clear(index, 0);
    return index;
}

void Versions::keep(Catom catom, Catom index) {
    for (const u16 column : exported_)
        if (has_lists_ || module_.columns[column].rows)
            facts_.columns.copy(column, catom, index, 0);
        else
            tuple::copy_record(facts_.columns.entry(column, index), facts_.columns.entry(column, catom), module_.columns[column].stride);
}

void Versions::give_back(Catom index) {
    const Version& version = version_at(index);
    if (version.said != 0) current_[version.catom] = kGone;
    indices_.give_back(index, has_lists_ ? MailboxIndices::Leaves::Nothing : MailboxIndices::Leaves::WhatItHolds);
    // What is short keeps its memory for the next.
    constexpr std::size_t kShort_bytes = 64;
    if (!has_rows_) return;
    for (const u16 column : exported_)
        if (module_.columns[column].rows && facts_.columns.rows(column, index).capacity * module_.columns[column].row_bytes > kShort_bytes)
            facts_.columns.set_rows(column, index, nullptr, 0, 0);
}

void Versions::set_current(Catom catom, Catom index) {
    if (catom >= current_.size()) current_.resize(members_.ensemble.index_count(), kGone);
    current_[catom] = index;
}

bool Versions::is_said(Catom catom, Catom index) const {
    return std::ranges::all_of(exported_, [&](u16 column) { return facts_.columns.same(column, index, catom); });
}

// ---- changes

void Versions::change(i64 now, std::span<const eval::Change> changes) {
    // Their readers lie anywhere in memory: where those of so many catoms read is asked for before it is looked at.
    constexpr std::size_t kTogether = 16;
    const world::Links& links = members_.ensemble.links();
    const auto some = [&](std::size_t first) {
        first = std::min(first, changes.size());
        return changes.subspan(first, std::min(kTogether, changes.size() - first));
    };
    const auto ask_ahead = [&](Catom catom) {
        links.ask_ahead(catom);
        // The end of its row, which most often lies before that of the next.
        if (std::size_t{catom} + 1 < current_.size()) links.ask_ahead(catom + 1);
        if (catom < current_.size()) ask_for(&current_[catom]);
    };
    for (const eval::Change& each : some(0)) ask_ahead(each.catom);
    for (std::size_t first = 0; first < changes.size(); first += kTogether) {
        for (const eval::Change& each : some(first + kTogether)) ask_ahead(each.catom);
        std::array<std::size_t, kTogether> ends;
        std::size_t place = 0;
        readers_.clear();
        for (const eval::Change& each : some(first)) {
            links.each_end(each.catom, [&](world::Port port, Catom other, world::Port there) {
                *readers_.add() = {other, there, -1, port};
                links.ask_ahead_read(other, there);
            });
            ends[place++] = readers_.size();
            if (const Catom index = current(each.catom); index != kGone) {
                ask_for(&version_at(index));
                ask_for(facts_.columns.entry(each.column, index));
            }
        }
        place = 0;
        std::size_t from = 0;
        for (const eval::Change& each : some(first)) {
            const std::size_t to = ends[place++];
            change(now, each, readers_.view().subspan(from, to - from));
            from = to;
        }
    }
}

void Versions::change(i64 now, const eval::Change& change, std::span<const Reader> readers) {
    const Catom catom = change.catom;
    world::Links& links = members_.ensemble.links();
    Catom copy = current(catom);
    if (copy != kGone) {
        Version& version = version_at(copy);
        if (version.dated != 0 && version.since == static_cast<u32>(now)) {
            // Another column changes in this tick: what was said before is kept already, and this travels with it.
            version.kind = kind_with(version.kind, place(change.column)) & Version::kMostKind;
            return;
        }
        // Who still waits for what it says now gets the copy.
        version.said = 0;
        keep(catom, copy);
    }
    const bool all_here = members_.ensemble.ghost_count() == 0;
    u32 reading = 0;
    for (const Reader& reader : readers) {
        if (links.read(reader.catom, reader.port) != static_cast<std::int32_t>(catom)) continue;
        if (!all_here && members_.ensemble.state(reader.catom) != kCatomOwned) continue;
        if (copy == kGone) {
            copy = take(catom, Holds::Anything);
            keep(catom, copy);
        }
        links.read_at(reader.catom, reader.port, static_cast<std::int32_t>(copy));
        ++reading;
    }
    if (copy != kGone) version_at(copy).needed += reading;
    const Catom index = take(catom, Holds::Anything);
    Version& version = version_at(index);
    version.since = static_cast<u32>(now);
    version.kind = place(change.column) & Version::kMostKind;
    version.said = version.dated = 1;
    set_current(catom, index);
    for (std::size_t first = 0; first < readers.size(); first += kReadersAtOnce)
        post(now, index, readers.subspan(first, std::min<std::size_t>(kReadersAtOnce, readers.size() - first)), false);
    leave(index);
}

[[gnu::always_inline]] inline void Versions::push(Entries& entries, const Entry& entry) {
    // Memory of a tick that has passed is enough for those of the next.
    if (entries.capacity() == 0 && entries_.empty()) [[unlikely]]
        entries.swap(entries_);
    Entry* const place = entries.add();
    // Some lines of the cache ahead: more is written here than waits for its line otherwise.
    constexpr std::size_t kAhead = 24;
    __builtin_prefetch(place + kAhead, 1);
    *place = entry;
}

void Versions::post(i64 now, Catom index, std::span<const Reader> readers, bool whole) {
    const Catom catom = version_at(index).catom;
    world::Links& links = members_.ensemble.links();
    std::array<Reader, kReadersAtOnce> here;
    if (members_.ensemble.ghost_count() > 0 || links.has_changes()) {
        std::size_t count = 0;
        for (const Reader& reader : readers)
            // Another process has what is known of a link, but both know what is lost.
            if (members_.ensemble.state(reader.catom) != kCatomOwned)
                fates_.note_loss(now, catom, reader.catom);
            else if (links.read(reader.catom, reader.port) >= 0)
                here[count++] = reader;
        readers = {here.data(), count};
    }
    if (same_ticks_ > 0) {
        Entries& entries = arriving(now + same_ticks_);
        for (const Reader& reader : readers) push(entries, {index, reader.catom, reader.port, whole});
        under_way_ += readers.size();
        version_at(index).needed += static_cast<u32>(readers.size());
        return;
    }
    world::Links::LastArrivals last = links.last_arrivals(catom, now);
    const std::size_t this_slot = slot(now);
    // What was sent before arrives before; what comes after something that is lost finds the link down.
    const auto put_after = [&](const Reader& reader, i64 ticks) {
        // A division takes longer than all else here.
        std::size_t its_slot = this_slot + static_cast<std::size_t>(ticks);
        if (its_slot >= ring_.size()) its_slot -= ring_.size();
        MELD_EXPECT(its_slot == slot(now + ticks), "tick {} from {}", now + ticks, now);
        push(ring_[its_slot], {index, reader.catom, reader.port, whole});
    };
    u32 sent = 0;
    if (fates_.only_delays()) {
        std::array<u32, kReadersAtOnce> delays;
        fates_.delays(catom, readers, now, {delays.data(), readers.size()});
        for (std::size_t i = 0; i < readers.size(); ++i) {
            const i64 ticks = std::max<i64>(last.ticks(readers[i].from), delays[i]);
            last.set(readers[i].from, ticks);
            put_after(readers[i], ticks);
        }
        sent = static_cast<u32>(readers.size());
    } else {
        std::array<world::Fate, kReadersAtOnce> fates;
        fates_.of(catom, readers, now, {fates.data(), readers.size()});
        for (std::size_t i = 0; i < readers.size(); ++i) {
            const Reader& reader = readers[i];
            const i64 at = fates[i].arrives ? fates_.acts_from(reader.catom, now + fates[i].ticks) - now : i64{fates[i].ticks};
            const i64 ticks = std::max(last.ticks(reader.from), at);
            last.set(reader.from, ticks);
            if (!fates[i].arrives) {
                fates_.lose(now + at, catom, reader.catom);
                continue;
            }
            put_after(reader, ticks);
            ++sent;
        }
    }
    under_way_ += sent;
    version_at(index).needed += sent;
}

void Versions::put(i64 arrival, const Entry& entry) {
    push(arriving(arrival), entry);
    ++under_way_;
    ++version_at(entry.index).needed;
}

// ---- links

void Versions::follow_links(i64 now, bool tells) {
    world::Ensemble& ensemble = members_.ensemble;
    // Here every tick passes: nothing that has arrived seems to be to come, however long a run is.
    if (now > 0 && now % world::Links::kForgetTicks == 0) ensemble.links().forget_arrivals(now);
    const std::vector<world::Links::Change> changes = ensemble.links().take_changes();
    if (changes.empty()) return facts_.resize(ensemble.index_count());
    std::vector<Link> gone;
    for (const world::Links::Change& link : changes) {
        // What it holds of a link is there as long as it can read over it.
        facts_.touch(link.reader);
        fates_.forget_turn(link.reader);
        if (link.made) continue;
        stop_reading(link.read, link.other);
        gone.push_back({link.reader, link.port});
    }
    if (under_way_ > 0 && !gone.empty()) cancel(gone);
    for (const world::Links::Change& link : changes) {
        // It may be gone again already.
        if (!link.made || link.port >= ensemble.links().ports(link.reader) || ensemble.links().at(link.reader, link.port) != link.other)
            continue;
        // Before the first tick nobody has anything to tell.
        const bool told = tells && now > 1;
        if (ensemble.state(link.reader) != kCatomOwned) {
            if (told) fates_.note_loss(now - 1, link.other, link.reader);
            continue;
        }
        if (ensemble.links().read(link.reader, link.port) >= 0) continue;
        // As if the neighbour had told all of it at the end of the last tick.
        if (told)
            tell(now - 1, link.reader, link.port, link.other);
        else
            ensemble.links().read_at(link.reader, link.port, static_cast<std::int32_t>(link.other));
    }
    facts_.resize(ensemble.index_count());
}

void Versions::cancel(const std::vector<Link>& links) {
    std::vector<u64> keys;
    for (const Link& link : links) keys.push_back(key_of(link.reader, link.port));
    std::ranges::sort(keys);
    std::vector<bool> reads(members_.ensemble.index_count());
    for (const Link& link : links) reads[link.reader] = true;
    for (Entries& entries : ring_) {
        const auto lost = erase_if(entries, [&](const Entry& entry) {
            if (entry.index == kGone || !reads[entry.reader] || !std::ranges::binary_search(keys, key_of(entry.reader, entry.port)))
                return false;
            release(entry.index);
            return true;
        });
        // A run waits for it all the same.
        if (lost > 0) put_gone(entries, static_cast<u32>(lost));
    }
}

void Versions::tell(i64 now, Catom reader, world::Port port, Catom other) {
    world::Links& links = members_.ensemble.links();
    const Catom nothing = take(other, Holds::Nothing);
    version_at(nothing).needed = 1;
    links.read_at(reader, port, static_cast<std::int32_t>(nothing));
    if (current(other) == kGone) {
        set_current(other, take(other, Holds::Anything));
        version_at(current(other)).said = 1;
    }
    const Reader one = {reader, port, static_cast<std::int32_t>(nothing), links.port_there(reader, port)};
    const Catom index = current(other);
    post(now, index, {&one, 1}, true);
    leave(index);
}

void Versions::tell_all(i64 now) {
    std::vector<Reader> all;
    each_link_read(members_.ensemble, [&](Catom reader, world::Port port, Catom other, Catom) { all.push_back({reader, port, 0, other}); });
    for (const Reader& link : all) tell(now, link.catom, link.port, link.from);
}

// ---- arrivals

void Versions::arrive(i64 now) {
    if (arriving(now).empty()) return;
    entries_.swap(arriving(now));
    under_way_ -= entries_.size();
    if (world_.longest_jam > 0) {
        // What has waited for the end of a jam was sent before what comes in its time.
        std::ranges::stable_partition(entries_, [](const Entry& entry) { return entry.late != 0; });
        erase_if(entries_, [&](const Entry& entry) { return held_up(now, entry); });
    }
    if (gone_ > 0)
        erase_if(entries_, [&](const Entry& entry) {
            if (entry.index != kGone) return false;
            under_way_ -= entry.reader - 1;
            --gone_;
            return true;
        });
    // Of so many at a time all that they need is asked for, one step after the other, since it lies anywhere in memory; of the next ones
    // the first step.
    const world::Links& links = members_.ensemble.links();
    const auto ask = [&](std::size_t first) {
        for (std::size_t i = first; i < std::min(first + kOpenedAtOnce, entries_.size()); ++i) {
            links.ask_ahead_read(entries_[i].reader, entries_[i].port);
            ask_for(&version_at(entries_[i].index));
        }
    };
    ask(0);
    for (std::size_t first = 0; first < entries_.size(); first += kOpenedAtOnce) {
        ask(first + kOpenedAtOnce);
        open(entries_.view().subspan(first, std::min(kOpenedAtOnce, entries_.size() - first)));
    }
    entries_.clear();
}

void Versions::put_gone(Entries& entries, u32 links) {
    *entries.add() = {kGone, links, 0, false};
    ++gone_;
}

bool Versions::held_up(i64 now, const Entry& entry) {
    if (entry.index == kGone) return false;
    const i64 free = fates_.jammed_until(now, version_at(entry.index).catom, entry.reader);
    if (free == now) return false;
    Entry later = entry;
    later.late = 1;
    put(fates_.acts_from(entry.reader, free), later);
    release(entry.index);
    return true;
}

void Versions::open(std::span<const Entry> entries) {
    world::Links& links = members_.ensemble.links();
    std::array<Catom, kOpenedAtOnce> readers;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        // For now, where the reader reads.
        readers[i] = static_cast<Catom>(links.read(entries[i].reader, entries[i].port));
        if (is_version(readers[i])) ask_for(&version_at(readers[i]));
    }
    for (const u16 column : asked_) {
        const u8* const first = facts_.columns.entry(column, 0);
        const std::size_t stride = module_.columns[column].stride;
        for (std::size_t i = 0; i < entries.size(); ++i) {
            ask_for(first + readers[i] * stride);
            ask_for(first + place_of(entries[i].index) * stride);
            ask_for(first + entries[i].reader * stride);
        }
    }
    for (auto next = entries.begin(); next != entries.end();) {
        const Entry& first = *next;
        const Version& version = version_at(first.index);
        const std::int32_t before = links.read(first.reader, first.port);
        MELD_EXPECT(before >= 0, "catom {} port {}", first.reader, first.port);
        const auto reads = static_cast<Catom>(before);
        // Where a run has gone on, the last one of those that are under way is what the catom says.
        const bool said = version.said != 0 || (version.alone != 0 && is_said(version.catom, first.index));
        const Catom catom = version.catom, to = said ? catom : first.index;
        // Those who have read the same are looked at together.
        u32 count = 0;
        do {
            links.read_at(next->reader, next->port, static_cast<std::int32_t>(to));
            readers[count++] = next->reader;
            ++next;
        } while (first.whole == 0 && next != entries.end() && next->index == first.index && next->whole == 0 &&
                 links.read(next->reader, next->port) == before);
        if (first.whole != 0)
            facts_.mark(first.reader, readers_dirty_);
        else
            mark_readers(version, reads, to, {readers.data(), count});
        // What is needed to arrive is needed to be read from then on.
        if (said || reads == to) release(first.index, count);
        if (reads != to && reads != catom) release(reads, count);
    }
}

void Versions::mark_readers(const Version& version, Catom before, Catom to, std::span<const Catom> readers) {
    const Kind& kind = kinds_[version.kind];
    // Nobody need look at what no rule reads.
    if ((kind.marks | kind.asks) == 0) return;
    if (kind.marks != 0) facts_.evaluator.agenda().mark_all(readers, kind.marks);
    for (u64 left = kind.asks; left != 0; left &= left - 1) {
        const u16 column = exported_[static_cast<std::size_t>(std::countr_zero(left))];
        facts_.evaluator.mark_concerned(subdomain_, {version.catom, column}, facts_.columns.entry(column, before),
                                        facts_.columns.entry(column, to), {reinterpret_cast<const i32*>(readers.data()), readers.size()});
    }
    if (!facts_.followed()) return;
    for (const Catom reader : readers) facts_.touch(reader);
}

std::size_t Versions::bytes() const {
    std::size_t all = versions_.capacity() * sizeof(Version) + entries_.capacity() * sizeof(Entry) + readers_.capacity() * sizeof(Reader) +
                      current_.capacity() * sizeof(Catom) + indices_.bytes();
    for (const auto& slot : ring_) all += slot.capacity() * sizeof(Entry);
    return all;
}

}  // namespace meld::sim
