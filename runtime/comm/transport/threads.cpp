// Threads in place of processes. Every operation is: put my data on the board, meet all others, take the data for me. There are two boards,
// used in turn: a process that is already in the next operation writes to the other one, and nobody can be two operations ahead, so one
// meeting per operation is enough.
#include <array>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>

#include "runtime/base/process/parallel_for.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/comm/transport/threads.h"

namespace meld::comm {

namespace {

enum class Operation { Exchange, Allgather, AllgatherAny, Barrier };

const char* name_of(Operation operation) {
    switch (operation) {
        case Operation::Exchange:
            return "exchange";
        case Operation::Allgather:
            return "allgather";
        case Operation::AllgatherAny:
            return "allgather_any";
        case Operation::Barrier:
            return "barrier";
    }
    return "";
}

using Bytes = std::vector<std::byte>;

// The data that one process has put on the board for the others.
struct Offer {
    std::vector<Packet> packets;
    Bytes bytes;
};

class Hall {
  public:
    explicit Hall(int processes)
        : processes_(static_cast<std::size_t>(processes)), boards_{std::vector<Offer>(processes_), std::vector<Offer>(processes_)} {}

    std::size_t processes() const { return processes_; }
    std::vector<Offer>& board(std::size_t round) { return boards_[round % 2]; }

    // Returns when all processes have arrived at the same operation; throws if that can no longer happen.
    void meet(Operation operation) {
        std::unique_lock lock(mutex_);
        leave_if_failed();
        if (finished_ > 0) break_with(fmt::format("a process calls {} after another process has finished", name_of(operation)));
        if (arrived_ == 0) operation_ = operation;
        if (operation_ != operation)
            break_with(fmt::format("a process calls {} while another one calls {}", name_of(operation), name_of(operation_)));
        MELD_ASSERT(arrived_ < processes_, "{} of {} processes have arrived", arrived_, processes_);
        const std::size_t meeting = meeting_;
        if (++arrived_ == processes_) {
            arrived_ = 0;
            ++meeting_;
            changed_.notify_all();
            return;
        }
        changed_.wait(lock, [&] { return meeting_ != meeting || failed_; });
        if (meeting_ == meeting) leave_if_failed();
    }

    // A process has returned from its body.
    void finish() {
        const std::lock_guard lock(mutex_);
        MELD_EXPECT(finished_ < processes_, "{} of {} processes have finished", finished_, processes_);
        ++finished_;
        if (arrived_ > 0 && !failed_) {
            failure_ = std::make_exception_ptr(
                std::logic_error(fmt::format("a process has finished while another one calls {}", name_of(operation_))));
            failed_ = true;
            changed_.notify_all();
        }
    }

    // A process has left its body by an exception: all others leave theirs at their next meeting.
    void fail(std::exception_ptr failure) {
        const std::lock_guard lock(mutex_);
        if (!failed_) failure_ = std::move(failure);
        failed_ = true;
        changed_.notify_all();
    }

    void rethrow_if_failed() const {
        if (failure_) std::rethrow_exception(failure_);
    }

  private:
    void leave_if_failed() const {
        if (failed_) throw OtherProcessFailed();
    }
    [[noreturn]] void break_with(const std::string& what) {
        failure_ = std::make_exception_ptr(std::logic_error(what));
        failed_ = true;
        changed_.notify_all();
        std::rethrow_exception(failure_);
    }

    const std::size_t processes_;
    std::array<std::vector<Offer>, 2> boards_;
    std::mutex mutex_;
    std::condition_variable changed_;
    Operation operation_ = Operation::Barrier;
    std::size_t arrived_ = 0;
    std::size_t meeting_ = 0;
    std::size_t finished_ = 0;
    bool failed_ = false;
    std::exception_ptr failure_;
};

class ThreadProcess final : public Communicator {
  public:
    ThreadProcess(Hall& hall, int process) : hall_(hall), process_(process) {}

    int process() const override { return process_; }
    int processes() const override { return static_cast<int>(hall_.processes()); }

    std::vector<Packet> exchange(std::vector<Packet> packets) override {
        check_packets(packets, process_, processes());
        auto& board = put({.packets = std::move(packets), .bytes = {}}, Operation::Exchange);
        std::vector<Packet> received;
        for (std::size_t from = 0; from < board.size(); ++from) {
            for (Packet& packet : board[from].packets) {
                if (packet.process == process_) received.push_back({static_cast<int>(from), std::move(packet.bytes)});
            }
        }
        return received;
    }

    Bytes allgather(std::span<const std::byte> bytes) override {
        const auto& board = put({.packets = {}, .bytes = Bytes(bytes.begin(), bytes.end())}, Operation::Allgather);
        Bytes all;
        for (const Offer& offer : board) {
            if (offer.bytes.size() != bytes.size()) throw std::logic_error("processes call allgather with different sizes");
            all.insert(all.end(), offer.bytes.begin(), offer.bytes.end());
        }
        return all;
    }

    std::vector<Bytes> allgather_any(std::span<const std::byte> bytes) override {
        const auto& board = put({.packets = {}, .bytes = Bytes(bytes.begin(), bytes.end())}, Operation::AllgatherAny);
        std::vector<Bytes> all;
        for (const Offer& offer : board) all.push_back(offer.bytes);
        return all;
    }

    void barrier() override { put({}, Operation::Barrier); }

    [[noreturn]] void abort(int exit_code) override {
        hall_.fail(std::make_exception_ptr(ProcessAborted(exit_code)));
        throw ProcessAborted(exit_code);
    }

  private:
    std::vector<Offer>& put(Offer offer, Operation operation) {
        std::vector<Offer>& board = hall_.board(round_++);
        MELD_EXPECT(static_cast<std::size_t>(process_) < board.size(), "process {} of {}", process_, board.size());
        board[static_cast<std::size_t>(process_)] = std::move(offer);
        hall_.meet(operation);
        return board;
    }

    Hall& hall_;
    const int process_;
    std::size_t round_ = 0;
};

}  // namespace

void run_threads_as_processes(int processes, const std::function<void(Communicator&)>& body) {
    MELD_CHECK(processes >= 1, "processes = {}", processes);
    Hall hall(processes);
    // As many workers as processes: a process that waits for the others keeps its worker, so every process gets one.
    Workers workers(processes);
    workers.run(static_cast<std::size_t>(processes), [&](int, std::size_t index) {
        ThreadProcess process(hall, static_cast<int>(index));
        try {
            body(process);
            hall.finish();
        } catch (...) {
            hall.fail(std::current_exception());
        }
    });
    hall.rethrow_if_failed();
}

}  // namespace meld::comm
