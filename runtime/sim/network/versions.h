// What readers know of a neighbour, for programs that send no linear facts and whose readers are not told which rows have changed.
//
// A reader who knows all that a catom says reads the catom itself. Before the catom changes, what it said until then is copied to one more
// index among the columns: a version, which all those who know no more have in common. What travels is the next version, and its arrival
// lets a reader read elsewhere. A version goes when nobody reads it any more and it is under way to nobody. A reader is evaluated when what
// it reads elsewhere concerns it (Evaluator::mark_concerned).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/plain_array.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/fact_store.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/sim/network/fates.h"
#include "runtime/sim/network/mailbox_indices.h"
#include "runtime/sim/network/readers.h"

namespace meld::sim {

class Versions {
  public:
    // Whether a program and a world allow it: what arrives has to come in the order in which it was sent, and all of it.
    static bool suit(const ModuleInfo& module, const world::World& world);
    // subdomain: as in Network.
    Versions(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, Fates& fates,
             const SubdomainView& subdomain);

    // As in Network.
    void follow_links(i64 now, bool tell);
    void arrive(i64 now);
    bool busy() const { return under_way_ != 0; }

    // These columns of catoms, owned or ghosts, are about to change at the end of this tick. What they say until then is kept for those who
    // read it, and what they will say is sent to all. Those of a catom follow each other.
    void change(i64 now, std::span<const eval::Change> changes);

    // The links with what is known over them, the parcels and who is to get them, as Network writes them of mailboxes.
    void save(i64 now, ByteWriter& out) const;
    // Returns whether all could be read.
    bool load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in);
    // Nobody knows anything, and everything is on its way.
    void tell_all(i64 now);

    std::size_t bytes() const;

  private:
    // By its index among the columns. As long as a catom says it, it is read there, and the index is only its name.
    struct alignas(16) Version {
        Catom catom = 0;    // Whose.
        u32 needed = 0;     // Links over which it is under way, or is read at its own index.
        u32 since = 0;      // The tick at the end of which it came, modulo 2^32.
        u32 kind : 29 = 0;  // An index into kinds_.
        u32 said : 1 = 0;   // The catom says it now.
        u32 dated : 1 = 0;  // A tick is known.
        u32 alone : 1 = 0;  // Of a snapshot, and for one reader. It may be what the catom says.
        static constexpr u32 kMostKind = (u32{1} << 29) - 1;
    };
    // In which columns a version differs from the one before.
    struct Kind {
        u64 columns = 0;  // By their places in exported_.
        u64 marks = 0;    // Dirty bits of a reader, for those columns whose changes concern all,
        u64 asks = 0;     // and the columns that say whom a change concerns.
    };
    // On its way to a reader.
    struct Entry {
        Catom index;  // Of the version.
        Catom reader;
        world::Port port : 30;
        u32 whole : 1;  // The reader knows nothing of the catom yet.
        u32 late : 1;   // Held up by a jam, so it is before all that was sent to arrive now.

        Entry(Catom its_index, Catom its_reader, world::Port its_port, bool is_whole, bool is_late = false)
            : index(its_index), reader(its_reader), port(its_port & kMostPort), whole(is_whole), late(is_late) {}
        static constexpr world::Port kMostPort = (world::Port{1} << 30) - 1;
    };
    using Entries = PlainArray<Entry>;
    // In place of a version: as many as `reader` says were under way over links that are gone.
    static constexpr Catom kGone = kNone32;

