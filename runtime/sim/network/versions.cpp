#include "runtime/sim/network/versions.h"

#include <algorithm>
#include <array>
#include <bit>
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

Versions::Versions(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, Fates& fates)
    : module_(module),
      world_(world),
      members_(members),
      facts_(facts),
      fates_(fates),
      indices_(members, facts),
      ring_(world.latency() + 2) {
    members_.ensemble.links().keep_last_arrivals();
    for (u16 c = 0; c < module.column_count; ++c) {
        if (!module.columns[c].exported) continue;
        exported_.push_back(c);
        readers_dirty_ |= module.columns[c].reader_dirty;
    }
}

// ---- versions

// For one more, without doubling what is large.
template <class Each>
static void make_room(std::vector<Each>& all) {
    constexpr std::size_t kLeast = 64, kShare = 8;
    if (all.size() == all.capacity()) all.reserve(all.size() + all.size() / kShare + kLeast);
}

u32 Versions::take_version(Catom catom, i64 since) {
    u32 version = static_cast<u32>(versions_.size());
    if (free_versions_.empty()) {
        make_room(versions_);
        versions_.emplace_back();
    } else {
        version = free_versions_.back();
        free_versions_.pop_back();
    }
    versions_[version] = {.catom = catom, .index = static_cast<std::int32_t>(catom), .since = since};
    return version;
}

std::int32_t Versions::take_index(u32 version, Holds holds) {
    const Catom catom = versions_[version].catom, index = indices_.take(catom);
    if (index >= number_of_.size()) {
        if (index >= number_of_.capacity()) number_of_.reserve(index + index / 8 + std::size_t{64});
        number_of_.resize(index + std::size_t{1}, kNone32);
    }
    number_of_[index] = version;
    versions_[version].index = static_cast<std::int32_t>(index);
    if (holds == Holds::AllThatIsSaid)
        for (const u16 column : exported_) facts_.columns.copy(column, catom, index, 0);
    return static_cast<std::int32_t>(index);
}

void Versions::leave(u32 version) {
    Version& v = versions_[version];
    if (v.under_way > 0 || v.readers > 0) return;
    const auto index = static_cast<Catom>(v.index);
    if (index == v.catom) {
        if (current(v.catom) == version) current_[v.catom] = kNone32;
    } else {
        indices_.give_back(index);
    }
    free_versions_.push_back(version);
}

