// What a picture of many catoms costs: a ball of them on a lattice, from the side. Usage: bench_picture [DIAMETER] [cubic|fcc] [FORM]
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string_view>

#include "runtime/show/render/colours.h"
#include "runtime/show/render/paint.h"
#include "runtime/world/lattice/lattice.h"
#include "tests/bench/clock.h"

namespace {

namespace world = meld::world;
using namespace meld::render;

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }  // Of all threads.
double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Scene ball(double diameter, world::LatticeKind kind, Form form) {
    const world::Lattice lattice(kind);
    const ColourMap map = *ColourMap::named("viridis");
    const double radius = diameter / 2;
    const auto vec = [&](world::Cell cell) {
        const world::Vec3 at = lattice.position(cell);
        return Vec(static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2]));
    };
    Scene out{.form = form};
    const auto most = static_cast<std::int32_t>(radius), high = static_cast<std::int32_t>(radius * std::sqrt(2.0)) + 1;
    for (std::int32_t z = -high; z <= high; ++z)
        for (std::int32_t y = -most; y <= most; ++y)
            for (std::int32_t x = -most; x <= most; ++x) {
                const Vec at = vec({x, y, z});
                if (at.norm() > static_cast<float>(radius)) continue;
                out.places.push_back(at);
                out.colours.push_back(map.at(0.5 + at.z() / diameter));
            }
    for (int port = 0; port < lattice.ports(); ++port) out.ways.push_back(vec(lattice.neighbour({0, 0, 0}, port)) - vec({0, 0, 0}));
    return out;
}

}  // namespace

int main(int argc, char** argv) {
    const double diameter = argc > 1 ? std::atof(argv[1]) : 124;
    const bool fcc = argc > 2 && std::string_view(argv[2]) == "fcc";
    const std::string_view name = argc > 3 ? argv[3] : "sphere";
    const Form form = name == "cube" ? Form::Cube : name == "rounded" ? Form::Rounded : Form::Sphere;
    constexpr std::size_t kWidth = 1280, kHeight = 720;
    meld::bench::machine_line("wall seconds, medians of 5");
    const Scene scene = ball(diameter, fcc ? world::LatticeKind::Fcc : world::LatticeKind::Cubic, form);
    Camera camera({}, kWidth, kHeight, {});
    camera.include(scene);
    camera.fit();
    const int threads = static_cast<int>(std::thread::hardware_concurrency());
    meld::Workers workers(threads);
    std::vector<double> built, painted, worked;
    for (int i = 0; i < (scene.places.size() > 4'000'000 ? 1 : 5); ++i) {
        const double before = wall_s();
        const meld::Result<Geometry> geometry = Geometry::build(scene, threads);
        if (!geometry) return std::fprintf(stderr, "%s\n", geometry.error().message().c_str()), 4;
        const double between = wall_s(), used_before = cpu_s();
        const Painted picture = paint(scene, *geometry, camera, kWidth, kHeight, Rgb{255, 255, 255}, {}, workers);
        painted.push_back(wall_s() - between);
        worked.push_back(cpu_s() - used_before);
        built.push_back(between - before);
    }
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    std::printf("%zu catoms, %s, %s: build %.3f s, paint %.3f s (%.3f s of CPU), peak %.2f GB\n", scene.places.size(),
                fcc ? "fcc" : "cubic", name.data(), meld::bench::median(built), meld::bench::median(painted), meld::bench::median(worked),
                static_cast<double>(used.ru_maxrss) / 1e6);
}
