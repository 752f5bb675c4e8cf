#include "runtime/sim/network/versions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/sim/network/saved_links.h"

namespace meld::sim {

bool Versions::suit(const ModuleInfo& module, const world::World& world) {
    if (world.network.kind == world::NetworkKind::Raw || world.clock.gives_turns()) return false;
    for (u32 p = 0; p < module.predicate_count; ++p)
        if (module.predicates[p].kind == PredicateKind::Linear && module.predicates[p].column != kNone16) return false;
    constexpr u32 kMostColumns = 64;
    u32 exported = 0;
    for (u32 c = 0; c < module.column_count; ++c) {
        if (!module.columns[c].exported) continue;
        if (module.columns[c].rows) return false;
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

Versions::Versions(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, Fates& fates)
    : module_(module),
      world_(world),
      members_(members),
      facts_(facts),
      fates_(fates),
      same_ticks_(same_ticks(world)),
      indices_(members, facts),
      ring_(world.latency() + std::size_t{2}) {
    if (keeps_last()) members_.ensemble.links().keep_last_arrivals();
    for (u16 c = 0; c < module.column_count; ++c) {
        if (!module.columns[c].exported) continue;
        exported_.push_back(c);
        readers_dirty_ |= module.columns[c].reader_dirty;
    }
}

// ---- versions

// For one more, without doubling what is large.
template <class Array>
static void make_room(Array& all) {
    constexpr std::size_t kLeast = 64, kShare = 8;
    if (all.size() == all.capacity()) all.reserve(all.size() + all.size() / kShare + kLeast);
}

u32 Versions::take_version(Catom catom) {
    u32 version = static_cast<u32>(versions_.size());
    if (free_versions_.empty()) {
        make_room(versions_);
        versions_.emplace_back();
    } else {
        version = free_versions_.back();
        free_versions_.pop_back();
        constexpr std::size_t kAhead = 8;
        if (free_versions_.size() > kAhead) ask_for(&versions_[free_versions_[free_versions_.size() - kAhead]]);
    }
    versions_[version] = {.catom = catom, .index = static_cast<std::int32_t>(catom)};
    return version;
}

std::int32_t Versions::take_index(u32 version, Holds holds) {
    Version& v = versions_[version];
    const Catom index = indices_.take(v.catom);
    if (copies_.empty()) first_copy_ = index;
    // A catom that has gone may have left an index before the first.
    if (index < first_copy_) {
        copies_.insert(copies_.begin(), first_copy_ - index, Copy());
        first_copy_ = index;
    }
    const std::size_t place = index - first_copy_;
    if (place >= copies_.size()) {
        if (place >= copies_.capacity()) copies_.reserve(place + place / 8 + 64);
        copies_.resize(place + 1);
    }
    copies_[place] = {version, v.under_way};
    v.index = static_cast<std::int32_t>(index);
    if (holds == Holds::AllThatIsSaid)
        for (const u16 column : exported_) facts_.columns.copy(column, v.catom, index, 0);
    return v.index;
}

void Versions::set_current(Catom catom, u32 version) {
    if (catom >= current_.size()) current_.resize(members_.ensemble.index_count(), kNone32);
    current_[catom] = version;
}

void Versions::leave(u32 version) {
    const Version& v = versions_[version];
    if (v.under_way > 0) return;
    if (current(v.catom) == version) current_[v.catom] = kNone32;
    free_versions_.push_back(version);
}

void Versions::release(u32 version) {
    Version& v = versions_[version];
    if (static_cast<Catom>(v.index) != v.catom) return release_copy(v.index);
    if (--v.under_way == 0) leave(version);
}

void Versions::release_copy(std::int32_t index) {
    Copy& copy = copy_at(index);
    MELD_EXPECT(copy.needed > 0, "nobody reads at {}", index);
    if (--copy.needed > 0) return;
    free_versions_.push_back(copy.version);
    indices_.give_back(static_cast<Catom>(index));
}

bool Versions::is_said(const Version& version) const {
    return std::ranges::all_of(exported_,
                               [&](u16 column) { return facts_.columns.same(column, static_cast<Catom>(version.index), version.catom); });
}

u64 Versions::bits_of(const Version& version) const {
    u64 bits = 0;
    for (u64 left = version.columns; left != 0; left &= left - 1)
        bits |= module_.columns[exported_[static_cast<std::size_t>(std::countr_zero(left))]].reader_dirty;
    return bits;
}

// ---- changes

void Versions::ask_ahead(Catom catom) const {
    members_.ensemble.links().ask_ahead(catom);
    if (catom < current_.size()) ask_for(&current_[catom]);
}

void Versions::before_change(i64 now, std::span<const Catom> catoms) {
    // Their readers lie anywhere in memory: where those of so many catoms read is asked for before it is looked at.
    constexpr std::size_t kTogether = 16;
    world::Links& links = members_.ensemble.links();
    const bool all_here = members_.ensemble.ghost_count() == 0;
    const auto some = [&](std::size_t first) {
        first = std::min(first, catoms.size());
        return catoms.subspan(first, std::min(kTogether, catoms.size() - first));
    };
    for (const Catom catom : some(0)) ask_ahead(catom);
    for (std::size_t first = 0; first < catoms.size(); first += kTogether) {
        for (const Catom catom : some(first + kTogether)) ask_ahead(catom);
        std::array<std::size_t, kTogether> ends;
        std::size_t place = 0;
        readers_.clear();
        for (const Catom catom : some(first)) {
            each_readers<Looks::WhoReads>(links, catom, [&](std::span<const Reader> readers) {
                for (const Reader& reader : readers) links.ask_ahead_read(reader.catom, reader.port);
                readers_.insert(readers_.end(), readers.begin(), readers.end());
            });
            ends[place++] = readers_.size();
            if (const u32 version = current(catom); version != kNone32) ask_for(&versions_[version]);
        }
        place = 0;
        std::size_t at = 0;
        for (const Catom catom : some(first)) {
            const std::size_t end = ends[place++];
            u32 version = current(catom);
            // Another column has changed in this tick, and what was said before is kept already.
            if (version != kNone32 && versions_[version].dated && versions_[version].since == static_cast<u32>(now)) {
                at = end;
                continue;
            }
            // Who still waits for what it says now gets the copy.
            std::int32_t copy = version != kNone32 ? take_index(version, Holds::AllThatIsSaid) : -1;
            for (; at < end; ++at) {
                const Reader& reader = readers_[at];
                if (links.read(reader.catom, reader.port) != static_cast<std::int32_t>(catom)) continue;
                if (!all_here && members_.ensemble.state(reader.catom) != kCatomOwned) continue;
                if (copy < 0) copy = take_index(take_version(catom), Holds::AllThatIsSaid);
                links.read_at(reader.catom, reader.port, copy);
                ++copy_at(copy).needed;
            }
            if (version != kNone32) current_[catom] = kNone32;
        }
    }
}

void Versions::changed(i64 now, Catom catom, u16 column) {
    const auto place = std::ranges::lower_bound(exported_, column) - exported_.begin();
    u32 version = current(catom);
    if (version != kNone32 && versions_[version].dated && versions_[version].since == static_cast<u32>(now)) {
        // It travels with what has changed before it in this tick.
        versions_[version].columns |= u64{1} << place;
        return;
    }
    MELD_EXPECT(version == kNone32, "catom {} changes without a copy", catom);
    version = take_version(catom);
    versions_[version].dated = true;
    versions_[version].since = static_cast<u32>(now);
    versions_[version].columns = u64{1} << place;
    set_current(catom, version);
    each_readers<Looks::WhoReads>(members_.ensemble.links(), catom,
                                  [&](std::span<const Reader> readers) { post(now, version, readers, false); });
    leave(version);
}

void Versions::post(i64 now, u32 version, std::span<const Reader> readers, bool whole) {
    const Catom catom = versions_[version].catom;
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
        for (const Reader& reader : readers) push(now + same_ticks_, {version, reader.catom, reader.port, whole});
        versions_[version].under_way += static_cast<u32>(readers.size());
        return;
    }
    std::array<world::Fate, kReadersAtOnce> fates;
    fates_.of(catom, readers, now, {fates.data(), readers.size()});
    u32 sent = 0;
    for (std::size_t i = 0; i < readers.size(); ++i) {
        const Reader& reader = readers[i];
        // What was sent before arrives before; what comes after something that is lost finds the link down.
        const i64 last = links.last_arrival(catom, reader.from, now);
        const i64 at = fates[i].arrives ? fates_.acts_from(reader.catom, now + fates[i].ticks) : now + fates[i].ticks;
        const i64 arrival = std::max(last, at);
        links.set_last_arrival(catom, reader.from, arrival);
        if (fates[i].arrives)
            push(arrival, {version, reader.catom, reader.port, whole}), ++sent;
        else
            fates_.lose(at, catom, reader.catom);
    }
    versions_[version].under_way += sent;
}

void Versions::push(i64 arrival, const Entry& entry) {
    std::vector<Entry>& entries = arriving(arrival);
    make_room(entries);
    entries.push_back(entry);
    ++under_way_;
}

void Versions::put(i64 arrival, const Entry& entry) {
    push(arrival, entry);
    Version& version = versions_[entry.version];
    if (static_cast<Catom>(version.index) == version.catom)
        ++version.under_way;
    else
        ++copy_at(version.index).needed;
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
    for (std::vector<Entry>& entries : ring_) {
        const auto lost = std::erase_if(entries, [&](const Entry& entry) {
            if (entry.version == kGone || !reads[entry.reader] || !std::ranges::binary_search(keys, key_of(entry.reader, entry.port)))
                return false;
            release(entry.version);
            return true;
        });
        // A run waits for it all the same.
        if (lost > 0) put_gone(entries, static_cast<u32>(lost));
    }
}

void Versions::tell(i64 now, Catom reader, world::Port port, Catom other) {
    world::Links& links = members_.ensemble.links();
    const std::int32_t nothing = take_index(take_version(other), Holds::Nothing);
    copy_at(nothing).needed = 1;
    links.read_at(reader, port, nothing);
    if (current(other) == kNone32) set_current(other, take_version(other));
    const Reader one = {reader, port, nothing, links.port_there(reader, port)};
    const u32 version = current(other);
    post(now, version, {&one, 1}, true);
    leave(version);
}

void Versions::tell_all(i64 now) {
    std::vector<Reader> all;
    each_link_read(members_.ensemble, [&](Catom reader, world::Port port, Catom other, Catom) { all.push_back({reader, port, 0, other}); });
    for (const Reader& link : all) tell(now, link.catom, link.port, link.from);
}

// ---- arrivals

void Versions::arrive(i64 now) {
    entries_.clear();
    entries_.swap(arriving(now));
    if (entries_.empty()) return;
    under_way_ -= entries_.size();
    if (world_.longest_jam > 0) {
        // What has waited for the end of a jam was sent before what comes in its time.
        std::ranges::stable_partition(entries_, [](const Entry& entry) { return entry.late != 0; });
        std::erase_if(entries_, [&](const Entry& entry) { return held_up(now, entry); });
    }
    if (gone_ > 0)
        std::erase_if(entries_, [&](const Entry& entry) {
            if (entry.version != kGone) return false;
            under_way_ -= entry.reader - 1;
            --gone_;
            return true;
        });
    // Of so many at a time all that they need is asked for, one step after the other, since it lies anywhere in memory; of the next ones
    // the first step.
    constexpr std::size_t kTogether = 64;
    const world::Links& links = members_.ensemble.links();
    const auto ask = [&](std::size_t first) {
        for (std::size_t i = first; i < std::min(first + kTogether, entries_.size()); ++i) {
            links.ask_ahead_read(entries_[i].reader, entries_[i].port);
            ask_for(&versions_[entries_[i].version]);
        }
    };
    ask(0);
    for (std::size_t first = 0; first < entries_.size(); first += kTogether) {
        ask(first + kTogether);
        open(std::span<const Entry>(entries_).subspan(first, std::min(kTogether, entries_.size() - first)));
    }
}

void Versions::put_gone(std::vector<Entry>& entries, u32 links) {
    entries.push_back({kGone, links, 0, false});
    ++gone_;
}

bool Versions::held_up(i64 now, const Entry& entry) {
    if (entry.version == kGone) return false;
    const i64 free = fates_.jammed_until(now, versions_[entry.version].catom, entry.reader);
    if (free == now) return false;
    Entry later = entry;
    later.late = 1;
    put(fates_.acts_from(entry.reader, free), later);
    release(entry.version);
    return true;
}

void Versions::open(std::span<const Entry> entries) {
    world::Links& links = members_.ensemble.links();
    for (const Entry& entry : entries)
        if (const auto place = static_cast<Catom>(links.read(entry.reader, entry.port)) - first_copy_; place < copies_.size())
            ask_for(&copies_[place]);
    u32 last = kNone32;
    u64 bits = 0;
    for (const Entry& entry : entries) {
        const Version& version = versions_[entry.version];
        if (entry.version != last || entry.whole != 0) {
            bits = entry.whole != 0 ? readers_dirty_ : bits_of(version);
            last = entry.whole != 0 ? kNone32 : entry.version;
        }
        const std::int32_t before = links.read(entry.reader, entry.port);
        MELD_EXPECT(before >= 0, "catom {} port {}", entry.reader, entry.port);
        const auto catom = static_cast<std::int32_t>(version.catom);
        // Where a run has gone on, the last one of those that are under way is what the catom says.
        const std::int32_t to = version.alone && is_said(version) ? catom : version.index;
        // Nobody need look at what no rule reads.
        if (bits != 0) facts_.mark(entry.reader, bits);
        if (before != to) links.read_at(entry.reader, entry.port, to);
        // What is needed to arrive is needed to be read from then on.
        if (to == catom || before == to) release(entry.version);
        if (before != to) stop_reading(before, static_cast<Catom>(catom));
    }
}

// ---- snapshots

void Versions::save(i64 now, ByteWriter& out) const {
    const world::Ensemble& ensemble = members_.ensemble;
    const world::Links& links = ensemble.links();
    // The links with something under way, and the tick in which the last of it arrives.
    struct Busy {
        u64 link;
        i64 last;
        u32 number = kNone32;
    };
    std::vector<Busy> busy;
    for (u32 ticks = 1; ticks <= ring_.size(); ++ticks)
        for (const Entry& entry : ring_[(static_cast<std::size_t>(now) + ticks) % ring_.size()])
            if (entry.version != kGone) busy.push_back({key_of(entry.reader, entry.port), now + ticks});
    std::ranges::sort(busy, [](const Busy& a, const Busy& b) { return std::tuple(a.link, -a.last) < std::tuple(b.link, -b.last); });
    const auto same = std::ranges::unique(busy, {}, &Busy::link);
    busy.erase(same.begin(), same.end());
    u64 count = 0;
    each_link_read(members_.ensemble, [&](Catom, world::Port, Catom, Catom) { ++count; });
    out.write_count(count);
    u32 next = 0;
    auto next_busy = busy.begin();
    each_link_read(members_.ensemble, [&](Catom reader, world::Port port, Catom other, Catom index) {
        const u64 link = key_of(reader, port);
        while (next_busy != busy.end() && next_busy->link < link) ++next_busy;
        const bool is_busy = next_busy != busy.end() && next_busy->link == link;
        if (is_busy) next_busy->number = next;
        ++next;
        i64 last = is_busy ? next_busy->last : now;
        // What a jam holds up comes later than was said when it was sent, and what is lost does not come.
        if (keeps_last()) last = links.last_arrival(other, links.port_there(reader, port), now);
        out.write(ensemble.id(reader));
        out.write(ensemble.id(other));
        out.write(last > now ? last : i64{0});
        const std::size_t state = out.begin_block();
        facts_.columns.pack(index, tuple::Columns::Which::Exported, out);
        out.end_block(state);
    });
    const auto number_of = [&](const Entry& entry) {
        return std::ranges::lower_bound(busy, key_of(entry.reader, entry.port), {}, &Busy::link)->number;
    };
    // By version, what it is as a whole and in one column.
    ByteWriter parcels;
    u32 parcel_count = 0;
    std::unordered_map<u64, u32> parcel_of;
    constexpr u32 kWhole = 64;
    const auto parcel = [&](u32 version, u32 place) {
        const auto [at, made] = parcel_of.try_emplace(u64{version} << 32 | place, parcel_count);
        if (!made) return at->second;
        ++parcel_count;
        ByteWriter bytes;
        const auto kind = place == kWhole ? ParcelKind::State : ParcelKind::Column;
        if (version != kGone && place == kWhole)
            facts_.columns.pack(static_cast<Catom>(versions_[version].index), tuple::Columns::Which::Exported, bytes);
        else if (version != kGone)
            facts_.columns.pack_column(exported_[place], static_cast<Catom>(versions_[version].index), bytes);
        write(parcels, SavedParcel{kind, place == kWhole ? u16{0} : exported_[place], bytes.view()});
        return at->second;
    };
    std::vector<SavedEntry> sent;
    for (u32 ticks = 1; ticks <= ring_.size(); ++ticks)
        for (const Entry& entry : ring_[(static_cast<std::size_t>(now) + ticks) % ring_.size()]) {
            if (entry.version == kGone) {
                for (u32 i = 0; i < entry.reader; ++i) sent.push_back({ticks, kNone32, parcel(kGone, kWhole), false});
                continue;
            }
            const u32 link = number_of(entry);
            if (entry.whole != 0) {
                sent.push_back({ticks, link, parcel(entry.version, kWhole), entry.late != 0});
                continue;
            }
            for (u64 left = versions_[entry.version].columns; left != 0; left &= left - 1)
                sent.push_back({ticks, link, parcel(entry.version, static_cast<u32>(std::countr_zero(left))), entry.late != 0});
        }
    out.write_count(parcel_count);
    out.write_bytes(parcels.view().data(), parcels.view().size());
    out.write_count(sent.size());
    for (const SavedEntry& entry : sent) write(out, entry);
}

bool Versions::load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    world::Ensemble& ensemble = members_.ensemble;
    world::Links& links = ensemble.links();
    struct Known {
        Catom reader = 0, other = 0;
        world::Port port = 0;
        u32 latest = kNone32;  // Of the versions that are under way over it.
    };
    std::vector<std::optional<Known>> known;
    ByteWriter said;
    each_saved_link(
        in, [&](std::size_t count) { known.resize(count); },
        [&](std::size_t number, const SavedLink& saved) {
            const auto reader = find(saved.reader);
            const auto other = ensemble.find(saved.other);
            // Else it is one of another process.
            if (!reader || !other) return;
            const std::optional<world::Port> port = links.towards(*reader, *other);
            if (!port || links.read(*reader, *port) < 0) return;
            known[number] = {*reader, *other, *port};
            said.clear();
            facts_.columns.pack(*other, tuple::Columns::Which::Exported, said);
            if (keeps_last() && saved.last > now) links.set_last_arrival(*other, links.port_there(*reader, *port), saved.last);
            if (std::ranges::equal(said.view(), saved.known)) return;
            const std::int32_t index = take_index(take_version(*other), Holds::Nothing);
            copy_at(index).needed = 1;
            links.read_at(*reader, *port, index);
            ByteReader state(saved.known, "what has arrived over a link", ByteReader::Origin::Outside);
            facts_.columns.unpack(static_cast<Catom>(index), tuple::Columns::Which::Exported, state, 0);
        });
    if (in.failed()) return false;
    const std::vector<SavedParcel> parcels = read_parcels(in);
    return each_saved_entry(in, parcels.size(), [&](const SavedEntry& entry) {
        // This world's network may be faster.
        const i64 arrival = now + std::min<i64>(entry.ticks, world_.latency());
        if (entry.link == kNone32) {
            if (!takes_lost) return;
            put_gone(arriving(arrival), 1);
            ++under_way_;
            return;
        }
        if (entry.link >= known.size() || !known[entry.link]) return;
        Known& link = *known[entry.link];
        const SavedParcel& parcel = parcels[entry.parcel];
        // Which column changes; none: all of it is new.
        const auto column = std::ranges::find(exported_, parcel.number);
        const bool whole = parcel.kind == ParcelKind::State;
        if (!whole && (parcel.kind != ParcelKind::Column || column == exported_.end())) return;
        const auto before = static_cast<Catom>(link.latest != kNone32 ? versions_[link.latest].index : links.read(link.reader, link.port));
        const u32 version = take_version(link.other);
        const auto index = static_cast<Catom>(take_index(version, Holds::Nothing));
        ByteReader bytes(parcel.bytes, "what is under way over a link", ByteReader::Origin::Outside);
        if (whole) {
            facts_.columns.unpack(index, tuple::Columns::Which::Exported, bytes, 0);
        } else {
            for (const u16 each : exported_) facts_.columns.copy(each, before, index, 0);
            facts_.columns.unpack_column(parcel.number, index, bytes, 0);
            versions_[version].columns = u64{1} << (column - exported_.begin());
        }
        versions_[version].alone = true;
        link.latest = version;
        put(arrival, {version, link.reader, link.port, whole, entry.late});
    });
}

std::size_t Versions::bytes() const {
    std::size_t all = versions_.capacity() * sizeof(Version) + copies_.capacity() * sizeof(Copy) + entries_.capacity() * sizeof(Entry) +
                      readers_.capacity() * sizeof(Reader) + indices_.bytes();
    for (const std::vector<u32>* each : {&free_versions_, &current_}) all += each->capacity() * sizeof(u32);
    for (const auto& slot : ring_) all += slot.capacity() * sizeof(Entry);
    return all;
}

}  // namespace meld::sim
