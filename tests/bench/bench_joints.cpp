// Joints: many pairs of balls and many chains that float without touching, and one long chain, beside as many balls without joints.
//
//     bench_joints [--ticks N] [--threads N] [joints]     joints = 10000
//
// Times are CPU milliseconds of the process, medians over ticks of one step.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
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

enum class Held { Nothing, Hinges, Servos };

// Chains side by side, each along x.
std::unique_ptr<Scene> chains(int count, int links, Held held) {
    Settings settings;
    settings.sleep_ticks = 0;
    settings.gravity_m_s2 = {};
    auto scene = need(Scene::make(settings));
    BodyId id = 0;
    for (int c = 0; c < count; ++c)
        for (int i = 0; i < links; ++i, ++id) {
            const Vec3 at{1.0 * i, 1.3 * (c % 300), 1.3 * (c / 300)};
            need(scene->add_body({.id = id, .position_m = at, .linear_velocity_m_s = {0, 0, 0.01 * (id % 7)}}));
            if (i == 0 || held == Held::Nothing) continue;
            JointSpec joint{.first = id - 1, .second = id, .anchor_m = at - Vec3{0.5, 0, 0}, .axis = {0, 1, 0}};
            if (held == Held::Servos) joint.strength = 10, joint.drive = {JointDrive::Kind::Servo, 0.1};
            need(scene->add_joint(joint));
        }
    return scene;
}

void measure(const std::string& name, Scene& scene, int joints, int ticks, int threads) {
    Workers workers(threads);
    need(scene.step(kTick, 2, workers));
    std::vector<double> times;
    for (int tick = 0; tick < ticks; ++tick) {
        const double begin = cpu_now();
        need(scene.step(kTick, 2, workers));
        times.push_back(1e3 * (cpu_now() - begin));
    }
    const double time = median(times);
    fmt::print("{:28} {:9.3f} ms {:7.2f} us a joint {:6} bytes a body\n", name, time, 1e3 * time / joints,
               scene.bytes() / scene.body_count());
}

int run(int argc, char** argv) {
    int ticks = 20, threads = 1, joints = 10'000;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--ticks") == 0 && i + 1 < argc)
            ticks = std::atoi(argv[++i]);
        else if (std::strcmp(argv[i], "--threads") == 0 && i + 1 < argc)
            threads = std::atoi(argv[++i]);
        else
            joints = std::max(std::atoi(argv[i]), 2);
    }
    const auto row = [&](const std::string& name, int count, int links, Held held) {
        auto scene = chains(count, links, held);
        measure(name, *scene, count * (links - 1), ticks, threads);
    };
    constexpr int kLinks = 101;
    const int long_chains = std::max(joints / (kLinks - 1), 1);
    row("pairs without joints", joints, 2, Held::Nothing);
    row("pairs", joints, 2, Held::Hinges);
    row("pairs with servos", joints, 2, Held::Servos);
    row("chains of 100", long_chains, kLinks, Held::Hinges);
    row("chains of 100 with servos", long_chains, kLinks, Held::Servos);
    row("one chain", 1, joints + 1, Held::Hinges);
    return 0;
}

}  // namespace
}  // namespace meld::physics

int main(int argc, char** argv) { return meld::physics::run(argc, argv); }
