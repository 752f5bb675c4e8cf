// A network that takes time, and catoms that pause: what a catom reads of a neighbour is what has arrived over their link.
//
// As long as a reader knows all that the neighbour says, it reads the neighbour itself. Before the neighbour changes, the link gets a
// mailbox: an index among the columns, at the process that owns the reader. Its exported columns hold the neighbour's as the reader knows
// them, so compiled code reads a mailbox as it would read the neighbour. Exports reach ghosts as they do in the ideal network, at the end
// of the tick; from there this class carries them into the mailboxes, each change after as many ticks as world::fate() says, first in,
// first out for each link. Linear facts travel with them. So nothing of it depends on who owns which catom. Once nothing is under way and
// the reader knows what the neighbour says, the mailbox goes. For many programs the readers of a neighbour share what they know, and there
// are no mailboxes (versions.h).
//
// A catom that pauses is evaluated in a later tick. What arrives for it waits until then, so its pauses are part of the delays of its
// links, and the quarantine of facts (docs/design.md) needs only the sum of both.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/fact_store.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/sim/network/fates.h"
#include "runtime/sim/network/mailbox_indices.h"
#include "runtime/sim/network/readers.h"
#include "runtime/sim/network/saved_links.h"
#include "runtime/sim/network/versions.h"
#include "runtime/world/description/network.h"

namespace meld::sim {

class Network {
  public:
    // subdomain: what modules see of this process, up to date whenever something arrives.
    Network(const ModuleInfo& module, const world::World& world, Membership& members, FactStore& facts, const SubdomainView& subdomain);

    // In a tick: what has arrived is put into the mailboxes, and the readers are marked.
    void arrive(i64 now);
    // In a tick, before arrive(): from time to time, mailboxes go that hold what the neighbour says now. Cost: theirs, every few ticks.
    void settle(i64 now);
    // These exported columns of catoms, owned or ghosts, are about to change at the end of this tick: readers here that read them in place
    // get mailboxes. One column of a catom changes once in a tick.
    void before_change(i64 now, std::span<const eval::Change> changes);
    // At the end of the tick before `next`: `deliver` gets the linear facts that rules can use from `next` on, by receivers and senders.
    // Their arguments live until it returns.
    struct Arrived {
        Catom to;
        u64 from;
        u16 predicate;
        const Value* arguments;
    };
    using Deliver = std::function<void(const std::vector<Arrived>&)>;
    void deliver(i64 next, const Deliver& deliver);
    // After links were made or removed: new ones get mailboxes, with all that the neighbour tells under way. What was under way over
    // those that are gone is lost.
    void follow_links(i64 now);
    // At the end of a tick, if follows_changes(): these columns of catoms, owned or ghosts, have changed.
    void changed(i64 now, std::span<const eval::Change> changes);
    // Otherwise before_change() has done all of it.
    bool follows_changes() const { return !versions_; }
    // At the end of a tick: a catom of this process was sent a linear fact.
    void sent(i64 now, Catom to, u64 from, u16 predicate, const Value* arguments);

    // A linear fact has gone to a catom of this process without a link, from any node of a graph. It takes as long as over a link.
    void sent_far(i64 now, Catom to, u64 from, u16 predicate, const Value* arguments);

    // The same of a linear fact for a catom of another process: the receiver's process carries it, but a loss is known to both.
    void sent_away(i64 now, Catom from, Catom to) { fates_.note_loss(now, from, to); }
    // At the beginning of a tick, before arrive(): links over which a message was lost for good are removed; both ends are marked.
    void take_down(i64 now, const std::function<void(Catom)>& mark) { fates_.take_down(now, mark); }

    // Whether a catom acts in this tick, where no turns are given. Called by all workers.
    bool acts(i64 now, Catom catom) const { return fates_.acts(now, catom); }

    // Between these catoms there is no link, or another one, so that nothing takes it down that was lost before.
    void forget_loss(u64 a, u64 b) { fates_.forget_loss(a, b); }

    // The catom that reads a mailbox.
    Catom reader(Catom mailbox) const { return mailboxes_[number_of_[mailbox]].reader; }
    // Whether something is under way.
    bool busy() const { return under_way_ != 0 || (versions_ && versions_->busy()) || !far_.empty() || fates_.any_lost(); }
    // Linear facts that did not arrive since the last call.
    u64 take_lost() { return std::exchange(lost_, 0); }

    // What the catoms of this process know over their links and what is under way, for a snapshot; and back for those catoms that `find`
    // finds here, once all of the ensemble are back. Not before read_in_place().
    void save(i64 now, ByteWriter& out) const;
    // Of a run in whose world nothing was under way, everything is told anew. takes_lost: one process goes on with what is under way over
    // links that have gone, since a run waits for it and counts it as lost when it would have arrived.
    void load(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in);
    // No link has a mailbox, and nothing is under way.
    void read_in_place() { follow(0, false); }

    std::size_t bytes() const;

