// Our side of bench_engines.py: runs a scene of unit cubes as the adapters in tests/bench/engines do, and measures where any engine has put
// the cubes.
//
//     bench_engines run [--threads N] [--substeps N] SCENE OUT TICK...
//     bench_engines measure SCENE OUT
//
// A scene has lines: step S, gravity G (downwards), friction F, plane NX NY NZ OFFSET, body with place, orientation (w first), velocity and
// spin, all of 1 kg, and hinge FIRST SECOND with its place and axis. OUT: a line `rounding R inertia I NAME`, and for each tick that was
// asked for `tick T MS` with the CPU time of a step since the one before, and a line for each body, as in the scene.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/bench/clock.h"
#include "tests/bench/need.h"

namespace meld::physics {
namespace {

using bench::cpu_now;
using bench::need;

constexpr double kRounding = 0.02, kHalf = 0.5;

struct Hinge {
    std::size_t first = 0, second = 0;
    Vec3 place, axis;
};

struct Input {
    double step_s = 0, gravity = 0, friction = 0;
    std::vector<Plane> planes;
    std::vector<BodyState> bodies;
    std::vector<Hinge> hinges;
};

std::istream& operator>>(std::istream& in, Vec3& v) { return in >> v.x >> v.y >> v.z; }
std::istream& operator>>(std::istream& in, BodyState& body) {
    return in >> body.position_m >> body.orientation.w >> body.orientation.x >> body.orientation.y >> body.orientation.z >>
           body.linear_velocity_m_s >> body.angular_velocity_rad_s;
}

[[noreturn]] void stop(const std::string& message) {
    fmt::print(stderr, "bench_engines: {}\n", message);
    std::exit(1);
}

Input read_scene(const char* file) {
    std::ifstream in(file);
    Input scene;
    std::string what;
    while (in >> what) {
        if (what == "step")
            in >> scene.step_s;
        else if (what == "gravity")
            in >> scene.gravity;
        else if (what == "friction")
            in >> scene.friction;
        else if (what == "plane")
            in >> scene.planes.emplace_back().normal >> scene.planes.back().offset_m;
        else if (what == "body")
            in >> scene.bodies.emplace_back();
        else if (what == "hinge")
            in >> scene.hinges.emplace_back().first >> scene.hinges.back().second >> scene.hinges.back().place >> scene.hinges.back().axis;
        else
            stop(fmt::format("{}: {} is nothing that a scene has", file, what));
    }
    if (scene.bodies.empty()) stop(fmt::format("{} has no bodies", file));
    return scene;
}

int run(int threads, int substeps, const char* scene_file, const char* out_file, const std::vector<int>& ticks) {
    const Input input = read_scene(scene_file);
    const BodyShape cube = box_shape({1, 1, 1}, kRounding);
    Settings settings;
    settings.gravity_m_s2 = {0, 0, -input.gravity};
    // Nor do the other engines let anything sleep.
    settings.sleep_ticks = 0;
    settings.min_radius_m = settings.max_radius_m = cube.radius_m();
    settings.least_radius_m = cube.least_m();
    auto scene = need(Scene::make(settings));
    const std::uint8_t material = need(scene->add_material({.friction = static_cast<float>(input.friction)}));
    for (const Plane& plane : input.planes) need(scene->add_obstacle(plane, material));
    for (std::size_t i = 0; i < input.bodies.size(); ++i) {
        const BodyState& body = input.bodies[i];
        BodySpec spec{.id = static_cast<BodyId>(i), .position_m = body.position_m, .orientation = body.orientation};
        spec.linear_velocity_m_s = body.linear_velocity_m_s, spec.angular_velocity_rad_s = body.angular_velocity_rad_s;
        spec.material = material, spec.shape = cube;
        need(scene->add_body(spec));
    }
    for (const Hinge& hinge : input.hinges)
        need(scene->add_joint({.first = static_cast<BodyId>(hinge.first),
                               .second = static_cast<BodyId>(hinge.second),
                               .anchor_m = hinge.place,
                               .axis = hinge.axis}));
    std::FILE* out = std::fopen(out_file, "w");
    if (out == nullptr) stop(fmt::format("cannot write {}", out_file));
    fmt::print(out, "rounding {} inertia {} Claymeld, {} substeps of {} + {} sweeps\n", kRounding, cube.inertia_per_kg_m2().x, substeps,
               settings.solver.sweeps, settings.solver.relax_sweeps);
    Workers workers(threads);
    int done = 0;
    for (const int tick : ticks) {
        const double before = cpu_now();
        for (int t = done; t < tick; ++t) need(scene->step(input.step_s, substeps, workers));
        fmt::print(out, "tick {} {}\n", tick, 1e3 * (cpu_now() - before) / std::max(tick - done, 1));
        done = tick;
        for (std::size_t i = 0; i < input.bodies.size(); ++i) {
            const BodyState now = scene->state(static_cast<BodyId>(i));
            const Vec3 at = now.position_m, v = now.linear_velocity_m_s, w = now.angular_velocity_rad_s;
            const Quat q = now.orientation;
            fmt::print(out, "{} {} {} {} {} {} {} {} {} {} {} {} {}\n", at.x, at.y, at.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z);
        }
    }
    std::fclose(out);
    return 0;
}

// A cube without the layer that rounds its edges.
struct Core {
    Vec3 centre;
    std::array<Vec3, 3> axes;
    double half = 0;