void Versions::stop_reading(std::int32_t index, Catom other) {
    if (index < 0 || static_cast<Catom>(index) == other) return;
    const u32 version = number_of_[static_cast<std::size_t>(index)];
    --versions_[version].readers;
    leave(version);
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

void Versions::before_change(i64 now, Catom catom) {
    u32 version = current(catom);
    // Another column has changed in this tick, and what was said before is kept already.
    if (version != kNone32 && versions_[version].since == now) return;
    // Who still waits for what it says now gets the copy.
    std::int32_t copy = version != kNone32 ? take_index(version, Holds::AllThatIsSaid) : -1;
    world::Links& links = members_.ensemble.links();
    each_readers(links, catom, [&](world::Port, std::span<const Reader> readers) {
        for (const Reader& reader : readers) {
            if (reader.index != static_cast<std::int32_t>(catom) || members_.ensemble.state(reader.catom) != kCatomOwned) continue;
            if (copy < 0) {
                version = take_version(catom, kBefore);
                copy = take_index(version, Holds::AllThatIsSaid);
            }
            links.read_at(reader.catom, reader.port, copy);
            ++versions_[version].readers;
        }
    });
    if (current(catom) != kNone32) current_[catom] = kNone32;
}

void Versions::changed(i64 now, Catom catom, u16 column) {
    const auto place = std::ranges::lower_bound(exported_, column) - exported_.begin();
    u32 version = current(catom);
    if (version != kNone32 && versions_[version].since == now) {
        // It travels with what has changed before it in this tick.
        versions_[version].columns |= u64{1} << place;
        return;
    }
    MELD_EXPECT(version == kNone32, "catom {} changes without a copy", catom);
    version = take_version(catom, now);
    versions_[version].columns = u64{1} << place;
    if (catom >= current_.size()) current_.resize(members_.ensemble.index_count(), kNone32);
    current_[catom] = version;
    each_readers(members_.ensemble.links(), catom,
                 [&](world::Port first, std::span<const Reader> readers) { post(now, version, first, readers, false); });
    leave(version);
}

void Versions::post(i64 now, u32 version, world::Port first, std::span<const Reader> readers, bool whole) {
    const Catom catom = versions_[version].catom;
    std::array<Reader, kReadersAtOnce> here;
    std::size_t count = 0;
    for (const Reader& reader : readers)
        // Another process has what is known of a link, but both know what is lost.
        if (members_.ensemble.state(reader.catom) != kCatomOwned)
            fates_.note_loss(now, catom, reader.catom);
        else if (reader.index >= 0)
            here[count++] = reader;
    std::array<world::Fate, kReadersAtOnce> fates;
    fates_.of(catom, {here.data(), count}, now, {fates.data(), count});
    world::Links& links = members_.ensemble.links();
    std::array<i64, kReadersAtOnce> arrivals;
    for (std::size_t i = 0; i < count; ++i) {
        // What was sent before arrives before; what comes after something that is lost finds the link down.
        const i64 last = links.last_arrival(catom, here[i].from, now);
        const i64 at = fates[i].arrives ? fates_.acts_from(here[i].catom, now + fates[i].ticks) : now + fates[i].ticks;
        arrivals[i] = std::max(last, at);
        links.set_last_arrival(catom, here[i].from, arrivals[i]);
        if (fates[i].arrives) continue;
        fates_.lose(at, catom, here[i].catom);
        arrivals[i] = kBefore;
    }
    // Those to whom it comes in the same tick together.
    for (std::size_t i = 0; i < count; ++i) {
        const i64 arrival = arrivals[i];
        if (arrival == kBefore) continue;
        std::uint16_t ports = 0;
        for (std::size_t j = i; j < count; ++j)
            if (arrivals[j] == arrival) {
                ports = static_cast<std::uint16_t>(ports | 1u << (here[j].from - first));
                arrivals[j] = kBefore;
            }
        put(arrival, {version, first, ports, whole});
    }
}

void Versions::put(i64 arrival, const Entry& entry) {
    arriving(arrival).push_back(entry);
    const auto links = static_cast<u32>(std::popcount(entry.ports));
    versions_[entry.version].under_way += links;
    under_way_ += links;
}

// ---- links

void Versions::follow_links(i64 now, bool tells) {
    world::Ensemble& ensemble = members_.ensemble;
    // Here every tick passes: nothing that has arrived seems to be to come, however long a run is.
    if (constexpr i64 kBetween = i64{1} << 30; now > 0 && now % kBetween == 0) ensemble.links().forget_arrivals(now);
    const std::vector<world::Links::Change> changes = ensemble.links().take_changes();
    if (changes.empty()) return facts_.resize(ensemble.index_count());
    std::vector<Sender> gone;
    for (const world::Links::Change& link : changes) {
        // What it holds of a link is there as long as it can read over it.
        facts_.touch(link.reader);
        if (link.made) continue;
        stop_reading(link.read, link.other);
        gone.push_back({link.reader, link.port});
    }
    if (under_way_ > 0 && !gone.empty()) cancel(std::move(gone));
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

void Versions::cancel(std::vector<Sender> links) {
    std::ranges::sort(links);
    std::vector<bool> sends(members_.ensemble.index_count());
    for (const Sender& link : links) sends[link.catom] = true;
    std::vector<u32> left;
    for (std::vector<Entry>& entries : ring_) {
        u32 lost = 0;
        for (Entry& entry : entries) {
            if (entry.version == kGone || !sends[versions_[entry.version].catom]) continue;
            Version& version = versions_[entry.version];
            for (u32 ports = entry.ports; ports != 0; ports &= ports - 1) {
                const auto place = static_cast<u32>(std::countr_zero(ports));
                if (!std::ranges::binary_search(links, Sender{version.catom, entry.first + place})) continue;
                entry.ports = static_cast<std::uint16_t>(entry.ports & ~(1u << place));
                ++lost;
                if (--version.under_way == 0) left.push_back(entry.version);
            }
        }
        std::erase_if(entries, [](const Entry& entry) { return entry.version != kGone && entry.ports == 0; });
        // A run waits for it all the same.
        if (lost > 0) entries.push_back({kGone, lost, 0});
    }
    for (const u32 version : left) leave(version);
}

void Versions::tell(i64 now, Catom reader, world::Port port, Catom other) {
    world::Links& links = members_.ensemble.links();
    const u32 nothing = take_version(other, kBefore);
    versions_[nothing].readers = 1;
    links.read_at(reader, port, take_index(nothing, Holds::Nothing));
    if (other >= current_.size()) current_.resize(members_.ensemble.index_count(), kNone32);
    if (current_[other] == kNone32) current_[other] = take_version(other, kBefore);
    const world::Port from = links.port_there(reader, port);
    const Reader one = {reader, port, links.read(reader, port), from};
    const u32 version = current_[other];
    post(now, version, from, {&one, 1}, true);
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
    // What has waited for the end of a jam was sent before what comes in its time.
    if (world_.longest_jam > 0) std::ranges::stable_partition(entries_, &Entry::late);
    // So many messages at a time: what they need lies anywhere in memory, one after the other, and is asked for all of them together.
    struct Message {
        u32 version;
        Catom reader;
        world::Port port;  // Of the sender.
        u64 bits;
    };
    constexpr std::size_t kTogether = 64;
    std::array<Message, kTogether> messages;
    std::size_t count = 0;
    const world::Links& links = members_.ensemble.links();
    const auto open_all = [&] {
        const std::span<const Message> all(messages.data(), count);
        const auto read_before = [&](const Message& m) {
            return static_cast<std::size_t>(links.read(m.reader, links.port_there(versions_[m.version].catom, m.port)));
        };
        for (const Message& m : all) links.ask_ahead(m.reader);
        for (const Message& m : all) links.ask_ahead_read(m.reader, links.port_there(versions_[m.version].catom, m.port));
        for (const Message& m : all)
            if (const std::size_t before = read_before(m); before < number_of_.size()) __builtin_prefetch(&number_of_[before]);
        for (const Message& m : all)
            if (const std::size_t before = read_before(m); before < number_of_.size() && number_of_[before] < versions_.size())
                __builtin_prefetch(&versions_[number_of_[before]]);
        for (const Message& m : all) {
            Version& version = versions_[m.version];
            open(version, m.port, m.bits);
            --under_way_;
            if (--version.under_way == 0) leave(m.version);
        }
        count = 0;
    };
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        ask_ahead(entries_, i);
        const Entry& entry = entries_[i];
        if (entry.version == kGone) {
            under_way_ -= entry.first;
            continue;
        }
        Version& version = versions_[entry.version];
        const u64 bits = entry.whole ? readers_dirty_ : bits_of(version);
        const u32 in = world_.longest_jam > 0 ? hold_up(now, entry) : entry.ports;
        // What a jam holds up is under way twice.
        const auto held = static_cast<u32>(std::popcount(entry.ports) - std::popcount(in));
        version.under_way -= held;
        under_way_ -= held;
        for (u32 ports = in; ports != 0; ports &= ports - 1) {
            const world::Port port = entry.first + static_cast<u32>(std::countr_zero(ports));
            messages[count++] = {entry.version, *links.at(version.catom, port), port, bits};
            if (count == kTogether) open_all();
        }
    }
    open_all();
}

void Versions::ask_ahead(const std::vector<Entry>& entries, std::size_t at) const {
    // They lie anywhere in memory.
    constexpr std::size_t kFirst = 16, kThen = 8;
    if (at + kFirst < entries.size() && entries[at + kFirst].version != kGone) __builtin_prefetch(&versions_[entries[at + kFirst].version]);
    if (at + kThen < entries.size() && entries[at + kThen].version != kGone)
        members_.ensemble.links().ask_ahead(versions_[entries[at + kThen].version].catom, entries[at + kThen].first);
}

std::uint16_t Versions::hold_up(i64 now, const Entry& entry) {
    const Catom catom = versions_[entry.version].catom;
    u32 in = entry.ports;
    for (u32 ports = entry.ports; ports != 0; ports &= ports - 1) {
        const auto place = static_cast<u32>(std::countr_zero(ports));
        const Catom reader = *members_.ensemble.links().at(catom, entry.first + place);
        const i64 free = fates_.jammed_until(now, catom, reader);
        if (free == now) continue;
        in &= ~(1u << place);
        put(fates_.acts_from(reader, free), {entry.version, entry.first, static_cast<std::uint16_t>(1u << place), entry.whole, true});
    }
    return static_cast<std::uint16_t>(in);
}

void Versions::open(Version& version, world::Port port, u64 bits) {
    world::Links& links = members_.ensemble.links();
    const std::optional<Catom> reader = links.at(version.catom, port);
    MELD_EXPECT(reader.has_value(), "catom {} port {}", version.catom, port);
    const world::Port there = links.port_there(version.catom, port);
    // Where a run has gone on, the last one of those that are under way is what the catom says.
    const std::int32_t to = version.alone && is_said(version) ? static_cast<std::int32_t>(version.catom) : version.index;
    const std::int32_t before = links.read(*reader, there);
    if (before != to) {
        links.read_at(*reader, there, to);
        if (static_cast<Catom>(to) != version.catom) ++version.readers;
        stop_reading(before, version.catom);
    }
    // Nobody need look at what no rule reads.
    if (bits != 0) facts_.mark(*reader, bits);
}

// ---- snapshots

void Versions::save(i64 now, ByteWriter& out) const {
    const world::Ensemble& ensemble = members_.ensemble;
    const world::Links& links = ensemble.links();
    // The numbers of links with something under way, by their senders. What a jam holds up comes later than was said when it was sent.
    const auto key_of = [](Catom sender, world::Port port) { return u64{sender} << 32 | port; };
    using Number = std::pair<u64, u32>;
    std::vector<Number> numbers;
    for (const std::vector<Entry>& entries : ring_)
        for (const Entry& entry : entries)
            for (u32 ports = entry.version == kGone ? u32{0} : entry.ports; ports != 0; ports &= ports - 1)
                numbers.emplace_back(key_of(versions_[entry.version].catom, entry.first + static_cast<u32>(std::countr_zero(ports))),
                                     kNone32);
    std::ranges::sort(numbers);
    numbers.erase(std::ranges::unique(numbers).begin(), numbers.end());
    const auto number_of = [&](u64 key) { return std::ranges::lower_bound(numbers, key, {}, &Number::first); };
    u64 count = 0;
    each_link_read(members_.ensemble, [&](Catom, world::Port, Catom, Catom) { ++count; });
    out.write_count(count);
    u32 next = 0;
    each_link_read(members_.ensemble, [&](Catom reader, world::Port port, Catom other, Catom index) {
        const world::Port from = links.port_there(reader, port);
        const i64 last = links.last_arrival(other, from, now);
        if (last > now || world_.longest_jam > 0)
            if (const auto at = number_of(key_of(other, from)); at != numbers.end() && at->first == key_of(other, from)) at->second = next;
        ++next;
        out.write(ensemble.id(reader));
        out.write(ensemble.id(other));
        out.write(last > now ? last : i64{0});
        const std::size_t state = out.begin_block();
        facts_.columns.pack(index, tuple::Columns::Which::Exported, out);
        out.end_block(state);
    });
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
                for (u32 i = 0; i < entry.first; ++i) sent.push_back({ticks, kNone32, parcel(kGone, kWhole), false});
                continue;
            }
            const Version& version = versions_[entry.version];
            for (u32 ports = entry.ports; ports != 0; ports &= ports - 1) {
                const u32 link = number_of(key_of(version.catom, entry.first + static_cast<u32>(std::countr_zero(ports))))->second;
                if (entry.whole) {
                    sent.push_back({ticks, link, parcel(entry.version, kWhole), entry.late});
                    continue;
                }
                for (u64 left = version.columns; left != 0; left &= left - 1)
                    sent.push_back({ticks, link, parcel(entry.version, static_cast<u32>(std::countr_zero(left))), entry.late});
            }
        }
    out.write_count(parcel_count);
    out.write_bytes(parcels.view().data(), parcels.view().size());
    out.write_count(sent.size());
    for (const SavedEntry& entry : sent) write(out, entry);
}

