// The worker threads. A job is open while indices may remain; a worker that wakes late finds it closed and goes back to sleep, so the
// caller waits only for workers that have joined the job, never for a thread the machine has not yet scheduled.
#include "runtime/base/process/parallel_for.h"

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/process/liveness.h"

namespace meld {

namespace {

// The gate is one word, so that joining a job and closing it are single atomic steps:
// number of the job | is it open | number of workers inside.
constexpr std::uint64_t kInsideMask = 0xffff;
constexpr std::uint64_t kOpenBit = 0x10000;
constexpr int kJobShift = 17;
constexpr int kMaxThreads = 4096;

// A tick starts several jobs in quick succession: waiting this long saves the wake-up, and costs little when idle.
constexpr auto kSpinTime = std::chrono::microseconds(20);
constexpr int kPausesPerClockRead = 16;

inline void pause_processor() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#else
    std::this_thread::yield();
#endif
}

}  // namespace

struct Workers::Shared {
    explicit Shared(bool spinning) : spins(spinning) {}

    alignas(64) std::atomic<std::uint64_t> gate{0};
    alignas(64) std::atomic<std::size_t> next{0};

    // The job; written only while no worker is inside.
    alignas(64) const std::function<void(int, std::size_t)>* body = nullptr;
    std::size_t count = 0;
    std::atomic<bool> failed{false};
    std::exception_ptr failure;  // Guarded by `mutex`.

    std::atomic<bool> running{false};
    std::atomic<bool> stopping{false};
    const bool spins;
    std::mutex mutex;
    std::condition_variable job_opened;
    std::condition_variable job_left;
    std::atomic<int> sleepers{0};
    std::atomic<bool> caller_sleeps{false};
    std::vector<std::thread> threads;

    template <class Condition>
    bool spin_until(const Condition& condition) const {
        if (condition()) return true;
        if (!spins) return false;
        const auto end = std::chrono::steady_clock::now() + kSpinTime;
        do {
            for (int i = 0; i < kPausesPerClockRead; ++i) {
                pause_processor();
                if (condition()) return true;
            }
        } while (std::chrono::steady_clock::now() < end);
        return false;
    }

    // Takes indices until none is left or a body has failed.
    void work(int worker) {
        while (!failed.load(std::memory_order_relaxed)) {
            const std::size_t index = next.fetch_add(1, std::memory_order_relaxed);
            if (index >= count) return;
            try {
                (*body)(worker, index);
                liveness::beat();
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (!failed.exchange(true)) failure = std::current_exception();
            }
        }
    }

    bool news_since(std::uint64_t seen_job) const { return (gate.load() >> kJobShift) != seen_job || stopping.load(); }

    // The number of sleepers is increased before the gate is read a last time, and the opener writes the gate before it reads that number:
    // at least one of the two sees the other, so no wake-up is lost.
    void wait_for_news(std::uint64_t seen_job) {
        if (spin_until([&] { return news_since(seen_job); })) return;
        std::unique_lock lock(mutex);
        ++sleepers;
        job_opened.wait(lock, [&] { return news_since(seen_job); });
        --sleepers;
    }

    // Joins the current job if it is still open.
    bool enter(std::uint64_t& seen_job) {
        std::uint64_t seen = gate.load();
        do {
            seen_job = seen >> kJobShift;
            if ((seen & kOpenBit) == 0) return false;
        } while (!gate.compare_exchange_weak(seen, seen + 1));
        return true;
    }

    void leave() {
        gate.fetch_sub(1);
        if (!caller_sleeps.load()) return;
        const std::lock_guard lock(mutex);
        job_left.notify_one();
    }

    void serve(int worker) {
        std::uint64_t seen_job = 0;
        while (true) {
            wait_for_news(seen_job);
            if (stopping.load()) return;
            if (!enter(seen_job)) continue;
            work(worker);
            leave();
        }
    }

    void open() {
        const std::uint64_t job = (gate.load() >> kJobShift) + 1;
        gate.store((job << kJobShift) | kOpenBit);
        wake_all();
    }

    void wake_all() {
        if (sleepers.load() == 0) return;
        const std::lock_guard lock(mutex);
        job_opened.notify_all();
    }

    void stop() {
        {
            const std::lock_guard lock(mutex);
            stopping.store(true);
            job_opened.notify_all();
        }
        for (std::thread& thread : threads) thread.join();
    }

    void close_and_wait() {
        gate.fetch_and(~kOpenBit);
        const auto all_left = [&] { return (gate.load() & kInsideMask) == 0; };
        if (spin_until(all_left)) return;
        std::unique_lock lock(mutex);
        caller_sleeps.store(true);
        job_left.wait(lock, all_left);
        caller_sleeps.store(false);
    }
};

Workers::Workers(int threads) : threads_(threads) {
    MELD_CHECK(threads >= 1 && threads <= kMaxThreads, "threads = {}", threads);
    const unsigned available = std::thread::hardware_concurrency();
    shared_ = std::make_unique<Shared>(static_cast<unsigned>(threads) <= available);
    try {
        for (int worker = 1; worker < threads; ++worker)
            shared_->threads.emplace_back([shared = shared_.get(), worker] { shared->serve(worker); });
    } catch (...) {
        shared_->stop();
        throw;
    }
}

Workers::~Workers() { shared_->stop(); }

void Workers::run(std::size_t count, const std::function<void(int worker, std::size_t index)>& body) {
    if (count == 0) return;
    MELD_CHECK(!shared_->running.exchange(true), "a job is started while another one of the same workers is running");
    shared_->failure = nullptr;
    shared_->failed.store(false);
    shared_->body = &body;
    shared_->count = count;
    shared_->next.store(0);

    const bool shares_work = threads_ > 1 && count > 1;
    if (shares_work) shared_->open();
    shared_->work(0);
    if (shares_work) shared_->close_and_wait();

    const std::exception_ptr failure = std::exchange(shared_->failure, nullptr);
    shared_->running.store(false);
    if (failure) std::rethrow_exception(failure);
}

struct Periodic::Shared {
    std::mutex mutex;
    std::condition_variable ended;
    bool end = false;
    std::thread thread;
};

Periodic::Periodic(std::chrono::microseconds every, std::function<void()> f) : shared_(std::make_unique<Shared>()) {
    shared_->thread = std::thread([shared = shared_.get(), every, call = std::move(f)] {
        std::unique_lock lock(shared->mutex);
        while (!shared->ended.wait_for(lock, every, [&] { return shared->end; })) call();
    });
}

Periodic::~Periodic() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->end = true;
    }
    shared_->ended.notify_one();
    shared_->thread.join();
}

clockid_t own_cpu_clock() {
    clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
    pthread_getcpuclockid(pthread_self(), &clock);
    return clock;
}

}  // namespace meld
