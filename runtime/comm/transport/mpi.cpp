// The communicator of real processes. One thread of each process calls it (MPI_THREAD_FUNNELED).
#include <malloc.h>
#include <mpi.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/comm/transport/mpi_options.h"
#include "runtime/comm/transport/mpi_transport.h"
#include "runtime/comm/transport/mpi_wait.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/comm/transport/sparse_exchange.h"

namespace meld::comm {

namespace {

// Up to this number of processes the exchange agrees on counts; above, on the end of the round. Measured on two cores, in microseconds, by
// counts against by consensus, with one packet of 64 bytes from each process: 0.5 : 1.2 on 2 processes, 5.9 : 12.4 on 4, 18 : 35 on 8, and
// 103 : 133 on 16, where it is 80 : 76 if no process has anything to send. Above 20 kB a packet the two are equal.
constexpr int kMaxProcessesByCounts = 8;

int live_communicators = 0;
bool we_initialised = false;

long number_in_environment(const char* name) {
    const char* text = std::getenv(name);
    if (text == nullptr) return 0;
    long value = 0;
    std::from_chars(text, text + std::strlen(text), value);
    return value;
}

// With more processes than cores, a process that waits must yield: otherwise it spins away the time slice of the one it
// waits for (an allreduce then takes 40 milliseconds). Open MPI reads this only from the environment, before MPI_Init.
void yield_if_oversubscribed() {
    const long processes_here = number_in_environment("OMPI_COMM_WORLD_LOCAL_SIZE");
    if (processes_here <= sysconf(_SC_NPROCESSORS_ONLN)) return;
    setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
    Backoff::expect_crowd();
}

// Where all processes share a machine they speak through its memory. Open MPI then still asks every kind of network hardware whether it
// is there, one of which measures its clock for a fifth of a second: two processes start in 0.10 s instead of 0.34 without it.
void skip_networks_within_machine() {
    const long processes_here = number_in_environment("OMPI_COMM_WORLD_LOCAL_SIZE");
    if (processes_here == 0 || processes_here != number_in_environment("OMPI_COMM_WORLD_SIZE")) return;
    setenv("OMPI_MCA_pml", "ob1", 0);
}

// Packets are allocated again in every round. By default the C library returns large blocks to the system at once, and the page faults of
// the next round then cost ten times the transfer (880 against 62 microseconds for a megabyte).
void keep_freed_memory() {
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 512 << 20);
}

void initialise() {
    int finalized = 0;
    MPI_Finalized(&finalized);
    MELD_CHECK(finalized == 0, "MPI cannot be started again after its last communicator is gone");
    int initialised = 0;
    MPI_Initialized(&initialised);
    if (initialised != 0) return;
    yield_if_oversubscribed();
    skip_networks_within_machine();
    keep_freed_memory();
    // Also one that mpirun has just begun to start ends with it.
    if (under_mpi()) prctl(PR_SET_PDEATHSIG, SIGTERM);
    int provided = MPI_THREAD_SINGLE;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MELD_CHECK(provided >= MPI_THREAD_FUNNELED, "the MPI library provides thread level {}", provided);
    we_initialised = true;
}

MPI_Comm duplicate_of_world() {
    initialise();
    MPI_Comm duplicate = MPI_COMM_NULL;
    MPI_Comm_dup(MPI_COMM_WORLD, &duplicate);
    return duplicate;
}

class Mpi final : public Communicator {
  public:
    explicit Mpi(const MpiOptions& options)
        : communicator_(duplicate_of_world()),
          transport_(communicator_),
          exchange_(transport_, options.chunk_bytes),
          chunk_bytes_(options.chunk_bytes) {
        MPI_Comm_rank(communicator_, &process_);
        MPI_Comm_size(communicator_, &processes_);
        by_counts_ = options.exchange == ExchangeKind::Counts ||
                     (options.exchange == ExchangeKind::Automatic && processes_ <= kMaxProcessesByCounts);
        ++live_communicators;
        Backoff::set_stragglers(&stragglers_);
    }

    // If an exception ended this process while the others wait for it, they would wait for ever: end all.
    ~Mpi() override {
        if (std::uncaught_exceptions() > exceptions_at_start_) {
            std::fprintf(stderr, "process %d of %d failed; ending all processes\n", process_, processes_);
            Mpi::abort(static_cast<int>(ExitCode::OurBug));
        }
        Backoff::set_stragglers(nullptr);
        MPI_Comm_free(&communicator_);
        if (--live_communicators == 0 && we_initialised) MPI_Finalize();
    }

    Mpi(const Mpi&) = delete;
    Mpi& operator=(const Mpi&) = delete;

    int process() const override { return process_; }
    int processes() const override { return processes_; }

    std::vector<Packet> exchange(std::vector<Packet> packets) override {
        check_packets(packets, process_, processes_);
        stragglers_.begin_operation();
        return by_counts_ ? exchange_.by_counts(packets) : exchange_.by_consensus(packets);
    }

