#include "runtime/comm/transport/cluster.h"

#include <exception>
#include <stdexcept>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/random.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/comm/transport/sparse_exchange.h"
#include "runtime/comm/transport/threads.h"
#include "runtime/comm/transport/virtual_network.h"

namespace meld::comm {

namespace {

class VirtualProcess final : public Communicator {
  public:
    VirtualProcess(VirtualNetwork& network, const ClusterOptions& options, int process)
        : network_(network), seed_(options.seed), transport_(network, process), exchange_(transport_, options.chunk_bytes) {}

    int process() const override { return transport_.process(); }
    int processes() const override { return transport_.processes(); }

    std::vector<Packet> exchange(std::vector<Packet> packets) override {
        check_packets(packets, process(), processes());
        begin("exchange");
        const bool by_counts = random_bits(seed_, network_.operations(process()), 0, 0) % 2 == 0;
        return by_counts ? exchange_.by_counts(packets) : exchange_.by_consensus(packets);
    }

    std::vector<std::byte> allgather(std::span<const std::byte> bytes) override {
        begin("allgather");
        std::vector<std::byte> all;
        for (const std::vector<std::byte>& each : transport_.meet(bytes)) {
            if (each.size() != bytes.size()) network_.scheduler.break_with("processes call allgather with different sizes");
            all.insert(all.end(), each.begin(), each.end());
        }
        return all;
    }

    std::vector<std::vector<std::byte>> allgather_any(std::span<const std::byte> bytes) override {
        begin("allgather_any");
        return transport_.meet(bytes);
    }

    void barrier() override {
        begin("barrier");
        transport_.meet({});
    }

    [[noreturn]] void abort(int exit_code) override {
        network_.scheduler.fail(std::make_exception_ptr(ProcessAborted(exit_code)));
        throw ProcessAborted(exit_code);
    }

  private:
    void begin(const char* operation) { network_.begin_operation(process(), operation); }

    VirtualNetwork& network_;
    const std::uint64_t seed_;
    VirtualTransport transport_;
    SparseExchange exchange_;
};

}  // namespace

ClusterRun run_cluster(const ClusterOptions& options, const std::function<void(Communicator&)>& body) {
    MELD_CHECK(options.processes >= 1, "processes = {}", options.processes);
    VirtualNetwork network(options);
    // A process that waits for its turn keeps its worker, so every process gets one.
    Workers workers(options.processes);
    workers.run(static_cast<std::size_t>(options.processes), [&](int, std::size_t index) {
        const auto number = static_cast<int>(index);
        VirtualProcess process(network, options, number);
        try {
            network.scheduler.begin(number);
            body(process);
            network.scheduler.end(number);
        } catch (...) {
            network.scheduler.fail(std::current_exception());
        }
    });
    return network.scheduler.outcome();
}

}  // namespace meld::comm
