// The three physics engines against mechanics that can be written down: what each is off by, in one run.
//
//     bench_mechanics
//
// Ticks of 1/240 s. `blocks` runs as it does for users, soft with two substeps; the others with 20 cold sweeps of ODE's kind.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "physics/scene/scene.h"
#include "tests/bench/clock.h"
#include "tests/bench/need.h"

namespace meld::physics {
namespace {

using bench::need;

constexpr double kTick = 1.0 / 240;
constexpr double kGravity = 9.81;
constexpr std::array kEngines = {EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode};

// One engine's scenes.
class Laboratory {
  public:
    explicit Laboratory(EngineKind engine) : engine_(engine) {}

    std::unique_ptr<Scene> make(Vec3 gravity) const {
        Settings settings{.engine = engine_, .gravity_m_s2 = gravity, .sleep_ticks = 0};
        if (engine_ != EngineKind::Blocks) settings.solver = SolverSettings::pgs20();
        return need(Scene::make(settings));
    }
    void run(Scene& scene, int ticks) {
        for (int tick = 0; tick < ticks; ++tick) need(scene.step(kTick, substeps(), workers_));
    }
    int substeps() const { return engine_ == EngineKind::Blocks ? 2 : 1; }

    // Metres off the parabola after a second of falling.
    double fall() {
        auto scene = make({0, 0, -kGravity});
        need(scene->add_body({.id = 0, .position_m = {0, 0, 100}, .linear_velocity_m_s = {1, -2, 5}}));
        run(*scene, 240);
        return length(scene->state(0).position_m - Vec3{1, -2, 105 - kGravity / 2});
    }
    // A ball thrown flat at 7 m/s slides until it rolls, at 5 m/s; off by this share.
    double rolling() {
        auto scene = make({0, 0, -kGravity});
        need(scene->add_obstacle(Plane{}, 0));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {7, 0, 0}}));
        run(*scene, 480);
        return std::abs(scene->state(0).linear_velocity_m_s.x / 5 - 1);
    }
    // How far its rim slips then, m/s.
    double slip() {
        auto scene = make({0, 0, -kGravity});
        need(scene->add_obstacle(Plane{}, 0));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {7, 0, 0}}));
        run(*scene, 480);
        const BodyState state = scene->state(0);
        return std::abs(state.angular_velocity_rad_s.y * 0.5 - state.linear_velocity_m_s.x);
    }
    // Down a slope of 0.3 rad: 5/7 of its pull for a second; off by this share.
    double slope() {
        auto scene = make({kGravity * std::sin(0.3), 0, -kGravity * std::cos(0.3)});
        need(scene->add_obstacle(Plane{}, 0));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
        run(*scene, 240);
        return std::abs(scene->state(0).linear_velocity_m_s.x / (5.0 / 7 * kGravity * std::sin(0.3)) - 1);
    }

    struct Drift {
        double momentum, spin, energy;
        std::size_t touches;
    };
    // 343 balls of several sizes thrown together in space, 240 ticks: what is won of momentum and angular momentum, as a share
    // of the sum of all masses times speeds (times a metre), and the greatest gain of energy in a tick, as a share.
    Drift cloud() {
        auto scene = make({});
        std::mt19937 random(17);
        std::uniform_real_distribution<double> jitter(-0.2, 0.2), radius(0.3, 0.5), speed(-2, 2);
        const auto vector = [&](auto& from) {
            const double x = from(random), y = from(random), z = from(random);
            return Vec3{x, y, z};
        };
        constexpr int side = 7;
        double amount = 0;
        for (BodyId id = 0; id < side * side * side; ++id) {
            const double r = radius(random), mass = 8 * r * r * r;
            const Vec3 at = 1.05 * Vec3{double(id % side), double(id / side % side), double(id / side / side)} + vector(jitter);
            const Vec3 velocity = vector(speed), spin = vector(speed);
            need(scene->add_body({.id = id,
                                  .position_m = at,
                                  .linear_velocity_m_s = velocity,
                                  .angular_velocity_rad_s = spin,
                                  .radius_m = r,
                                  .mass_kg = mass}));
            amount += mass * length(velocity);
        }
        const Vec3 momentum = scene->momentum(), spin = scene->angular_momentum();
        double energy = scene->kinetic_energy_j();
        Drift drift{};
        for (int tick = 0; tick < 240; ++tick) {
            run(*scene, 1);
            drift.touches += scene->events().size();
            drift.energy = std::max(drift.energy, scene->kinetic_energy_j() / energy - 1);
            energy = scene->kinetic_energy_j();
        }
        drift.momentum = length(scene->momentum() - momentum) / amount;
        drift.spin = length(scene->angular_momentum() - spin) / amount;
        return drift;
    }

    // Two balls whose magnets face each other 0.3 m apart come together: the kinetic energy at 0.03 m differs from what the
    // field has lost by this share.
    double magnets() {
        auto scene = make({});
        const Feature magnet{.strength = 400, .depth_m = 0.2, .range_m = 0.6};
        std::vector<Feature> features(2, magnet);
        features[0].direction = {1, 0, 0};
        features[1].direction = {-1, 0, 0};
        const auto table = need(scene->add_feature_table(features));
        for (const BodyId id : {0u, 1u}) {
            need(scene->add_body({.id = id, .position_m = {1.3 * id, 0, 0}}));
            need(scene->set_feature_table(id, table));
        }
        need(scene->set_features(0, 1, 0));
        need(scene->set_features(1, 2, 2));
        const auto apart = [&] { return scene->state(1).position_m.x - scene->state(0).position_m.x - 1; };
        const auto field_j = [&] {
            double charge = 0;
            return interact(magnet, {{}, {1, 0, 0}, 1}, magnet, {{apart(), 0, 0}, {-1, 0, 0}, -1}, charge).energy_j;
        };
        const double before = field_j();
        for (int tick = 0; apart() > 0.03 && tick < 2000; ++tick) run(*scene, 1);
        return std::abs(scene->kinetic_energy_j() / (before - field_j()) - 1);
    }

  private:
    EngineKind engine_;
    Workers workers_{1};
};

