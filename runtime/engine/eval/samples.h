// Which rules the workers spend their time on: from time to time somebody looks where each of them is (Eval::place), and adds the CPU time
// that it has used since to that place.
#pragma once

#include <atomic>
#include <cstddef>
#include <ctime>
#include <vector>

#include "runtime/module/abi/counts_abi.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// CPU seconds of all workers of a process.
struct CpuSeconds {
    std::vector<double> rules;       // Bodies of rules, by rule.
    std::vector<double> predicates;  // What follows from the proposals of rules, by predicate.
    double other = 0;                // Reading and writing catoms.
    u64 samples = 0;                 // That have found a worker at one of these.
};

class Samples {
  public:
    // places: of each worker; they live as long as this.
    Samples(const ModuleInfo& module, std::vector<const u32*> places);
    // From a worker's own thread, before it evaluates.
    void note_worker(int worker);
    // From any one thread.
    void take();
    // While nobody takes samples.
    const CpuSeconds& seconds() const { return seconds_; }

  private:
    struct Worker {
        const u32* place = nullptr;
        clockid_t clock = 0;
        double used = 0;  // At the last sample.
        std::atomic<bool> known = false;
    };
    std::vector<Worker> workers_;
    CpuSeconds seconds_;
};

}  // namespace meld::eval
