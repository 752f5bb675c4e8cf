// What an exchange of packets needs of a library that passes messages, so that the same protocol runs over MPI and in the virtual cluster.
// Private to runtime/comm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "runtime/comm/transport/communicator.h"

namespace meld::comm {

// As in MPI, messages from one process to another with one tag keep their order, and nothing else is promised.
class Transport {
  public:
    virtual ~Transport() = default;
    virtual int process() const = 0;
    virtual int processes() const = 0;

    enum class Kind {
        Standard,
        Synchronous,  // Complete only when the receiver has begun to receive it.
    };
    // Begin to send or to receive. The bytes must stay where they are until all is complete.
    virtual void send(std::span<const std::byte> bytes, int to, int tag, Kind kind) = 0;
    virtual void receive(std::span<std::byte> bytes, int from, int tag) = 0;
    // Whether all that was begun is complete. If so, it is forgotten.
    virtual bool complete() = 0;

    // A message with this tag from anybody, if one waits here.
    virtual std::optional<Packet> take(int tag) = 0;

    virtual void begin_barrier() = 0;
    // Whether all processes have begun the barrier. If so, it is over.
    virtual bool barrier_is_over() = 0;

    // A word for each process, and from each. Every process calls it, and it waits for all.
    virtual void swap_words(std::span<const std::uint64_t> mine, std::span<std::uint64_t> theirs) = 0;

    // Called while the caller waits for others, and when it has got something.
    virtual void pause() = 0;
    virtual void go_on() = 0;
};

}  // namespace meld::comm
