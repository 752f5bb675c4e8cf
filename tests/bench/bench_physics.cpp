// The physics engines on one scene: k^3 touching balls on a plane, per stage and in total, side by side in one run.
//
//     bench_physics [--large] [--ticks N] [--threads N] [k ...]     k = 10 22 37 47 63 100, with --large also 159 and 272
//
// Times are CPU seconds of the process, medians over ticks; wall times of stages are means. ODE and the seed design's engine
// are left out where a tick would take them longer than a minute or they cannot run; from 10 million balls on there is one
// scene, soft, without a copy of the state to go back to.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "physics/collision/broadphase.h"
#include "physics/comparison/hash_broadphase.h"
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
// Above these sizes an engine is not tried.
constexpr int kMaxOdeSide = 47;
constexpr int kMaxHashSide = 63;
constexpr int kMaxFullSide = 200;
// Larger than the caches.
constexpr std::size_t kReadBytes = std::size_t{1} << 30;
// What a sweep reads and writes of a contact and of a body, at least: a lane of a batch, its impulses, a motion.
constexpr double kContactBytes = 44 + 16, kBodyBytes = 2 * 32;

struct Options {
    std::vector<int> sides;
    int ticks = 7;
    std::vector<int> threads{1, 2};
};

double wall_now() {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::unique_ptr<Scene> cube(const Settings& settings, int side, double spacing) {
    auto scene = need(Scene::make(settings));
    bench::add_cube(*scene, side, spacing);
    return scene;
}

struct Measured {
    double tick_cpu_ms, tick_wall_ms, first_cpu_ms, anew_cpu_ms;
    StageTimes first, rest;
    std::size_t bytes, bodies, candidates;
};

// How fast one thread reads memory, bytes a second of CPU: the best of several passes over more than the caches hold.
double read_bandwidth() {
    std::vector<std::uint64_t> words(kReadBytes / sizeof(std::uint64_t), 1);
    double best = 0;
    std::uint64_t sum = 0;
    for (int pass = 0; pass < 4; ++pass) {
        const double begin = cpu_now();
        std::uint64_t sums[4] = {};
        for (std::size_t i = 0; i < words.size(); i += 4)
            for (std::size_t k = 0; k < 4; ++k) sums[k] += words[i + k];
        sum += sums[0] + sums[1] + sums[2] + sums[3];
        best = std::max(best, static_cast<double>(kReadBytes) / (cpu_now() - begin));
    }
    // What is not used need not be read.
    if (sum != 4 * words.size()) std::exit(1);
    return best;
}

Measured measure(Scene& scene, int ticks, int substeps, int threads) {
    Workers workers(threads);
    Measured result{};
    const double begin = cpu_now();
    result.candidates = need(scene.step(kTick, substeps, workers)).candidates;
    result.first_cpu_ms = 1e3 * (cpu_now() - begin);
    result.first = scene.stage_times();
    std::vector<double> cpu, wall;
    for (int tick = 1; tick < ticks; ++tick) {
        const double c = cpu_now(), w = wall_now();
        need(scene.step(kTick, substeps, workers));
        cpu.push_back(1e3 * (cpu_now() - c)), wall.push_back(1e3 * (wall_now() - w));
    }
    result.tick_cpu_ms = median(cpu), result.tick_wall_ms = median(wall);
    result.rest = scene.stage_times();
    result.bytes = scene.bytes(), result.bodies = scene.body_count();
    // Moving one body forces a new neighbour search for all.
    BodyState state = scene.state(0);
    state.position_m.x += 1e-6;
    need(scene.set_state(0, state));
    const double again = cpu_now();
    need(scene.step(kTick, substeps, workers));
    result.anew_cpu_ms = 1e3 * (cpu_now() - again);
    return result;
}

void print_row(const std::string& name, int threads, const Measured& m, int ticks, double ode_ms) {
    const double per_tick = 1e3 / (ticks - 1);
    const auto mean = [&](double StageTimes::* stage) { return per_tick * (m.rest.*stage - m.first.*stage); };
    fmt::print(
        "  {:<22} T{} {:9.2f} cpu {:9.2f} wall | with the list {:8.1f} cpu, the first time {:8.1f} | list {:8.1f}, actuate {:6.2f} refresh "
        "{:6.2f} solve {:8.2f} move {:6.2f} events {:6.2f} "
        "| {:4} B/body{}\n",
        name, threads, m.tick_cpu_ms, m.tick_wall_ms, m.anew_cpu_ms, m.first_cpu_ms, 1e3 * (m.first.sort + m.first.pairs),
        mean(&StageTimes::actuation), mean(&StageTimes::refresh), mean(&StageTimes::solve), mean(&StageTimes::move),
        mean(&StageTimes::events), m.bytes / m.bodies, ode_ms > 0 ? fmt::format(" | {:.0f} x ODE", ode_ms / m.tick_cpu_ms) : "");
    std::fflush(stdout);
}

// Twelve magnets a ball, all on, one in two reversed.
void add_magnets(Scene& scene) {
    std::vector<Feature> features;
    for (const Vec3 direction : feature_directions(12)) features.push_back({.direction = direction, .strength = 10, .range_m = 0.1});
    const auto table = need(scene.add_feature_table(features));
    for (const BodyId id : scene.bodies()) {
        need(scene.set_feature_table(id, table));
        need(scene.set_features(id, 0xfff, id % 2 == 0 ? 0xfff : 0));
    }
}

Settings with(EngineKind engine, SolverSettings solver) {
    Settings settings{.engine = engine, .solver = solver, .sleep_ticks = 0};
    return settings;
}

// What memory has to bring and take in a tick of cold sweeps, as a share of what one thread can read in that time.
void print_share(const Measured& m, int sweeps, double bandwidth) {
    const double bytes = sweeps * (kContactBytes * static_cast<double>(m.candidates) + kBodyBytes * static_cast<double>(m.bodies));
    fmt::print("  {:<22}    {:.0f} bytes a body and sweep, {:.1f} GB/s in the whole tick, {:.0f} % of what one thread reads\n", "  memory",
               bytes / sweeps / static_cast<double>(m.bodies), bytes / m.tick_cpu_ms * 1e-6,
               100 * bytes / (1e-3 * m.tick_cpu_ms) / bandwidth);
}

// The largest scene: how much memory it takes and how long a few ticks do.
void fill(int side, const Options& options) {
    fmt::print("\n{} bodies, soft, spacing 1, {} ticks\n", side * side * side, options.ticks);
    Settings settings;
    settings.keep_last_good = false;
    auto scene = cube(settings, side, 1);
    const int threads = options.threads.back();
    print_row("blocks, soft, spacing 1", threads, measure(*scene, options.ticks, 2, threads), options.ticks, 0);
}

// 22 layers, touching, soft: how still they are and how far the top has come down.
void compare_standing() {
    constexpr int kSide = 22;
    fmt::print("\nstanding: {} bodies, {} high, 240 ticks\n", kSide * kSide * kSide, kSide);
    for (const bool may_sleep : {true, false}) {
        Settings settings;
        if (!may_sleep) settings.sleep_ticks = 0;
        auto scene = cube(settings, kSide, 1);
        Workers workers(1);
        for (int tick = 0; tick < 240; ++tick) need(scene->step(kTick, 2, workers));
        double squares = 0, top = 0;
        for (const BodyId id : scene->bodies()) {
            const BodyState state = scene->state(id);
            squares += dot(state.linear_velocity_m_s, state.linear_velocity_m_s);
            top = std::max(top, state.position_m.z);
        }
        fmt::print("  {:<22} {:.2e} m/s rms, the top {:.1f} mm lower\n", may_sleep ? "soft" : "soft, kept awake",
                   std::sqrt(squares / (kSide * kSide * kSide)), 1e3 * (kSide - 0.5 - top));
    }
}

void compare(int side, const Options& options, double bandwidth) {
    if (side > kMaxFullSide) return fill(side, options);
    fmt::print("\n{} bodies, spacing {}, {} ticks\n", side * side * side, kSpacing, options.ticks);
    double ode_ms = 0;
    if (side <= kMaxOdeSide) {
        const int ticks = side > 25 ? 3 : options.ticks;
        auto scene = cube(with(EngineKind::Ode, SolverSettings::pgs20()), side, kSpacing);
        const Measured m = measure(*scene, ticks, 1, 1);
        ode_ms = m.tick_cpu_ms;
        print_row("stock ODE, 20 sweeps", 1, m, ticks, 0);
    }
    for (const int threads : options.threads) {
        if (side <= kMaxHashSide) {
            auto scene = cube(with(EngineKind::Hash, SolverSettings::pgs20()), side, kSpacing);
            print_row("seed design, 20 sweeps", threads, measure(*scene, std::min(options.ticks, 4), 1, threads),
                      std::min(options.ticks, 4), ode_ms);
        }
        SolverSettings inner = SolverSettings::pgs20();
        inner.sweeps = 5, inner.inner_sweeps = 4;
        const std::pair<const char*, SolverSettings> modes[] = {{"blocks, 20 cold sweeps", SolverSettings::pgs20()},
                                                                {"blocks, 5 x 4 inner", inner}};
        for (const auto& [name, solver] : modes) {
            auto scene = cube(with(EngineKind::Blocks, solver), side, kSpacing);
            const Measured m = measure(*scene, options.ticks, 1, threads);
            print_row(name, threads, m, options.ticks, ode_ms);
            if (threads == 1 && solver.inner_sweeps == 1) print_share(m, solver.sweeps, bandwidth);
        }
        auto soft = cube(with(EngineKind::Blocks, {}), side, 1);
        print_row("blocks, soft, spacing 1", threads, measure(*soft, options.ticks, 2, threads), options.ticks, ode_ms);
        auto magnets = cube(with(EngineKind::Blocks, SolverSettings::pgs20()), side, kSpacing);
        add_magnets(*magnets);
        print_row("  with 12 magnets each", threads, measure(*magnets, options.ticks, 1, threads), options.ticks, 0);
    }
    auto sleeping = cube({}, side, 1);
    Workers workers(options.threads.back());
    for (int tick = 0; side <= 22 && tick < 300; ++tick) need(sleeping->step(kTick, 2, workers));
    if (side <= 22)
        print_row("asleep", options.threads.back(), measure(*sleeping, options.ticks, 2, options.threads.back()), options.ticks, 0);
}

void compare_broadphases(int side) {
    fmt::print("\npairs of {} bodies, ms CPU\n", side * side * side);
    Bodies bodies;
    BodyId id = 0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                bodies.add({kSpacing * x, kSpacing * y, kSpacing * z, 0.5}, {1, 0, 0, 0}, {},
                           {.id = id++, .mass = 1, .inertia_factor = 0.4f, .material = 0, .flags = 0, .still_ticks = 0});
    for (const bool ours : {true, false}) {
        const auto broadphase = ours ? make_block_broadphase() : make_hash_broadphase();
        Workers workers(1);
        std::vector<double> times;
        for (int i = 0; i < (ours ? 5 : 2); ++i) {
            const double begin = cpu_now();
            need(broadphase->find(bodies, 0.1, workers));
            times.push_back(1e3 * (cpu_now() - begin));
        }
        fmt::print("  {:<22} {:8.1f}\n", ours ? "blocks" : "seed design", median(times));
    }
}

// How fast each scheme converges: the residual after N sweeps from zero, in the first tick of the scene.
void compare_convergence(int side) {
    fmt::print("\nresidual after sweeps from nothing, {} bodies\n  {:<26}", side * side * side, "sweeps");
    const int counts[] = {1, 2, 5, 10, 20, 40};
    for (const int count : counts) fmt::print("{:>10}", count);
    fmt::print("\n");
    struct Scheme {
        const char* name;
        EngineKind engine;
        int inner, threads;
    };
    for (const Scheme& scheme :
         {Scheme{"blocks", EngineKind::Blocks, 1, 1}, Scheme{"blocks, 4 inner each", EngineKind::Blocks, 4, 1},
          Scheme{"seed design, 1 worker", EngineKind::Hash, 1, 1}, Scheme{"seed design, 2 workers", EngineKind::Hash, 1, 2}}) {
        fmt::print("  {:<26}", scheme.name);
        for (const int count : counts) {
            SolverSettings solver = SolverSettings::pgs20();
            solver.sweeps = count, solver.inner_sweeps = scheme.inner;
            auto scene = cube(with(scheme.engine, solver), side, kSpacing);
            Workers workers(scheme.threads);
            need(scene->step(kTick, 1, workers));
            fmt::print("{:>10.5f}", scene->residual());
        }
        fmt::print("\n");
        std::fflush(stdout);
    }
}

Options parse(int count, char** arguments) {
    Options options;
    bool large = false;
    for (int i = 1; i < count; ++i) {
        const std::string word = arguments[i];
        if (word == "--large")
            large = true;
        else if (word == "--ticks" && i + 1 < count)
            options.ticks = std::max(2, std::atoi(arguments[++i]));
        else if (word == "--threads" && i + 1 < count)
            options.threads = {std::atoi(arguments[++i])};
        else if (const int side = std::atoi(word.c_str()); side > 0)
            options.sides.push_back(side);
    }
    if (options.sides.empty()) options.sides = {10, 22, 37, 47, 63, 100};
    if (large) options.sides.insert(options.sides.end(), {159, 272});
    return options;
}

}  // namespace
}  // namespace meld::physics

int main(int count, char** arguments) {
    using namespace meld::physics;
    const Options options = parse(count, arguments);
    machine_line("ms, CPU, medians of ticks; stages by wall clock");
    compare_convergence(std::min(options.sides.back(), 22));
    compare_broadphases(std::min(options.sides.back(), 63));
    if (options.sides.back() >= 22) compare_standing();
    const double bandwidth = options.sides.back() >= 22 ? read_bandwidth() : 1e10;
    fmt::print("\none thread reads {:.1f} GB/s\n", 1e-9 * bandwidth);
    for (const int side : options.sides) compare(side, options, bandwidth);
    return 0;
}
