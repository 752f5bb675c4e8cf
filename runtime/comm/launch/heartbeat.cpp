#include "runtime/comm/launch/heartbeat.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "runtime/comm/launch/child_processes.h"

namespace meld::comm {

Heartbeat::Heartbeat(int processes, double seconds) : count_(static_cast<std::size_t>(processes)), seconds_(seconds) {
    const std::size_t bytes = count_ * sizeof(liveness::Place);
    file_ = memfd_create("claymeld-liveness", MFD_CLOEXEC);
    // Also without a table: it tells a child that it is supervised.
    place_ = fmt::format("/proc/{}/fd/{}", getpid(), file_);
    if (file_ < 0 || ftruncate(file_, static_cast<off_t>(bytes)) != 0) return;
    void* const table = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
    if (table == MAP_FAILED) return;
    table_ = static_cast<liveness::Place*>(table);
    begin();
}

Heartbeat::~Heartbeat() {
    if (table_ != nullptr) munmap(table_, count_ * sizeof(liveness::Place));
    if (file_ >= 0) close(file_);
}

void Heartbeat::begin() {
    if (table_ != nullptr) std::memset(static_cast<void*>(table_), 0, count_ * sizeof(liveness::Place));
    last_beats_ = 0;
    silent_s_ = 0;
    last_look_ = Clock::now();
}

bool Heartbeat::missed() {
    if (table_ == nullptr || seconds_ <= 0) return false;
    const Clock::time_point now = Clock::now();
    const double since = std::min(kMaxBetweenLooks_s, std::chrono::duration<double>(now - last_look_).count());
    last_look_ = now;
    std::uint64_t beats = 0;
    bool reader_pauses = false;
    for (std::size_t i = 0; i < count_; ++i) {
        beats += table_[i].beats.load(std::memory_order_relaxed);
        reader_pauses |= table_[i].writes.load(std::memory_order_relaxed) > 0 && !is_stopped(table_[i].process.load());
    }
    silent_s_ = beats == 0 || beats != last_beats_ || reader_pauses ? 0 : silent_s_ + since;
    last_beats_ = beats;
    return silent_s_ >= seconds_;
}

Heartbeat::Standing Heartbeat::standing() const {
    Standing out;
    if (table_ == nullptr) return out;
    for (std::size_t i = 0; i < count_; ++i) {
        const liveness::Place& place = table_[i];
        out.tick = std::max(out.tick, place.tick.load());
        const bool stopped = place.process.load() != 0 && is_stopped(place.process.load());
        // Whoever is stopped keeps the others waiting, whatever it was at.
        if (stopped ? out.stopped : place.waits.load() || out.stopped) continue;
        out.busy = stopped ? 1 : out.busy + 1;
        out.stopped = stopped;
        out.process = static_cast<int>(i);
        out.phase = place.phase.load();
    }
    if (out.busy != 1) out.process = -1;
    return out;
}

const char* describe(liveness::Phase phase) {
    switch (phase) {
        case liveness::Phase::SetUp:
            return "while it set up";
        case liveness::Phase::Modules:
            return "in its motion or another module";
        case liveness::Phase::Evaluation:
            return "in the evaluation of the program";
        case liveness::Phase::Exchange:
            return "in the exchange between processes";
        case liveness::Phase::Recording:
            return "in a module after the tick";
        case liveness::Phase::Checkpoint:
            return "in writing a checkpoint";
    }
    return "";
}

}  // namespace meld::comm
