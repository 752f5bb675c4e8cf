// The only way this project starts threads.
#pragma once

#include <chrono>
#include <cstddef>
#include <ctime>
#include <functional>
#include <memory>

namespace meld {

// A fixed set of worker threads. run(n, f) calls f(worker, index) for index 0..n-1, each exactly once, on any worker; it returns when all
// are done. With one thread everything happens in the calling thread, in order. The caller is worker 0. The first exception of a body is
// rethrown here, and indices that have not begun are skipped. A body must not call run of the same workers. Idle workers sleep. Cost: about
// a microsecond to start while the workers are awake, and an atomic add per index, so give an index some microseconds of work.
class Workers {
  public:
    explicit Workers(int threads);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;
    int threads() const { return threads_; }
    void run(std::size_t count, const std::function<void(int worker, std::size_t index)>& body);

  private:
    struct Shared;
    int threads_;
    std::unique_ptr<Shared> shared_;
};

// Calls f() every so often from a thread of its own, from construction to destruction.
class Periodic {
  public:
    Periodic(std::chrono::microseconds every, std::function<void()> f);
    ~Periodic();
    Periodic(const Periodic&) = delete;
    Periodic& operator=(const Periodic&) = delete;

  private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

// The clock of the CPU time that the calling thread has used; other threads of the process may read it.
clockid_t own_cpu_clock();

}  // namespace meld
