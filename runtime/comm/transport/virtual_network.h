// The messages of the virtual cluster. Private to runtime/comm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "runtime/comm/transport/cluster_scheduler.h"
#include "runtime/comm/transport/transport.h"

namespace meld::comm {

// Only the process whose turn it is looks at it.
struct VirtualNetwork {
    explicit VirtualNetwork(const ClusterOptions& options);

    struct Message {
        int tag;
        std::span<const std::byte> bytes;  // The sender's, or kept.
        std::vector<std::byte> kept;
        std::uint64_t seen_from;  // The step.
        bool complete;
    };
    using Channel = std::deque<std::shared_ptr<Message>>;
    Channel& channel(int from, int to) { return channels_[static_cast<std::size_t>(from * processes + to)]; }

    // Every process calls it at the beginning of an operation; that of the others must be the same.
    void begin_operation(int process, const std::string& name);
    // How many operations the process has begun.
    std::uint64_t operations(int process) const { return begun_[static_cast<std::size_t>(process)]; }

    const int processes;
    ClusterScheduler scheduler;
    std::vector<std::uint64_t> barriers;  // That a process has begun.
    // What processes have offered in the meeting of this number and the one before.
    std::array<std::vector<std::vector<std::byte>>, 2> offers;
    std::vector<std::uint64_t> meetings;  // That a process has come to.

  private:
    std::vector<Channel> channels_;
    std::vector<std::uint64_t> begun_;
    std::deque<std::string> names_;  // Of the operations of which not all know yet.
    std::uint64_t known_ = 0;        // How many are known to all.
};

class VirtualTransport final : public Transport {
  public:
    VirtualTransport(VirtualNetwork& network, int process) : network_(network), process_(process) {}

    int process() const override { return process_; }
    int processes() const override { return network_.processes; }
    void send(std::span<const std::byte> bytes, int to, int tag, Kind kind) override;
    void receive(std::span<std::byte> bytes, int from, int tag) override;
    bool complete() override;
    std::optional<Packet> take(int tag) override;
    void begin_barrier() override;
    bool barrier_is_over() override;
    void swap_words(std::span<const std::uint64_t> mine, std::span<std::uint64_t> theirs) override;
    void pause() override { network_.scheduler.hand_over(process_); }
    void go_on() override {}

    // What all processes offer, by process. Every process calls it, and it waits for all.
    std::vector<std::vector<std::byte>> meet(std::span<const std::byte> offer);

  private:
    struct Wanted {
        std::span<std::byte> bytes;
        int from, tag;
        bool complete = false;
    };
    // The first message of a process with a tag, if it can be seen.
    std::shared_ptr<VirtualNetwork::Message> first(int from, int tag) const;
    void remove(int from, const std::shared_ptr<VirtualNetwork::Message>& message);

    VirtualNetwork& network_;
    const int process_;
    std::vector<std::shared_ptr<VirtualNetwork::Message>> sent_;
    std::vector<Wanted> wanted_;
};

}  // namespace meld::comm
