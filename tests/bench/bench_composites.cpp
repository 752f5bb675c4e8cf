// Composites: ticks of k^3 touching balls on a plane, bare and connected in several ways, side by side in one run; and how long it takes to
// merge and to split a composite of k^3; unless sizes are given, also plates that lie on a plane, and the loads of connections; with
// --loads these only.
//
//     bench_composites [--ticks N] [--threads N] [--loads] [k ...]     k = 22 46 63
//
// Times are CPU milliseconds of the process, medians over ticks; of merging and splitting, the least of five.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "physics/scene/scene.h"
#include "physics/solver/engine.h"
#include "tests/bench/clock.h"
#include "tests/bench/cube.h"
#include "tests/bench/need.h"

namespace meld::physics {
namespace {

using bench::cpu_now;
using bench::median;
using bench::need;

constexpr double kTick = 1.0 / 240;

enum class Pattern { Bare, Pairs, Rows, EverySecond };

const char* name_of(Pattern pattern) {
    switch (pattern) {
        case Pattern::Bare:
            return "bare";
        case Pattern::Pairs:
            return "in pairs along x";
        case Pattern::Rows:
            return "in rows of 8 along x";
        case Pattern::EverySecond:
            return "every second contact";
    }
    return "";
}

struct Cube {
    int side;
    BodyId at(int x, int y, int z) const { return static_cast<BodyId>((z * side + y) * side + x); }
    // Calls f(body, next, how far along x the first is) for neighbours along x, then y, then z.
    template <class F>
    void each_contact(const F& f) const {
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    if (x + 1 < side) f(at(x, y, z), at(x + 1, y, z), x);
                    if (y + 1 < side) f(at(x, y, z), at(x, y + 1, z), -1);
                    if (z + 1 < side) f(at(x, y, z), at(x, y, z + 1), -1);
                }
    }
};

std::unique_ptr<Scene> make_cube(int side, Pattern pattern) {
    Settings settings;
    // All ticks are alike.
    settings.sleep_ticks = 0;
    auto scene = need(Scene::make(settings));
    bench::add_cube(*scene, side, 1);
    std::mt19937 random(1);
    Cube{side}.each_contact([&](BodyId a, BodyId b, int x) {
        const bool connected = pattern == Pattern::EverySecond ? random() % 2 == 0
                               : pattern == Pattern::Pairs     ? x >= 0 && x % 2 == 0
                               : pattern == Pattern::Rows      ? x >= 0 && x % 8 != 7
                                                               : false;
        if (connected) need(scene->connect(a, b));
    });
    return scene;
}

void measure_ticks(int side, int ticks, int threads) {
    double bare = 0;
    for (const Pattern pattern : {Pattern::Bare, Pattern::Pairs, Pattern::Rows, Pattern::EverySecond}) {
        auto scene = make_cube(side, pattern);
        Workers workers(threads);
        const double begin = cpu_now();
        need(scene->step(kTick, 2, workers));
        const double first = 1e3 * (cpu_now() - begin);
        std::vector<double> times;
        for (int tick = 0; tick < ticks; ++tick) {
            const double start = cpu_now();
            need(scene->step(kTick, 2, workers));
            times.push_back(1e3 * (cpu_now() - start));
        }
        const double tick = median(times);
        if (pattern == Pattern::Bare) bare = tick;
        fmt::print("{:>9} bodies, {:<21} {:8.2f} ms a tick, {:5.2f} of bare; first tick {:8.2f} ms; {:4.0f} bytes a body\n",
                   side * side * side, name_of(pattern), tick, tick / bare, first,
                   static_cast<double>(scene->bytes()) / (side * side * side));
    }
}

// Two halves of a cube, connected within, are merged by one connection and split by its release. What a step adds is a new candidate list.
void measure_merging(int side) {
    auto scene = need(Scene::make({}));
    bench::add_cube(*scene, side, 1);
    const int half = side / 2;
    Cube{side}.each_contact([&](BodyId a, BodyId b, int x) {
        if (x != half - 1) need(scene->connect(a, b));
    });
    Workers workers(1);
    need(scene->step(kTick, 1, workers));
    const BodyId a = Cube{side}.at(half - 1, 0, 0), b = Cube{side}.at(half, 0, 0);
    World& world = scene->world();
    const auto time_of = [&](const auto& change) {
        const double begin = cpu_now();
        need(change());
        if (!world.composites.settle(world.bodies, world.shapes)) std::exit(1);
        world.composites.set_velocities(world.bodies, workers);
        const double took = 1e3 * (cpu_now() - begin);
        scene->engine().structure_changed();
        return took;
    };
    double merged = 1e9, split = 1e9;
    for (int i = 0; i < 5; ++i) {
        merged = std::min(merged, time_of([&] { return scene->connect(a, b); }));
        need(scene->step(kTick, 1, workers));
        split = std::min(split, time_of([&] { return scene->release(a, b); }));
        need(scene->step(kTick, 1, workers));
    }
    fmt::print("{:>9} bodies merged from two halves in {:.2f} ms, split in {:.2f} ms\n", side * side * side, merged, split);
}

// A plate of side^2 balls falls on a plane by a tenth of a diameter and lies there, one composite or loose: what its contacts cost, and how
// far it sinks in and still moves after two seconds, over how many blocks.
void measure_plates() {
    for (const int side : {8, 16, 32, 64})
        for (const bool connected : {false, true}) {
            Settings settings;
            settings.sleep_ticks = 0;
            auto scene = need(Scene::make(settings));
            need(scene->add_obstacle(Plane{}, 0));
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const auto id = static_cast<BodyId>(side * y + x);
                    need(scene->add_body({.id = id, .position_m = {double(x), double(y), 0.6}}));
                    if (connected && x > 0) need(scene->connect(id - 1, id));
                    if (connected && y > 0) need(scene->connect(id - static_cast<BodyId>(side), id));
                }
            Workers workers(1);
            std::vector<double> times;
            std::size_t blocks = 0;
            for (int tick = 0; tick < 480; ++tick) {
                const double start = cpu_now();
                blocks = need(scene->step(kTick, 2, workers)).blocks;
                times.push_back(1e6 * (cpu_now() - start));
            }
            double lowest = 1, fastest = 0;
            for (const BodyId body : scene->bodies()) {
                const BodyState state = scene->state(body);
                lowest = std::min(lowest, state.position_m.z), fastest = std::max(fastest, length(state.linear_velocity_m_s));
            }
            fmt::print("plate of {:>5} {:<9} in {:>3} blocks: {:8.1f} us a tick, {:.1e} m deep, {:.1e} m/s\n", side * side,
                       connected ? "connected" : "loose", blocks, median(times), 0.5 - lowest, fastest);
        }
}