void row(const std::string& what, double (Laboratory::*measure)()) {
    std::string line = fmt::format("{:62}", what);
    for (const EngineKind engine : kEngines) line += fmt::format(" {:>10.2g}", (Laboratory(engine).*measure)());
    fmt::print("{}\n", line);
}

void report() {
    fmt::print("{:62} {:>10} {:>10} {:>10}\n", "off by", "blocks", "hash", "ode");
    row("a second of falling, m", &Laboratory::fall);
    row("speed when sliding has become rolling (5/7), share", &Laboratory::rolling);
    row("slip of its rim then, m/s", &Laboratory::slip);
    row("speed after a second down a slope (5/7 of the pull), share", &Laboratory::slope);
    row("kinetic energy of two magnets against their field's, share", &Laboratory::magnets);
    std::array<Laboratory::Drift, kEngines.size()> drifts{};
    for (std::size_t i = 0; i < kEngines.size(); ++i) drifts[i] = Laboratory(kEngines[i]).cloud();
    const auto cloud = [&](const char* what, double Laboratory::Drift::* part) {
        fmt::print("{:62} {:>10.2g} {:>10.2g} {:>10.2g}\n", what, drifts[0].*part, drifts[1].*part, drifts[2].*part);
    };
    cloud("momentum of a cloud of 343 balls in a second, share", &Laboratory::Drift::momentum);
    cloud("its angular momentum, share times a metre", &Laboratory::Drift::spin);
    cloud("energy gained in its worst tick, share", &Laboratory::Drift::energy);
    fmt::print("touches and partings in the cloud: {}, {}, {}\n", drifts[0].touches, drifts[1].touches, drifts[2].touches);
}

}  // namespace
}  // namespace meld::physics

int main() {
    meld::bench::machine_line("errors, not times");
    meld::physics::report();
    return 0;
}