    double reach(Vec3 along) const {
        return half * (std::abs(dot(axes[0], along)) + std::abs(dot(axes[1], along)) + std::abs(dot(axes[2], along)));
    }
    Vec3 corner(int i) const {
        return centre + ((i & 1) != 0 ? half : -half) * axes[0] + ((i & 2) != 0 ? half : -half) * axes[1] +
               ((i & 4) != 0 ? half : -half) * axes[2];
    }
    double distance(Vec3 point) const {
        double sum = 0;
        for (const Vec3& axis : axes) {
            const double beyond = std::max(std::abs(dot(axis, point - centre)) - half, 0.0);
            sum += beyond * beyond;
        }
        return std::sqrt(sum);
    }
};

// How deep two cores are in each other; negative if they are apart, along the best of fifteen directions.
double overlap(const Core& one, const Core& other) {
    double least = std::numeric_limits<double>::infinity();
    const auto along = [&](Vec3 direction) {
        const double size = length(direction);
        if (size < 1e-6) return;
        const Vec3 unit = (1 / size) * direction;
        least = std::min(least, one.reach(unit) + other.reach(unit) - std::abs(dot(other.centre - one.centre, unit)));
    };
    for (const Vec3& a : one.axes) along(a);
    for (const Vec3& b : other.axes) along(b);
    for (const Vec3& a : one.axes)
        for (const Vec3& b : other.axes) along(cross(a, b));
    return least;
}

double between(Vec3 a, Vec3 a_end, Vec3 b, Vec3 b_end) {
    const Vec3 u = a_end - a, v = b_end - b, w = a - b;
    const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w), area = uu * vv - uv * uv;
    double s = area > 1e-12 ? std::clamp((uv * vw - vv * uw) / area, 0.0, 1.0) : 0;
    const double t = std::clamp((uv * s + vw) / vv, 0.0, 1.0);
    s = std::clamp((uv * t - uw) / uu, 0.0, 1.0);
    return length(w + s * u - t * v);
}

// Between cores that are apart: corners against boxes and edges against edges.
double distance(const Core& one, const Core& other) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 8; ++i) least = std::min({least, one.distance(other.corner(i)), other.distance(one.corner(i))});
    for (int i = 0; i < 8; ++i)
        for (const int along : {1, 2, 4}) {
            if ((i & along) != 0) continue;
            for (int j = 0; j < 8; ++j)
                for (const int other_along : {1, 2, 4})
                    if ((j & other_along) == 0)
                        least =
                            std::min(least, between(one.corner(i), one.corner(i | along), other.corner(j), other.corner(j | other_along)));
        }
    return least;
}

double depth(const Core& one, const Core& other) {
    const double rounding = 2 * (kHalf - one.half), cores = overlap(one, other);
    if (cores >= 0 || rounding == 0) return cores + rounding;
    // Nearer than along a direction they are not.
    return cores + rounding <= 0 ? cores + rounding : rounding - distance(one, other);
}

struct Depths {
    double deepest = 0, sum = 0;
    int touching = 0;

    void add(double depth) {
        if (!(depth > 0)) return;
        deepest = std::max(deepest, depth), sum += depth, ++touching;
    }
};

Depths depths(const Input& input, const std::vector<BodyState>& bodies, double rounding) {
    Depths all;
    std::vector<Core> cores;
    constexpr double kCell = 1.75;
    std::map<std::array<long, 3>, std::vector<std::size_t>> cells;
    const auto cell_of = [](Vec3 at) {
        return std::array<long, 3>{std::lround(at.x / kCell), std::lround(at.y / kCell), std::lround(at.z / kCell)};
    };
    for (const BodyState& body : bodies) {
        const Quat q = body.orientation;
        cores.push_back({body.position_m, {rotate(q, {1, 0, 0}), rotate(q, {0, 1, 0}), rotate(q, {0, 0, 1})}, kHalf - rounding});
        if (is_finite(body.position_m)) cells[cell_of(body.position_m)].push_back(cores.size() - 1);
        for (const Plane& plane : input.planes)
            all.add(plane.offset_m - dot(plane.normal, body.position_m) + cores.back().reach(plane.normal) + rounding);
    }
    std::map<std::size_t, std::size_t> joined;
    for (const Hinge& hinge : input.hinges) joined[hinge.first] = hinge.second;
    for (std::size_t i = 0; i < cores.size(); ++i) {
        const auto cell = cell_of(cores[i].centre);
        for (long x = cell[0] - 1; x <= cell[0] + 1; ++x)
            for (long y = cell[1] - 1; y <= cell[1] + 1; ++y)
                for (long z = cell[2] - 1; z <= cell[2] + 1; ++z) {
                    const auto found = cells.find({x, y, z});
                    if (found == cells.end()) continue;
                    for (const std::size_t j : found->second) {
                        const auto held = joined.find(i);
                        if (j > i && length(cores[j].centre - cores[i].centre) < 1.7321 && (held == joined.end() || held->second != j))
                            all.add(depth(cores[i], cores[j]));
                    }
                }
    }
    return all;
}

