// What readers know of a neighbour, for programs whose exported columns hold one fact each and send nothing else.
//
// A reader who knows all that a catom says reads the catom itself. Before the catom changes, what it said until then is copied to one more
// index among the columns: a version, which all those who know no more have in common. What travels is the next version, and its arrival
// lets a reader read elsewhere. A version goes when nobody reads it any more and it is under way to nobody.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
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
    void before_change(i64 now, Catom catom);
    void changed(i64 now, Catom catom, u16 column);
    bool busy() const { return under_way_ != 0; }

    // The links with what is known over them, the parcels and who is to get them, as Network writes them of mailboxes.
    void save(i64 now, ByteWriter& out) const;
    // Returns whether all could be read.
    bool load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in);
    // Nobody knows anything, and everything is on its way.
    void tell_all(i64 now);

    std::size_t bytes() const;

  private:
    struct Version {
        Catom catom = 0;          // Whose.
        std::int32_t index = -1;  // Where it is read: the catom itself as long as it says this; later the index of a copy.
        u32 readers = 0;          // Of the copy.
        u32 under_way = 0;        // Over so many links.
        i64 since = kBefore;      // The tick at the end of which it came.
        u64 columns = 0;          // Those in which it differs from the one before, by their places in exported_.
        bool alone = false;       // Of a snapshot, and for one reader. It may be what the catom says.
    };
    static constexpr i64 kBefore = -1;
    // On its way to those at some ports of the catom.
    struct Entry {
        u32 version;
        world::Port first;
        std::uint16_t ports;  // From the first one on.
        bool whole = false;   // The readers know nothing of the catom yet.
        bool late = false;    // Held up by a jam, so it is before all that was sent to arrive now.
    };
    // In place of a version: as many as `first` says were under way over links that are gone.
    static constexpr u32 kGone = kNone32;
    static_assert(kReadersAtOnce == 16, "a bit for each in Entry::ports");

    struct Sender {
        Catom catom;
        world::Port port;
        auto operator<=>(const Sender&) const = default;
    };
    // What was under way over these is lost.
    void cancel(std::vector<Sender> links);
    // All that a neighbour exports is sent to a reader who knows nothing of it.
    void tell(i64 now, Catom reader, world::Port port, Catom other);
    void post(i64 now, u32 version, world::Port first, std::span<const Reader> readers, bool whole);
    void put(i64 arrival, const Entry& entry);
    // The reader at a port of its catom gets a version, and is to look at these changes.
    void open(Version& version, world::Port port, u64 bits);
    // What jams hold up is put to their end. Returns the ports at which the rest comes in.
    std::uint16_t hold_up(i64 now, const Entry& entry);
    std::vector<Entry>& arriving(i64 tick) { return ring_[static_cast<std::size_t>(tick) % ring_.size()]; }
    void ask_ahead(const std::vector<Entry>& entries, std::size_t at) const;

    u32 take_version(Catom catom, i64 since);
    // It goes if nobody needs it.
    void leave(u32 version);
    void stop_reading(std::int32_t index, Catom other);
    // The version that a catom says now, if that is under way.
    u32 current(Catom catom) const { return catom < current_.size() ? current_[catom] : kNone32; }
    // An index of its own for a version, empty or with what the catom says.
    enum class Holds { Nothing, AllThatIsSaid };
    std::int32_t take_index(u32 version, Holds holds);
    bool is_said(const Version& version) const;
    u64 bits_of(const Version& version) const;

    const ModuleInfo& module_;
    const world::World& world_;
    Membership& members_;
    FactStore& facts_;
    Fates& fates_;
    std::vector<u16> exported_;  // Columns.
    u64 readers_dirty_ = kDirtyLinks;
    MailboxIndices indices_;
    std::vector<Version> versions_;
    std::vector<u32> free_versions_;
    std::vector<u32> current_;              // By catom.
    std::vector<u32> number_of_;            // Of versions, by index among the columns.
    std::vector<std::vector<Entry>> ring_;  // By tick of arrival.
    std::vector<Entry> entries_;            // Room for those of a tick.
    u64 under_way_ = 0;
};

}  // namespace meld::sim
