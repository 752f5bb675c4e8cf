// The end of a tick between processes: changed exports go to those that hold ghosts of their catoms, facts to the owners of theirs.
//
// Four steps: what is exported is noted while it is committed, packed per destination, exchanged, and unpacked; facts that were sent
// are then given to their receivers in the order that the senders' ids and sequence numbers say, on any number of processes.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/radix_sort.h"
#include "runtime/comm/communicator.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Exchange {
  public:
    explicit Exchange(Subdomain& subdomain);

    // An exported column has changed; each worker notes its own.
    void note_export(int worker, Catom catom, u16 column);
    // After the evaluation, on every process: sends and receives. The facts are seen in the next tick.
    void run();
    // Sent to other processes in this tick.
    std::uint64_t sent_bytes() const { return sent_bytes_; }

  private:
    enum class Record : std::uint8_t { Export, Rows, Message };
    // A linear or given fact that has come for a catom of this process in this tick.
    struct Arrival {
        Catom to;
        u16 predicate;
        const Value* arguments;
    };
    struct Export {
        Catom catom;
        u16 column;
    };

    void pack();
    void pack_export(ByteWriter& out, const Export& changed) const;
    void pack_message(ByteWriter& out, const eval::Message& message) const;
    // How processes name a catom to each other: by its cell, or where there are none by its id.
    void pack_name(ByteWriter& out, Catom catom) const;
    Catom unpack_name(ByteReader& in, int sender) const;
    // The facts in the packet are added to the arrivals, with their arguments in `arguments` and lists in `lists`.
    void unpack(const comm::Packet& packet, std::deque<std::vector<Value>>& arguments, tuple::Arena& lists);
    void unpack_rows(u16 column, Catom catom, ByteReader& in);
    void sort_arrivals();
    // Gives them all, many for one catom at once.
    void deliver();

    Subdomain& subdomain_;
    std::vector<std::vector<std::vector<Export>>> exports_;  // By worker and destination.
    std::vector<ByteWriter> packets_;                        // By destination.
    std::uint64_t sent_bytes_ = 0;
    // What arrives in a tick, and its order; kept so that a tick allocates nothing.
    std::vector<Arrival> arrivals_, sorted_;
    std::vector<Keyed> order_, spare_;
    std::vector<const Value*> together_;
};

}  // namespace meld::sim
