// Piles of cubes and capsules beside piles of as many spheres, in one run: k^3 bodies on a lattice, touching on a plane; and as many that
// fall into a walled box in disorder.
//
//     bench_shapes [--ticks N] [--threads N] [k ...]     k = 22 46
//
// Times are CPU milliseconds of the process, medians over ticks.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/bench/clock.h"
#include "tests/bench/need.h"

namespace meld::physics {
namespace {

using bench::cpu_now;
using bench::median;
using bench::need;

constexpr double kTick = 1.0 / 240;

enum class Form { Sphere, Cube, Capsule };
constexpr const char* kNames[] = {"spheres", "cubes", "capsules"};

void give_shape(BodySpec& spec, Form form) {
    if (form == Form::Cube) spec.shape = box_shape({1, 1, 1}, 0.02);
    if (form == Form::Capsule) spec.shape = capsule_shape(0.3, 1);
}

std::unique_ptr<Scene> empty_scene() {
    Settings settings;
    // All ticks are alike.
    settings.sleep_ticks = 0;
    auto scene = need(Scene::make(settings));
    need(scene->add_obstacle(Plane{}, 0));
    return scene;
}

std::unique_ptr<Scene> lattice(int side, Form form) {
    auto scene = empty_scene();
    BodyId id = 0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                BodySpec spec{.id = id++, .position_m = {0.999 * x, 0.999 * y, 0.4995 + 0.999 * z}};
                give_shape(spec, form);
                need(scene->add_body(spec));
            }
    return scene;
}

std::unique_ptr<Scene> heap(int side, Form form) {
    auto scene = empty_scene();
    const double wall = -0.75 * side;
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}})
        need(scene->add_obstacle(Plane{normal, wall}, 0));
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    BodyId id = 0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                Quat q{1, 0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random)};
                const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
                const Vec3 at{1.4 * (x - (side - 1) / 2.0), 1.4 * (y - (side - 1) / 2.0), 1 + 1.3 * z};
                BodySpec spec{.id = id++, .position_m = at + 0.1 * Vec3{normal(random), normal(random), 0}};
                spec.orientation = {q.w / n, q.x / n, q.y / n, q.z / n};
                give_shape(spec, form);
                need(scene->add_body(spec));
            }
    return scene;
}

void measure(const char* what, Scene& scene, Form form, int warm_up, int ticks, int threads, double& of_spheres) {
    Workers workers(threads);
    for (int tick = 0; tick < warm_up; ++tick) need(scene.step(kTick, 2, workers));
    const StageTimes before = scene.stage_times();
    std::vector<double> times;
    for (int tick = 0; tick < ticks; ++tick) {
        const double start = cpu_now();
        need(scene.step(kTick, 2, workers));
        times.push_back(1e3 * (cpu_now() - start));
    }
    const double tick = median(times);
    if (form == Form::Sphere) of_spheres = tick;
    const StageTimes after = scene.stage_times();
    const auto stage = [&](double StageTimes::* member) { return 1e3 * (after.*member - before.*member) / ticks; };
    fmt::print(
        "{:>7} {:<8} in a {:<7} {:8.2f} ms a tick, {:5.2f} of spheres; lists {:.2f}, contacts {:.2f}, sweeps {:.2f} ms; {:5.0f} bytes a "
        "body\n",
        scene.body_count(), kNames[static_cast<int>(form)], what, tick, tick / of_spheres,
        stage(&StageTimes::sort) + stage(&StageTimes::pairs), stage(&StageTimes::refresh), stage(&StageTimes::solve),
        static_cast<double>(scene.bytes()) / static_cast<double>(scene.body_count()));
}

}  // namespace
}  // namespace meld::physics

int main(int argc, char** argv) {
    using namespace meld::physics;
    int ticks = 50, threads = 1;
    std::vector<int> sides;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--ticks") == 0 && i + 1 < argc)
            ticks = std::atoi(argv[++i]);
        else if (std::strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
            threads = std::atoi(argv[++i]);
        else
            sides.push_back(std::atoi(argv[i]));
    }
    if (sides.empty()) sides = {22, 46};
    for (const int side : sides) {
        double of_spheres = 0;
        for (const Form form : {Form::Sphere, Form::Cube}) measure("lattice", *lattice(side, form), form, 3, ticks, threads, of_spheres);
        for (const Form form : {Form::Sphere, Form::Cube, Form::Capsule})
            measure("heap", *heap(side, form), form, 400, ticks, threads, of_spheres);
    }
    return 0;
}
