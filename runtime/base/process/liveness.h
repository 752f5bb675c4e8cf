// Signs of life of a run, for the process that supervises it: a table in shared memory with a place for each process. Code calls beat()
// wherever work gets on: a block of catoms, an operation between processes, a piece of a file. Without a supervisor nothing is stored.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

namespace meld::liveness {

// What a process is doing.
enum class Phase : std::uint32_t { SetUp, Modules, Evaluation, Exchange, Recording, Checkpoint };

struct alignas(64) Place {
    std::atomic<std::uint64_t> beats;  // Whether it changes is all that counts.
    std::atomic<std::int64_t> tick;    // 0 before the first.
    std::atomic<Phase> phase;
    std::atomic<std::int32_t> process;  // The system's number; 0: nobody is here yet.
    std::atomic<bool> waits;            // For other processes.
    std::atomic<std::int32_t> writes;   // How many of its threads write to a stream, whose reader may take any time.
    std::atomic<std::int32_t> here;     // How many processes of the run are on its machine.
    std::atomic<bool> left;             // It has come to its own end: nothing that it had to do is lost.
    std::atomic<bool> told;             // Of process 0: it has reported how the run ended.
};

// The variable by which a supervisor tells its processes where the table is.
inline constexpr const char* kVariable = "CLAYMELD_LIVENESS";

// Takes the place with this number in the supervisor's table, if there is one; further processes started from here have none. `here` is the
// number of processes of the run on this machine. Call it once, before other threads start. Returns whether the supervisor is the parent of
// this process.
bool attach(std::size_t place, int here);

namespace detail {
extern Place* own;
}

// Any thread may call these. Cost: a comparison, and a store or two where somebody looks.
inline void beat() {
    if (detail::own == nullptr) [[likely]]
        return;
    // Two threads may lose a beat; one of both is enough.
    detail::own->beats.store(detail::own->beats.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}
inline void enter(Phase phase) {
    if (detail::own != nullptr) detail::own->phase.store(phase, std::memory_order_relaxed);
    beat();
}
inline void begin_tick(std::int64_t tick) {
    if (detail::own != nullptr) detail::own->tick.store(tick, std::memory_order_relaxed);
    enter(Phase::Modules);
}
// Also in handlers of signals.
inline void note_told() {
    if (detail::own != nullptr) detail::own->told.store(true, std::memory_order_relaxed);
}
inline void wait(bool waits) {
    if (detail::own != nullptr) detail::own->waits.store(waits, std::memory_order_relaxed);
}

// Exists while this thread writes to a stream, or opens one: a terminal or a pipe may block it until its reader has read.
class WritesToStream {
  public:
    WritesToStream() {
        if (detail::own != nullptr) detail::own->writes.fetch_add(1, std::memory_order_relaxed);
    }
    ~WritesToStream() {
        if (detail::own != nullptr) detail::own->writes.fetch_sub(1, std::memory_order_relaxed);
        beat();
    }
    WritesToStream(const WritesToStream&) = delete;
    WritesToStream& operator=(const WritesToStream&) = delete;
};

}  // namespace meld::liveness
