// Predicates with many rows a catom, with the planner's pass `deltas` and without it, in the same run: a hundred gradients
// at once, a view of a thousand rows of which one changes, and the pairs that a chain joins at one catom.
// Usage: bench_rows MELDC FOLDER [small]
#include <cinttypes>

#include "runtime/results/record/state_digest.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

constexpr int kRepeats = 3;

std::string compile(const std::string& meldc, const std::string& program, const std::string& options) {
    std::FILE* pipe = popen(("'" + meldc + "' compile '" + program + "' " + options).c_str(), "r");
    std::string output;
    char buffer[4096];
    for (std::size_t n = 0; pipe != nullptr && (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
    if (pipe == nullptr || pclose(pipe) != 0) std::exit(1);
    while (!output.empty() && output.back() == '\n') output.pop_back();
    return output;
}

// One step of a benchmark: its time, its work, and what holds after it.
struct Step {
    const char* what;
    double seconds = 0;
    std::uint64_t derivations = 0, changes = 0;
    Digest state = {};
};

class Steps {
  public:
    explicit Steps(Run& run) : run_(run) {}
    // Applies `change` and runs to quiescence, N times.
    template <class Change>
    void add(const char* what, int times, const Change& change) {
        const sim::Summary before = run_.simulation->summary();
        double seconds = 0;
        for (int i = 0; i < times; ++i) {
            change(i);
            seconds += run_.settle();
        }
        const sim::Summary& after = run_.simulation->summary();
        all.push_back({what, seconds / times, (after.derivations - before.derivations) / static_cast<std::uint64_t>(times),
                       (after.changes - before.changes) / static_cast<std::uint64_t>(times), record::state_digest(run_.subdomain())});
    }
    std::vector<Step> all;

  private:
    Run& run_;
};

void give(Run& run, const char* predicate, std::size_t arity, sim::Catom catom, std::vector<Value> arguments, bool there = true) {
    const u32 base = run.info().predicates[*tuple::find_predicate(run.info(), predicate, arity)].base;
    if (there)
        run.subdomain().give(base, catom, arguments.data());
    else
        run.subdomain().take(base, catom, arguments.data());
}
Value number(std::int64_t i) { return Value{.integer = i}; }

template <class Measure>
void compare(const std::string& meldc, const std::string& program, const std::string& world, const Measure& measure) {
    const std::string modules[2] = {compile(meldc, program, ""), compile(meldc, program, "--without deltas")};
    std::vector<Step> results[2];
    std::vector<std::vector<double>> seconds[2];
    for (int repeat = 0; repeat < kRepeats; ++repeat)
        for (int side = 0; side < 2; ++side) {
            Run run(modules[side], world);
            Steps steps(run);
            measure(run, steps);
            results[side] = steps.all;
            seconds[side].resize(steps.all.size());
            for (std::size_t i = 0; i < steps.all.size(); ++i) seconds[side][i].push_back(steps.all[i].seconds);
        }
    for (std::size_t i = 0; i < results[0].size(); ++i) {
        const double with = median(seconds[0][i]), without = median(seconds[1][i]);
        std::printf("  %-34s %11.6f s %11.6f s   ratio %6.1f   derivations %11" PRIu64 " %11" PRIu64 "   changes %9" PRIu64 "\n",
                    results[0][i].what, with, without, without / with, results[0][i].derivations, results[1][i].derivations,
                    results[0][i].changes);
        if (results[0][i].state == results[1][i].state) continue;
        std::fprintf(stderr, "%s: other facts with deltas than without\n", results[0][i].what);
        std::exit(70);
    }
}

std::string square(int side) {
    return "lattice = \"square\"\n[[body]]\nshape = \"box(" + std::to_string(side) + ", " + std::to_string(side) + ", 1)\"\n";
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) return 2;
    const std::string meldc = argv[1], folder = argv[2];
    const bool small = argc > 3;
    machine_line();

    const int side = small ? 12 : 100, sources = small ? 10 : 100;
    std::printf("%d gradients on %d catoms                   with            without\n", sources, side * side);
    compare(meldc, folder + "/sources.meld", square(side), [&](Run& run, Steps& steps) {
        const auto stride = static_cast<sim::Catom>(side * side / sources);
        steps.add("settle", 1, [&](int) {
            for (int i = 0; i < sources; ++i) give(run, "source", 0, static_cast<sim::Catom>(i) * stride + stride / 2, {});
        });
        steps.add("one source lost", 1, [&](int) { give(run, "source", 0, stride / 2, {}, false); });
        steps.add("it comes back", 1, [&](int) { give(run, "source", 0, stride / 2, {}); });
    });

    const int rows = small ? 50 : 1000, changes = small ? 20 : 500;
    std::printf("views of %d rows at each of 64 catoms\n", rows);
    compare(meldc, folder + "/view.meld", square(8), [&](Run& run, Steps& steps) {
        steps.add("settle", 1, [&](int) {
            for (sim::Catom c = 0; c < 64; ++c)
                for (int k = 0; k < rows; ++k) give(run, "item", 2, c, {number(k), number((k * 7 + static_cast<int>(c)) % 1000)});
        });
        steps.add("one row more or less", changes,
                  [&](int i) { give(run, "item", 2, 27, {number(i * 37 % rows), number(5000)}, i % 2 == 0); });
    });

    const int chain = small ? 20 : 60;
    std::printf("pairs joined by a chain of %d edges\n", chain);
    compare(meldc, folder + "/closure.meld", square(1), [&](Run& run, Steps& steps) {
        steps.add("settle", 1, [&](int) {
            for (int k = 0; k < chain; ++k) give(run, "edge", 2, 0, {number(k), number(k + 1)});
        });
        steps.add("the last edge goes or comes", 10,
                  [&](int i) { give(run, "edge", 2, 0, {number(chain - 1), number(chain)}, i % 2 == 1); });
    });
    return 0;
}