double kinetic(const std::vector<BodyState>& bodies, double inertia) {
    double sum = 0;
    for (const BodyState& body : bodies)
        sum += 0.5 * dot(body.linear_velocity_m_s, body.linear_velocity_m_s) +
               0.5 * inertia * dot(body.angular_velocity_rad_s, body.angular_velocity_rad_s);
    return sum;
}

int measure(const char* scene_file, const char* out_file) {
    const Input input = read_scene(scene_file);
    std::ifstream in(out_file);
    std::string word, name;
    double rounding = 0, inertia = 0;
    if (!(in >> word >> rounding >> word >> inertia) || !std::getline(in >> std::ws, name))
        stop(fmt::format("{} is not complete", out_file));
    std::vector<BodyState> before = input.bodies, bodies(input.bodies.size());
    const double energy_at_first = kinetic(before, inertia);
    int tick = 0, former = 0;
    double ms = 0;
    while (in >> word >> tick >> ms) {
        for (BodyState& body : bodies)
            if (!(in >> body)) stop(fmt::format("{} ends early", out_file));
        double parted = 0, tilted = 0, square = 0, farthest = 0, fastest = 0;
        for (const Hinge& hinge : input.hinges) {
            const auto now = [&](std::size_t i, Vec3 v) {
                return rotate(bodies[i].orientation, rotate(conjugate(input.bodies[i].orientation), v));
            };
            const auto anchor = [&](std::size_t i) { return bodies[i].position_m + now(i, hinge.place - input.bodies[i].position_m); };
            parted = std::max(parted, length(anchor(hinge.first) - anchor(hinge.second)));
            tilted = std::max(tilted, length(cross(now(hinge.first, hinge.axis), now(hinge.second, hinge.axis))));
        }
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            const double way = length(bodies[i].position_m - before[i].position_m);
            square += way * way, farthest = std::max(farthest, way);
            fastest = std::max(fastest, length(bodies[i].linear_velocity_m_s));
        }
        const double seconds = input.step_s * std::max(tick - former, 1);
        const Depths deep = depths(input, bodies, rounding);
        fmt::print(R"({{"name": "{}", "tick": {}, "ms": {}, "deepest": {}, "depth": {}, "touching": {}, "creep": {}, "farthest": {}, )"
                   R"("fastest": {}, "parted": {}, "tilted": {}, "energy": {}}})"
                   "\n",
                   name, tick, ms, deep.deepest, deep.touching > 0 ? deep.sum / deep.touching : 0, deep.touching,
                   std::sqrt(square / static_cast<double>(bodies.size())) / seconds, farthest, fastest, parted, tilted,
                   energy_at_first > 0 ? kinetic(bodies, inertia) / energy_at_first - 1 : 0);
        before = bodies, former = tick;
    }
    return 0;
}

}  // namespace
}  // namespace meld::physics

int main(int argc, char** argv) {
    using namespace meld::physics;
    std::vector<char*> arguments(argv + 1, argv + argc);
    int threads = 1, substeps = 2;
    while (arguments.size() > 2 && std::strncmp(arguments[1], "--", 2) == 0) {
        (std::strcmp(arguments[1], "--substeps") == 0 ? substeps : threads) = std::max(std::atoi(arguments[2]), 1);
        arguments.erase(arguments.begin() + 1, arguments.begin() + 3);
    }
    if (arguments.size() == 3 && std::strcmp(arguments[0], "measure") == 0) return measure(arguments[1], arguments[2]);
    if (arguments.size() < 4 || std::strcmp(arguments[0], "run") != 0) {
        fmt::print(stderr,
                   "usage: bench_engines run [--threads N] [--substeps N] SCENE OUT TICK...\n       bench_engines measure SCENE OUT\n");
        return 2;
    }
    std::vector<int> ticks;
    for (std::size_t i = 3; i < arguments.size(); ++i) ticks.push_back(std::atoi(arguments[i]));
    return run(threads, substeps, arguments[1], arguments[2], ticks);
}