    struct Link {
        Catom reader;
        world::Port port;
    };
    static u64 key_of(Catom reader, world::Port port) { return u64{reader} << 32 | port; }
    // What was under way over these is lost.
    void cancel(const std::vector<Link>& links);
    // All that a neighbour exports is sent to a reader who knows nothing of it.
    void tell(i64 now, Catom reader, world::Port port, Catom other);
    void change(i64 now, const eval::Change& change, std::span<const Reader> readers);
    // At most kReadersAtOnce.
    void post(i64 now, Catom index, std::span<const Reader> readers, bool whole);
    void put(i64 arrival, const Entry& entry);
    void push(Entries& entries, const Entry& entry);
    // So many that a run still waits for, though their links are gone.
    void put_gone(Entries& entries, u32 links);
    // Some that arrive come in, one after the other.
    static constexpr std::size_t kOpenedAtOnce = 32;
    void open(std::span<const Entry> entries);
    // These have read `before`, and read `to` from now on, which is this version.
    void mark_readers(const Version& version, Catom before, Catom to, std::span<const Catom> readers);
    // What a jam holds up is put to its end. Returns whether it does.
    bool held_up(i64 now, const Entry& entry);
    std::size_t slot(i64 tick) const { return static_cast<std::size_t>(tick) % ring_.size(); }
    Entries& arriving(i64 tick) { return ring_[slot(tick)]; }

    // One of a catom that nobody needs yet, of no kind. It holds what its index held, or `Nothing`.
    enum class Holds { Anything, Nothing };
    Catom take(Catom catom, Holds holds);
    // What a catom says is kept at the index of a version.
    void keep(Catom catom, Catom index);
    // It goes if nobody needs it.
    void leave(Catom index) {
        if (version_at(index).needed == 0) give_back(index);
    }
    // Over so many links less.
    void release(Catom index, u32 links = 1) {
        Version& version = version_at(index);
        MELD_EXPECT(version.needed >= links, "version {} is needed by {}, and {} leave", index, version.needed, links);
        version.needed -= links;
        if (version.needed == 0) give_back(index);
    }
    void give_back(Catom index);
    void stop_reading(std::int32_t index, Catom other) {
        if (index >= 0 && static_cast<Catom>(index) != other) release(static_cast<Catom>(index));
    }
    bool is_version(Catom index) const { return std::size_t{index} - first_ < versions_.size(); }
    Version& version_at(Catom index) { return versions_[index - first_]; }
    const Version& version_at(Catom index) const { return versions_[index - first_]; }
    // Where it is read.
    Catom place_of(Catom index) const { return version_at(index).said != 0 ? version_at(index).catom : index; }
    // The version that a catom says now, if that is under way; or kGone.
    Catom current(Catom catom) const { return catom < current_.size() ? current_[catom] : kGone; }
    void set_current(Catom catom, Catom index);
    bool is_said(Catom catom, Catom index) const;
    u32 place(u16 column) const;
    u32 no_kind() const { return static_cast<u32>(exported_.size()); }
    // That of one column, by its place, is its place.
    u32 kind_with(u32 kind, u32 place);
    void add_kind(u64 columns);
    // With all of a link's time the same, what is sent before arrives before.
    bool keeps_last() const { return same_ticks_ == 0; }

    const ModuleInfo& module_;
    const world::World& world_;
    Membership& members_;
    FactStore& facts_;
    Fates& fates_;
    const SubdomainView& subdomain_;
    std::vector<u16> exported_;  // Columns.
    std::vector<u16> asked_;     // Those that say whom a change concerns.
    bool has_lists_ = false, has_rows_ = false;
    u64 readers_dirty_ = kDirtyLinks;
    u32 same_ticks_ = 0;  // That each message takes; 0: they differ.
    MailboxIndices indices_;
    std::vector<Kind> kinds_;
    std::unordered_map<u64, u32> kind_of_;  // By columns.
    std::vector<Version> versions_;         // By index among the columns, from first_ on.
    Catom first_ = 0;
    std::vector<Catom> current_;  // By catom.
    std::vector<Entries> ring_;   // By tick of arrival.
    Entries entries_;             // Room for those of a tick.
    PlainArray<Reader> readers_;  // Room for those of some catoms.
    u64 under_way_ = 0;
    u32 gone_ = 0;  // Entries with kGone.
};

}  // namespace meld::sim