bool Versions::load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in) {
    world::Ensemble& ensemble = members_.ensemble;
    world::Links& links = ensemble.links();
    struct Link {
        Catom reader = 0, other = 0;
        world::Port port = 0;
        u32 latest = kNone32;  // Of the versions that are under way over it.
    };
    std::vector<std::optional<Link>> known;
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
            if (saved.last > now) links.set_last_arrival(*other, links.port_there(*reader, *port), saved.last);
            if (std::ranges::equal(said.view(), saved.known)) return;
            const u32 version = take_version(*other, kBefore);
            versions_[version].readers = 1;
            links.read_at(*reader, *port, take_index(version, Holds::Nothing));
            ByteReader state(saved.known, "what has arrived over a link", ByteReader::Origin::Outside);
            facts_.columns.unpack(static_cast<Catom>(versions_[version].index), tuple::Columns::Which::Exported, state, 0);
        });
    if (in.failed()) return false;
    const std::vector<SavedParcel> parcels = read_parcels(in);
    return each_saved_entry(in, parcels.size(), [&](const SavedEntry& entry) {
        // This world's network may be faster.
        const i64 arrival = now + std::min<i64>(entry.ticks, world_.latency());
        if (entry.link == kNone32) {
            if (!takes_lost) return;
            arriving(arrival).push_back({kGone, 1, 0});
            ++under_way_;
            return;
        }
        if (entry.link >= known.size() || !known[entry.link]) return;
        Link& link = *known[entry.link];
        const SavedParcel& parcel = parcels[entry.parcel];
        // Which column changes; none: all of it is new.
        const auto column = std::ranges::find(exported_, parcel.number);
        const bool whole = parcel.kind == ParcelKind::State;
        if (!whole && (parcel.kind != ParcelKind::Column || column == exported_.end())) return;
        const auto before = static_cast<Catom>(link.latest != kNone32 ? versions_[link.latest].index : links.read(link.reader, link.port));
        const u32 version = take_version(link.other, kBefore);
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
        const world::Port from = links.port_there(link.reader, link.port);
        put(arrival, {version, from, 1, whole, entry.late});
    });
}

std::size_t Versions::bytes() const {
    std::size_t all = versions_.capacity() * sizeof(Version) + entries_.capacity() * sizeof(Entry) + indices_.bytes();
    for (const std::vector<u32>* each : {&free_versions_, &current_, &number_of_}) all += each->capacity() * sizeof(u32);
    for (const auto& slot : ring_) all += slot.capacity() * sizeof(Entry);
    return all;
}

}  // namespace meld::sim
