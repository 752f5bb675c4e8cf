#include "runtime/engine/eval/samples.h"

#include "runtime/base/process/parallel_for.h"

namespace meld::eval {

namespace {

double read(clockid_t clock) {
    timespec t{};
    if (clock_gettime(clock, &t) != 0) return 0;
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

Samples::Samples(const ModuleInfo& module, std::vector<const u32*> places) : workers_(places.size()) {
    seconds_.rules.resize(module.rule_count);
    seconds_.predicates.resize(module.predicate_count);
    for (std::size_t i = 0; i < places.size(); ++i) workers_[i].place = places[i];
}

void Samples::note_worker(int worker) {
    Worker& w = workers_[static_cast<std::size_t>(worker)];
    if (w.known.load(std::memory_order_relaxed)) return;
    w.clock = own_cpu_clock();
    w.used = read(w.clock);
    w.known.store(true, std::memory_order_release);
}

void Samples::take() {
    for (Worker& w : workers_) {
        if (!w.known.load(std::memory_order_acquire)) continue;
        const double now = read(w.clock), used = now - w.used;
        w.used = now;
        const u32 place = __atomic_load_n(w.place, __ATOMIC_RELAXED);
        if (place < seconds_.rules.size())
            seconds_.rules[place] += used;
        else if (place - kPlaceDecides < seconds_.predicates.size())
            seconds_.predicates[place - kPlaceDecides] += used;
        else if (place == kPlaceOther)
            seconds_.other += used;
        if (place != kPlaceNone) ++seconds_.samples;
    }
}

}  // namespace meld::eval
