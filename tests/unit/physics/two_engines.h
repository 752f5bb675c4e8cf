// The same scene in our engine and in ODE, side by side over time.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {

struct BothEngines {
    std::unique_ptr<Scene> ours, odes;
    double step_s;
    Workers workers{1};

    explicit BothEngines(double step, Vec3 gravity = {0, 0, -kGravity}, SolverSettings solver = {}) : step_s(step) {
        Settings settings{.solver = solver, .gravity_m_s2 = gravity, .sleep_ticks = 0};
        ours = make_scene(settings);
        settings.engine = EngineKind::Ode;
        settings.solver = SolverSettings::pgs20();
        odes = make_scene(settings);
    }
    template <class F>
    void each(const F& f) {
        f(*ours), f(*odes);
    }
    void steps(int count) {
        each([&](Scene& scene) {
            for (int step = 0; step < count; ++step) need(scene.step(step_s, 1, workers));
        });
    }
    void go(double seconds) { steps(static_cast<int>(std::lround(seconds / step_s))); }
    double apart(BodyId body) const { return length(ours->state(body).position_m - odes->state(body).position_m); }
    // The angle between the two, rad.
    double turned(BodyId body) const {
        const Quat a = ours->state(body).orientation, b = odes->state(body).orientation;
        return 2 * std::acos(std::min(1.0, std::abs(a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z)));
    }
    // The greatest distance of a body from where it is in the other engine, now; and over some time.
    double apart_now() const {
        double most = 0;
        for (const BodyId body : ours->bodies()) most = std::max(most, apart(body));
        return most;
    }
    double most_apart(double seconds) {
        double most = 0;
        for (double at = 0; at < seconds - step_s / 2; at += 0.05) {
            go(0.05);
            most = std::max(most, apart_now());
        }
        return most;
    }
};

}  // namespace meld::physics
