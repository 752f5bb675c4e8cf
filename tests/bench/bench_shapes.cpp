// Piles of cubes, capsules and cylinders beside piles of as many spheres, in one run: k^3 bodies on a lattice, touching on a plane; and as
// many that fall into a walled box in disorder; and what two subdomains of such a box send each other.
//
//     bench_shapes [--ticks N] [--threads N] [k ...]     k = 22 46
//
// Times are CPU milliseconds of the process, medians over ticks.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "physics/scene/scene.h"
#include "physics/scene/subdomain.h"
#include "tests/bench/clock.h"
#include "tests/bench/need.h"

namespace meld::physics {
namespace {

using bench::cpu_now;
using bench::median;
using bench::need;

constexpr double kTick = 1.0 / 240;

enum class Form { Sphere, Cube, Capsule, Cylinder };
constexpr const char* kNames[] = {"spheres", "cubes", "capsules", "cylinders"};

void give_shape(BodySpec& spec, Form form) {
    if (form == Form::Cube) spec.shape = box_shape({1, 1, 1}, 0.02);
    if (form == Form::Capsule) spec.shape = capsule_shape(0.3, 1);
    if (form == Form::Cylinder) spec.shape = cylinder_shape(0.5, 1, 0.02);
}

std::unique_ptr<Scene> empty_scene(Form form) {
    Settings settings;
    // All ticks are alike.
    settings.sleep_ticks = 0;
    BodySpec spec;
    give_shape(spec, form);
    settings.min_radius_m = settings.max_radius_m = spec.shape ? spec.shape->radius_m() : spec.radius_m;
    settings.least_radius_m = spec.shape ? spec.shape->least_m() : spec.radius_m;
    auto scene = need(Scene::make(settings));
    need(scene->add_obstacle(Plane{}, 0));
    return scene;
}

std::unique_ptr<Scene> lattice(int side, Form form) {
    auto scene = empty_scene(form);
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

// With the bodies for which `mine` is true.
std::unique_ptr<Scene> heap(int side, Form form, const std::function<bool(BodyId)>& mine) {
    auto scene = empty_scene(form);
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
                if (mine(spec.id)) need(scene->add_body(spec));
            }
    return scene;
}

std::unique_ptr<Scene> heap(int side, Form form) {
    return heap(side, form, [](BodyId) { return true; });
}

// Two halves in one process, with the messages carried by hand.
void measure_halves(int side, Form form, int warm_up, int ticks) {
    Workers workers(1);
    std::unique_ptr<Scene> scenes[2];
    std::vector<std::unique_ptr<Subdomain>> parts;
    for (int self = 0; self < 2; ++self) {
        scenes[self] = heap(side, form, [self](BodyId id) { return static_cast<int>(id % 2) == self; });
        const auto owner = [](BlockCoordinates block) { return block.x < 0 ? 0 : 1; };
        parts.push_back(std::make_unique<Subdomain>(*scenes[self], owner, self, 2));
    }
    std::size_t of_lists = 0, of_steps = 0;
    int lists = 0;
    const auto carry = [&](std::size_t& bytes, const auto& pack, const auto& unpack) {
        Subdomain::Messages sent[2];
        for (int self = 0; self < 2; ++self) sent[self] = pack(*parts[static_cast<std::size_t>(self)]);
        for (const auto& messages : sent)
            for (const auto& [to, message] : messages)
                unpack(*parts[static_cast<std::size_t>(to)], message.view()), bytes += message.size();
    };
    for (int tick = 0; tick < warm_up + ticks; ++tick) {
        if (tick == warm_up) of_lists = of_steps = 0, lists = 0;
        if (parts[0]->must_rebuild(kTick, 2) || parts[1]->must_rebuild(kTick, 2)) {
            Velocities all = parts[0]->velocities();
            all.add(parts[1]->velocities());
            for (const auto& part : parts) part->set_velocities(all, kTick, 2);
            carry(
                of_lists, [&](Subdomain& part) { return part.pack_bodies(workers); },
                [](Subdomain& part, Subdomain::Bytes bytes) { need(part.unpack_bodies(bytes)); });
            for (const auto& part : parts) part->unpacked();
            ++lists;
        }
        std::vector<Stage> stages;
        for (const auto& part : parts) stages = part->stages(kTick, 2);
        for (const Stage& stage : stages) {
            for (const auto& part : parts) need(part->run(stage, workers));
            if (stage.must_exchange())
                carry(
                    of_steps, [&](Subdomain& part) { return part.pack(stage); },
                    [&](Subdomain& part, Subdomain::Bytes bytes) { part.unpack(stage, bytes); });
        }
        for (const auto& part : parts) part->finish();
    }
    fmt::print("{:>7} {:<9} in two halves: {:.0f} kB a step, and {:.0f} kB for each of {} new lists in {} steps\n",
               scenes[0]->body_count() + scenes[1]->body_count(), kNames[static_cast<int>(form)],
               1e-3 * static_cast<double>(of_steps) / ticks, 1e-3 * static_cast<double>(of_lists) / std::max(lists, 1), lists, ticks);
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
        "{:>7} {:<9} in a {:<7} {:8.2f} ms a tick, {:5.2f} of spheres; lists {:.2f}, contacts {:.2f}, sweeps {:.2f} ms; {:5.0f} bytes a "
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
        for (const Form form : {Form::Sphere, Form::Cube, Form::Capsule, Form::Cylinder})
            measure("heap", *heap(side, form), form, 400, ticks, threads, of_spheres);
        for (const Form form : {Form::Sphere, Form::Cube, Form::Capsule, Form::Cylinder}) measure_halves(side, form, 400, ticks);
    }
    return 0;
}
