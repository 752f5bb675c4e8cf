// Memory and CPU of ticks that make a new candidate list: k^3 balls on a plane, so close that the pile bursts.
//
//     bench_burst [--ticks N] [--threads N] [k ...]     k = 63 100
//
// Memory is what the system holds resident for the process, above what it held before the scene. Without a way to ask the system
// for the largest of a tick (Linux has one) it is not told.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/bench/clock.h"
#include "tests/bench/cube.h"
#include "tests/bench/need.h"

namespace meld::physics {
namespace {

using bench::cpu_now;
using bench::machine_line;
using bench::median;
using bench::need;

constexpr double kTick = 1.0 / 240;
constexpr double kSpacing = 0.999;

struct Options {
    std::vector<int> sides;
    int ticks = 24;
    int threads = 1;
};

// A figure of /proc/self/status in bytes, 0 where there is none.
double status_bytes(const std::string& name) {
    std::ifstream status("/proc/self/status");
    std::string line;
    while (std::getline(status, line))
        if (line.starts_with(name + ":")) return 1024.0 * std::strtod(line.c_str() + name.size() + 1, nullptr);
    return 0;
}

// Resets the largest resident size.
void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

void burst(const std::string& name, const SolverSettings& solver, int substeps, int side, const Options& options) {
    const double before = status_bytes("VmRSS");
    Settings settings{.solver = solver, .sleep_ticks = 0, .keep_last_good = false};
    auto scene = need(Scene::make(settings));
    const double count = 1.0 * side * side * side;
    scene->reserve(static_cast<std::size_t>(count), static_cast<std::size_t>(count));
    bench::add_cube(*scene, side, kSpacing);
    Workers workers(options.threads);
    const auto per_body = [&](double bytes) { return (bytes - before) / count; };
    double first = 0, later = 0;
    std::size_t held = 0;
    StageTimes lists{};
    std::vector<double> with_list, without;
    for (int tick = 0; tick < options.ticks; ++tick) {
        forget_peak();
        const StageTimes began = scene->stage_times();
        const double begin = cpu_now();
        const StepReport report = need(scene->step(kTick, substeps, workers));
        const double took_ms = 1e3 * (cpu_now() - begin), peak = per_body(status_bytes("VmHWM"));
        scene->forget_events();
        if (tick == 0) {
            first = peak;
            continue;
        }
        (report.rebuilt ? with_list : without).push_back(took_ms);
        if (!report.rebuilt) continue;
        lists.sort += scene->stage_times().sort - began.sort, lists.pairs += scene->stage_times().pairs - began.pairs;
        later = std::max(later, peak), held = std::max(held, scene->bytes());
    }
    if (with_list.empty() || without.empty())
        return fmt::print("  {:<24} {} ticks, with the list anew in {}\n", name, options.ticks, with_list.size());
    const double per_list = 1e3 / static_cast<double>(with_list.size());
    fmt::print(
        "  {:<24} T{} {:3} lists | {:8.1f} ms a tick with one, {:8.1f} without, sort {:8.1f}, pairs {:8.1f} | B a body: {:4.0f} held, "
        "{:4.0f} at the peak of the first tick, {:4.0f} of a later one | digest {}\n",
        name, options.threads, with_list.size(), median(with_list), median(without), per_list * lists.sort, per_list * lists.pairs,
        static_cast<double>(held) / count, first, later, scene->digest().to_string());
    std::fflush(stdout);
}

Options parse(int count, char** arguments) {
    Options options;
    for (int i = 1; i < count; ++i) {
        const std::string word = arguments[i];
        if (word == "--ticks" && i + 1 < count)
            options.ticks = std::max(2, std::atoi(arguments[++i]));
        else if (word == "--threads" && i + 1 < count)
            options.threads = std::max(1, std::atoi(arguments[++i]));
        else if (const int side = std::atoi(word.c_str()); side > 0)
            options.sides.push_back(side);
    }
    if (options.sides.empty()) options.sides = {63, 100};
    return options;
}

}  // namespace
}  // namespace meld::physics

int main(int count, char** arguments) {
    using namespace meld::physics;
    const Options options = parse(count, arguments);
    machine_line("ms, CPU, medians of ticks; stages by wall clock, means");
    for (const int side : options.sides) {
        fmt::print("\n{} bodies, spacing {}, {} ticks\n", side * side * side, kSpacing, options.ticks);
        burst("20 cold sweeps", SolverSettings::pgs20(), 1, side, options);
        burst("soft", {}, 2, side, options);
    }
    return 0;
}
