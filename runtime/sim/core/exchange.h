// The end of a tick between processes: sends changed exports to the processes that hold ghosts of their catoms, and facts to the owners of
// their receivers.
//
// Four steps: exports are noted while they are committed, packed per destination, exchanged, and unpacked. Facts that were sent are then
// given to their receivers in the order of the senders' ids and sequence numbers, on any number of processes.
#pragma once

#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/radix_sort.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/core/created_nodes.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Exchange {
  public:
    explicit Exchange(Subdomain& subdomain);

    // Whether somebody wants to know of changed exports: other processes, or the network.
    bool follows_exports() const { return !subdomain_.alone() || network_follows(); }
    // Notes a changed column of exports; each worker notes its own.
    void note_export(int worker, Catom catom, u16 column);
    // After the evaluation, on every process: sends and receives. Programs see the facts in the next tick.
    void run();
    // The bytes sent to other processes in this tick.
    std::uint64_t sent_bytes() const { return sent_bytes_; }
    // Facts to nodes that are gone, since the last call.
    std::uint64_t take_lost() { return std::exchange(lost_, 0); }

  private:
    // Whether the network wants to know of changes after they have been made.
    bool network_follows() const { return subdomain_.network_ && subdomain_.network_->follows_changes(); }

    enum class Record : std::uint8_t { Export, Rows, Message, Far, Birth };
    // A linear or given fact that has arrived for a catom of this process in this tick.
    struct Arrival {
        Catom to;
        u16 predicate;
        const Value* arguments;
    };
    struct Export {
        Catom catom;
        u16 column;
    };

    // A linear fact for a catom of this process: it arrives at the end of this tick, or when the network says so.
    void come(Catom to, u64 from, u16 predicate, const Value* arguments);
    // The same for one that went to its node without a link; if it is still there.
    void come_far(u64 to, u64 from, u16 predicate, const Value* arguments);
    void send_far();
    // Facts with which nodes begin.
    void send_births();
    // The nodes that rules have made, with their facts; no network is between them and their makers.
    void bear();
    void pack_far(Record record, const eval::FarMessage& message, int owner);
    void pack();
    void pack_rows();
    void pack_export(ByteWriter& out, const Export& changed) const;
    void pack_message(ByteWriter& out, const eval::Message& message) const;
    void pack_arguments(ByteWriter& out, u16 predicate, const Value* arguments) const;
    // How processes name a catom to each other: by its cell, or by its id if there are no cells.
    void pack_name(ByteWriter& out, Catom catom) const;
    Catom unpack_name(ByteReader& in, int sender) const;
    // Adds the facts in the packet to the arrivals, with their arguments in `arguments` and lists in `lists`.
    void unpack(const comm::Packet& packet, std::deque<std::vector<Value>>& arguments, tuple::Arena& lists);
    const Value* unpack_arguments(u16 predicate, ByteReader& in, std::deque<std::vector<Value>>& arguments, tuple::Arena& lists) const;
    void unpack_rows(u16 column, Catom catom, ByteReader& in);
    void sort_arrivals();
    // Gives them all, several at a time for one catom.
    void deliver();
    void deliver_all();

    Subdomain& subdomain_;
    std::vector<std::vector<std::vector<Export>>> exports_;  // By worker and destination.
    std::vector<ByteWriter> packets_;                        // By destination.
    std::vector<std::vector<eval::Change>> changed_;         // By worker, for a network that takes time.
    std::uint64_t sent_bytes_ = 0, lost_ = 0;
    Births births_;
    // The arrivals of a tick, and their order; reused so that a tick allocates nothing.
    std::vector<Arrival> arrivals_, sorted_;
    std::vector<Keyed> order_, spare_;
    std::vector<const Value*> together_;
    std::vector<u8> before_;  // A record of a ghost, until it has been replaced.
};

}  // namespace meld::sim