// What the loads of one composite cost that fixed balls hold at one end: the first time, when its lattice is made, and later.
void measure_loads() {
    struct Shape {
        const char* name;
        int nx, ny, nz;
    };
    for (const auto& [name, nx, ny, nz] :
         {Shape{"row", 10'000, 1, 1}, Shape{"deck", 2'500, 4, 1}, Shape{"deck", 1'000, 10, 1}, Shape{"plate", 100, 100, 1},
          Shape{"beam", 278, 6, 6}, Shape{"cube", 22, 22, 22}, Shape{"cube", 46, 46, 46}}) {
        Settings settings;
        settings.sleep_ticks = 0;
        auto scene = need(Scene::make(settings));
        const auto at = [&](int x, int y, int z) { return static_cast<BodyId>((z * ny + y) * nx + x); };
        for (int z = 0; z < nz; ++z)
            for (int y = 0; y < ny; ++y)
                for (int x = 0; x < nx; ++x) {
                    need(scene->add_body({.id = at(x, y, z), .position_m = {double(x), double(y), double(z)}, .fixed = x == 0}));
                    if (x > 0) need(scene->connect(at(x - 1, y, z), at(x, y, z)));
                    if (y > 0) need(scene->connect(at(x, y - 1, z), at(x, y, z)));
                    if (z > 0) need(scene->connect(at(x, y, z - 1), at(x, y, z)));
                }
        scene->want_loads();
        Workers workers(1);
        std::size_t before = 0;
        std::vector<double> steps, solutions;
        for (int tick = 0; tick < 4; ++tick) {
            const double start = cpu_now();
            need(scene->step(kTick, 2, workers));
            const double stepped = cpu_now();
            if (tick == 0) before = scene->bytes();
            need(scene->solve_loads(workers));
            steps.push_back(1e3 * (stepped - start)), solutions.push_back(1e3 * (cpu_now() - stepped));
        }
        const double bodies = double(nx) * ny * nz;
        fmt::print(
            "{:<5} of {:>6} x {:>3} x {:>3}, {:>6} connections: step {:7.2f} ms, loads {:8.1f} ms, the first time {:8.1f} ms; {:5.0f} "
            "bytes a body\n",
            name, nx, ny, nz, scene->connection_count(), steps.back(), solutions.back(), solutions.front(),
            static_cast<double>(scene->bytes() - before) / bodies);
    }
}

}  // namespace
}  // namespace meld::physics

int main(int argc, char** argv) {
    using namespace meld::physics;
    int ticks = 7, threads = 1;
    bool loads_only = false;
    std::vector<int> sides;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--ticks") == 0 && i + 1 < argc)
            ticks = std::atoi(argv[++i]);
        else if (std::strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
            threads = std::atoi(argv[++i]);
        else if (std::strcmp(argv[i], "--loads") == 0)
            loads_only = true;
        else
            sides.push_back(std::atoi(argv[i]));
    }
    const bool plates = sides.empty();
    if (plates) sides = {22, 46, 63};
    for (const int side : sides)
        if (side < 2 || ticks < 1 || threads < 1) {
            fmt::print("bench_composites: give sides of at least 2, ticks and threads of at least 1\n");
            return 2;
        }
    meld::bench::machine_line("CPU milliseconds");
    if (loads_only) {
        measure_loads();
        return 0;
    }
    for (const int side : sides) {
        measure_merging(side);
        measure_ticks(side, ticks, threads);
    }
    if (plates) measure_plates();
    if (plates) measure_loads();
    return 0;
}
