// What readers know of a neighbour, for programs whose exported columns hold one fact each and send nothing else.
//
// A reader who knows all that a catom says reads the catom itself. Before the catom changes, what it said until then is copied to one more
// index among the columns: a version, which all those who know no more have in common. What travels is the next version, and its arrival
// lets a reader read elsewhere. A version goes when nobody reads it any more and it is under way to nobody.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/base/bytes.h"
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
    Versions(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, Fates& fates);

    // As in Network.
    void follow_links(i64 now, bool tell);
    void arrive(i64 now);
    void before_change(i64 now, std::span<const Catom> catoms);
    void changed(i64 now, Catom catom, u16 column);
    void ask_ahead(Catom catom) const;
    bool busy() const { return under_way_ != 0; }

    // The links with what is known over them, the parcels and who is to get them, as Network writes them of mailboxes.
    void save(i64 now, ByteWriter& out) const;
    // Returns whether all could be read.
    bool load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in);
    // Nobody knows anything, and everything is on its way.
    void tell_all(i64 now);

    std::size_t bytes() const;

  private:
    struct alignas(32) Version {
        Catom catom = 0;          // Whose.
        std::int32_t index = -1;  // Where it is read: the catom itself as long as it says this; later the index of a copy.
        u32 under_way = 0;        // Over so many links, as long as it has no copy.
        u32 since = 0;            // The tick at the end of which it came, modulo 2^32,
        u64 columns = 0;          // and the columns in which it differs from the one before, by their places in exported_.
        bool dated = false;       // Whether a tick is known.
        bool alone = false;       // Of a snapshot, and for one reader. It may be what the catom says.
    };
    // Of a version that is read at an index of its own: how many read it there, or will when it has come to them.
    struct Copy {
        u32 version = kNone32;
        u32 needed = 0;
    };
    // On its way to a reader.
    struct Entry {
        u32 version;
        Catom reader;
        world::Port port : 30;
        u32 whole : 1;  // The reader knows nothing of the catom yet.
        u32 late : 1;   // Held up by a jam, so it is before all that was sent to arrive now.

        Entry(u32 its_version, Catom its_reader, world::Port its_port, bool is_whole, bool is_late = false)
            : version(its_version), reader(its_reader), port(its_port & kMostPort), whole(is_whole), late(is_late) {}
        static constexpr world::Port kMostPort = (world::Port{1} << 30) - 1;
    };
    // In place of a version: as many as `reader` says were under way over links that are gone.
    static constexpr u32 kGone = kNone32;

    struct Link {
        Catom reader;
        world::Port port;
    };
    static u64 key_of(Catom reader, world::Port port) { return u64{reader} << 32 | port; }
    // What was under way over these is lost.
    void cancel(const std::vector<Link>& links);
    // All that a neighbour exports is sent to a reader who knows nothing of it.
    void tell(i64 now, Catom reader, world::Port port, Catom other);
    void post(i64 now, u32 version, std::span<const Reader> readers, bool whole);
    void put(i64 arrival, const Entry& entry);
    void push(i64 arrival, const Entry& entry);
    // So many that a run still waits for, though their links are gone.
    void put_gone(std::vector<Entry>& entries, u32 links);
    // Some that arrive come in, one after the other.
    void open(std::span<const Entry> entries);
    // What a jam holds up is put to its end. Returns whether it does.
    bool held_up(i64 now, const Entry& entry);
    // The size of the ring is a power of two.
    std::vector<Entry>& arriving(i64 tick) { return ring_[static_cast<std::size_t>(tick) % ring_.size()]; }

    u32 take_version(Catom catom);
    // It goes if nobody needs it: one that has no copy.
    void leave(u32 version);
    // It is under way over one link less, or a reader has gone.
    void release(u32 version);
    void release_copy(std::int32_t index);
    void stop_reading(std::int32_t index, Catom other) {
        if (index >= 0 && static_cast<Catom>(index) != other) release_copy(index);
    }
    Copy& copy_at(std::int32_t index) { return copies_[static_cast<Catom>(index) - first_copy_]; }
    // The version that a catom says now, if that is under way.
    u32 current(Catom catom) const { return catom < current_.size() ? current_[catom] : kNone32; }
    void set_current(Catom catom, u32 version);
    // An index of its own for a version, empty or with what the catom says.
    enum class Holds { Nothing, AllThatIsSaid };
    std::int32_t take_index(u32 version, Holds holds);
    bool is_said(const Version& version) const;
    u64 bits_of(const Version& version) const;
    // With all of a link's time the same, what is sent before arrives before.
    bool keeps_last() const { return same_ticks_ == 0; }

    const ModuleInfo& module_;
    const world::World& world_;
    Membership& members_;
    FactStore& facts_;
    Fates& fates_;
    std::vector<u16> exported_;  // Columns.
    u64 readers_dirty_ = kDirtyLinks;
    u32 same_ticks_ = 0;  // That each message takes; 0: they differ.
    MailboxIndices indices_;
    std::vector<Version> versions_;
    std::vector<u32> free_versions_;
    std::vector<u32> current_;  // By catom.
    std::vector<Copy> copies_;  // By index among the columns, from first_copy_ on.
    Catom first_copy_ = 0;
    std::vector<std::vector<Entry>> ring_;  // By tick of arrival.
    std::vector<Entry> entries_;            // Room for those of a tick.
    std::vector<Reader> readers_;           // Room for those of some catoms.
    u64 under_way_ = 0;
    u32 gone_ = 0;  // Entries with kGone.
};

}  // namespace meld::sim