    std::vector<std::byte> allgather(std::span<const std::byte> bytes) override {
        stragglers_.begin_operation();
        std::vector<std::byte> all(bytes.size() * static_cast<std::size_t>(processes_));
        for_each_chunk(bytes.size(), [&](std::size_t begin, int size) {
            if (size == static_cast<int>(bytes.size())) {
                allgather_now(bytes.data(), size, all.data());
                return;
            }
            std::vector<std::byte> gathered(static_cast<std::size_t>(size) * static_cast<std::size_t>(processes_));
            allgather_now(bytes.data() + begin, size, gathered.data());
            for (std::size_t process = 0; process < static_cast<std::size_t>(processes_); ++process)
                std::memcpy(all.data() + process * bytes.size() + begin, gathered.data() + process * static_cast<std::size_t>(size),
                            static_cast<std::size_t>(size));
        });
        return all;
    }

    std::vector<std::vector<std::byte>> allgather_any(std::span<const std::byte> bytes) override {
        stragglers_.begin_operation();
        const std::uint64_t own_size = bytes.size();
        std::vector<std::uint64_t> sizes(static_cast<std::size_t>(processes_));
        allgather_now(&own_size, sizeof own_size, sizes.data());
        std::uint64_t total = 0;
        for (const std::uint64_t size : sizes) total += size;
        MELD_ENSURE(total >= own_size, "{} bytes in all, and {} of them of this process", total, own_size);
        return total <= chunk_bytes_ ? gather_at_once(bytes, sizes, total) : gather_by_broadcasts(bytes, sizes);
    }

    void barrier() override {
        stragglers_.begin_operation();
        MPI_Request request = MPI_REQUEST_NULL;
        MPI_Ibarrier(communicator_, &request);
        wait_with_backoff(request);
    }

    [[noreturn]] void abort(int exit_code) override {
        std::fflush(nullptr);
        MPI_Abort(MPI_COMM_WORLD, exit_code);
        std::_Exit(exit_code);
    }

  private:
    void allgather_now(const void* from, int size, void* to) const {
        MPI_Request request = MPI_REQUEST_NULL;
        MPI_Iallgather(from, size, MPI_BYTE, to, size, MPI_BYTE, communicator_, &request);
        wait_with_backoff(request);
    }

    template <class Action>
    void for_each_chunk(std::size_t size_bytes, const Action& action) const {
        for (std::size_t begin = 0; begin < size_bytes; begin += chunk_bytes_)
            action(begin, static_cast<int>(std::min(chunk_bytes_, size_bytes - begin)));
    }

    std::vector<std::vector<std::byte>> gather_at_once(std::span<const std::byte> bytes, const std::vector<std::uint64_t>& sizes,
                                                       std::uint64_t total) const {
        MELD_EXPECT(sizes[static_cast<std::size_t>(process_)] == bytes.size() && total <= chunk_bytes_, "{} bytes of {}", bytes.size(),
                    total);
        std::vector<int> counts, begins;
        int begin = 0;
        for (const std::uint64_t size : sizes) {
            counts.push_back(static_cast<int>(size));
            begins.push_back(begin);
            begin += counts.back();
        }
        std::vector<std::byte> all(total);
        MPI_Request request = MPI_REQUEST_NULL;
        MPI_Iallgatherv(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, all.data(), counts.data(), begins.data(), MPI_BYTE,
                        communicator_, &request);
        wait_with_backoff(request);
        std::vector<std::vector<std::byte>> result;
        for (std::size_t process = 0; process < sizes.size(); ++process)
            result.emplace_back(all.begin() + begins[process], all.begin() + begins[process] + counts[process]);
        return result;
    }

    std::vector<std::vector<std::byte>> gather_by_broadcasts(std::span<const std::byte> bytes,
                                                             const std::vector<std::uint64_t>& sizes) const {
        std::vector<std::vector<std::byte>> result;
        for (int from = 0; from < processes_; ++from) {
            std::vector<std::byte>& piece = result.emplace_back(sizes[static_cast<std::size_t>(from)]);
            if (from == process_) piece.assign(bytes.begin(), bytes.end());
            for_each_chunk(piece.size(),
                           [&](std::size_t begin, int size) { MPI_Bcast(piece.data() + begin, size, MPI_BYTE, from, communicator_); });
        }
        return result;
    }

    MPI_Comm communicator_;
    Stragglers stragglers_{communicator_};
    MpiTransport transport_;
    SparseExchange exchange_;
    std::size_t chunk_bytes_;
    int process_ = 0;
    int processes_ = 1;
    bool by_counts_ = false;
    const int exceptions_at_start_ = std::uncaught_exceptions();
};

}  // namespace

std::unique_ptr<Communicator> make_mpi(const MpiOptions& options) { return std::make_unique<Mpi>(options); }

std::unique_ptr<Communicator> make_mpi() { return make_mpi(MpiOptions{}); }

bool under_mpi() {
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"}) {
        if (std::getenv(name) != nullptr) return true;
    }
    // A batch script itself runs as a Slurm step of one task; only several tasks are processes of one run.
    return number_in_environment("SLURM_STEP_NUM_TASKS") > 1;
}

}  // namespace meld::comm
