// The table is a file in memory without a name, which the others open through /proc: nothing remains if a process is killed.
#include "runtime/comm/transport/stragglers.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/liveness.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/units.h"
#include "runtime/comm/launch/child_processes.h"

namespace meld::comm {

namespace {

// A stopped process is reported soon, because there is no doubt; one that is only late may be busy with a long piece of work.
constexpr double kStopped_s = 3;
constexpr double kLate_s = 30;

// The information of each process about itself.
struct Address {
    std::array<char, 64> host{};
    int pid = 0;
    int file = -1;
};

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void say(const std::string& line) {
    clear_progress();
    static_cast<void>(print(stderr, line));
}

}  // namespace

Stragglers::Stragglers(MPI_Comm communicator) {
    int process = 0, processes = 0;
    MPI_Comm_rank(communicator, &process);
    MPI_Comm_size(communicator, &processes);
    process_ = static_cast<std::size_t>(process);
    const std::size_t bytes = sizeof(Place) * static_cast<std::size_t>(processes);
    Address mine;
    gethostname(mine.host.data(), mine.host.size() - 1);
    mine.pid = getpid();
    const int memory = memfd_create("claymeld-stragglers", MFD_CLOEXEC);
    if (memory >= 0 && ftruncate(memory, static_cast<off_t>(bytes)) == 0) mine.file = memory;
    std::vector<Address> all(static_cast<std::size_t>(processes));
    MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, communicator);
    const auto is_here = [&](const Address& a) { return a.host == mine.host; };
    // All use the table of the first process here.
    const Address& first = *std::find_if(all.begin(), all.end(), is_here);
    const int file = first.file < 0 ? -1 : open(fmt::format("/proc/{}/fd/{}", first.pid, first.file).c_str(), O_RDWR | O_CLOEXEC);
    void* table = file < 0 ? MAP_FAILED : mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (table != MAP_FAILED) table_ = static_cast<Place*>(table);
    for (const Address& a : all) pids_.push_back(table_ != nullptr && is_here(a) ? a.pid : 0);
    MPI_Barrier(communicator);
    for (const int each : {file, memory})
        if (each >= 0) close(each);
}

Stragglers::~Stragglers() {
    if (table_ != nullptr) munmap(table_, sizeof(Place) * count());
}

bool Stragglers::late(std::size_t process) const {
    return pids_[process] != 0 && table_[process].operations.load(std::memory_order_relaxed) < operations_;
}

bool Stragglers::stopped(std::size_t process) const { return pids_[process] != 0 && process != process_ && is_stopped(pids_[process]); }

bool Stragglers::speaks() const {
    for (std::size_t p = 0; p < process_; ++p)
        if (pids_[p] != 0 && !late(p) && !stopped(p)) return false;
    return true;
}

void Stragglers::begin_operation() {
    ++operations_;
    liveness::beat();
    if (table_ != nullptr) table_[process_].operations.store(operations_, std::memory_order_relaxed);
    if (!waits_since_) return;
    for (const std::size_t process : told_)
        say(fmt::format("process {} answers again, after {}\n", process, format_duration(seconds_since(*waits_since_))));
    told_.clear();
    waits_since_.reset();
}

void Stragglers::look() {
    if (!waits_since_) waits_since_ = Clock::now();
    const double seconds = seconds_since(*waits_since_);
    if (seconds < kStopped_s || !speaks()) return;
    for (std::size_t process = 0; process < count(); ++process) {
        if (std::find(told_.begin(), told_.end(), process) != told_.end()) continue;
        const bool is_stopped = stopped(process);
        if (!is_stopped && !(seconds >= kLate_s && late(process))) continue;
        say(is_stopped ? fmt::format("process {0} has been stopped for {1}, and the others wait; `kill -CONT {2}` lets it go on\n", process,
                                     format_duration(seconds), pids_[process])
                       : fmt::format("process {} (number {} on this machine) has not answered for {}, and the others wait\n", process,
                                     pids_[process], format_duration(seconds)));
        told_.push_back(process);
    }
}

}  // namespace meld::comm