  private:
    // Two in a line of the cache.
    struct alignas(32) Mailbox {
        i64 last = 0;  // The tick of the latest arrival.
        Catom reader = 0, other = 0;
        world::Port port = 0;     // Of the reader.
        std::int32_t index = -1;  // Among the columns; -1: the link is gone.
        u32 part = 0;             // Of the network's parts, from 1, and after them its single links; 0: none.
        u32 under_way : 31 = 0;   // Parcels to it.
        u32 differs : 1 = 0;      // Nothing has arrived since it was seen to hold something else than the neighbour.
    };
    // What travels: one for all links on which it does.
    struct Parcel {
        ParcelKind kind = ParcelKind::Column;
        u16 number = 0;  // Of a column or predicate.
        u32 links = 0;   // On which it is.
        std::vector<std::byte> bytes = {};
    };
    struct Entry {
        u32 mailbox, parcel;
        bool late = false;  // Held up by a jam, so it is before all that was sent to arrive now.
    };
    // A linear fact under way without a link.
    struct Far {
        i64 arrival;
        u64 to, from;
        u16 predicate;
        std::vector<std::byte> bytes;
    };
    struct Link {
        Catom reader;
        world::Port port;
        Catom other;
    };

    void follow(i64 now, bool tell);
    // What changes() needs for each of many.
    struct Posting {
        i64 now;
        std::size_t slot;  // In ring_, of this tick.
        ByteWriter bytes = {};
    };
    void changed(Posting& posting, const eval::Change& change, std::span<const Reader> readers);
    // A mailbox for a link that has none, empty or with what the neighbour says.
    enum class Holds { Nothing, AllThatIsSaid };
    u32 open_mailbox(Catom reader, world::Port port, Catom other, Holds holds);
    void close_mailbox(u32 number);
    // Whether the evaluation to come is told of changes: of those in the mailbox its reader, which may pause, and of the neighbour's the
    // neighbour itself.
    bool has_news(const Mailbox& m) const;
    bool holds_what_is_said(const Mailbox& m) const;
    u32 take_parcel(ParcelKind kind, u16 number, std::span<const std::byte> bytes);
    void release_parcel(u32 parcel);
    const world::LinkTerms& terms_of_nodes(u64 a, u64 b) const;
    void deliver_far(i64 next, std::vector<Arrived>& messages, std::deque<std::vector<Value>>& arguments, tuple::Arena& lists);
    const Value* read_arguments(u16 predicate, std::span<const std::byte> bytes, std::deque<std::vector<Value>>& arguments,
                                tuple::Arena& lists) const;
    std::vector<std::byte> argument_bytes(u16 predicate, const Value* arguments) const;
    void save_mailboxes(i64 now, ByteWriter& out) const;
    // Returns whether all could be read.
    bool load_mailboxes(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in);
    void save_far(i64 now, ByteWriter& out) const;
    void load_far(i64 now, const std::function<std::optional<u32>(u64)>& find, bool takes_lost, ByteReader& in);
    // Puts a parcel on its way to a mailbox, as sent in tick `now`.
    void post(i64 now, u32 mailbox, u32 parcel, bool linear);
    void post(i64 now, std::size_t slot_now, u32 mailbox, u32 parcel, bool linear, const world::Fate& fate);
    void put(i64 arrival, u32 mailbox, u32 parcel, bool late = false) { put_at(slot(arrival), mailbox, parcel, late); }
    void put_at(std::size_t slot, u32 mailbox, u32 parcel, bool late);
    // What arrives in this tick: linear facts, or all else.
    std::vector<Entry> take_entries(i64 tick, bool linear);
    // The memory of those of this tick is for what arrives in a later one.
    void give_back_entries(i64 tick, std::vector<Entry>&& entries);
    // Whether what arrives comes in. Otherwise it is lost, or waits for the end of a jam.
    bool comes_in(i64 now, const Entry& entry);
    void done_with(const Entry& entry);
    void open(const Mailbox& m, const Parcel& parcel);
    void ask_ahead(const Entry& entry) const;
    void ask_ahead_rows(const Entry& entry) const;
    // That of a link, which is made if it has none. Nothing: there is no such link.
    std::optional<u32> mailbox_at(Catom reader, world::Port port);
    // Posts all that the neighbour exports.
    void tell_state(i64 now, u32 mailbox);
    std::size_t slot(i64 tick) const { return static_cast<std::size_t>(tick) % ring_.size(); }
    std::vector<Entry>& arriving(i64 tick) { return ring_[slot(tick)]; }

    const ModuleInfo& module_;
    const world::World& world_;
    Membership& members_;
    FactStore& facts_;
    Fates fates_;
    std::optional<Versions> versions_;  // Instead of mailboxes.
    std::vector<u16> exported_;         // Columns.
    u64 readers_dirty_ = kDirtyLinks;   // What a reader of a whole state is to look at.
    MailboxIndices indices_;
    std::vector<Mailbox> mailboxes_;
    std::vector<u32> free_mailboxes_, number_of_;  // The latter by index among the columns.
    std::vector<Parcel> parcels_;
    std::vector<u32> free_parcels_;
    std::vector<std::vector<Entry>> ring_;  // By tick of arrival.
    std::vector<Far> far_;
    // When the last of them arrives, by sender and receiver, while that is to come.
    std::map<std::pair<u64, u64>, i64> last_far_;
    u64 under_way_ = 0;
    u64 lost_ = 0;
};

}  // namespace meld::sim
