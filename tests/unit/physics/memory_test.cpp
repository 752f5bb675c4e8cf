// What a world holds does not grow with the number of its candidate lists.
#include <fstream>
#include <string>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

// What the system keeps resident for this process, 0 where it does not tell.
double resident_bytes() {
    std::ifstream status("/proc/self/status");
    std::string line;
    while (std::getline(status, line))
        if (line.starts_with("VmRSS:")) return 1024 * std::strtod(line.c_str() + 6, nullptr);
    return 0;
}

// A body that is put elsewhere makes all look for their neighbours anew.
void look_anew(Scene& scene, int times, Workers& workers) {
    for (int i = 0; i < times; ++i) {
        BodyState state = scene.state(0);
        state.position_m.x += i % 2 == 0 ? 1e-6 : -1e-6;
        need(scene.set_state(0, state));
        const StepReport report = need(scene.step(kTick, 1, workers));
        ASSERT_TRUE(report.rebuilt);
    }
}

TEST(Memory, DoesNotGrowWithListsMadeAnew) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers keep freed memory for a while";
#endif
    if (resident_bytes() == 0) GTEST_SKIP() << "the system does not tell what is resident";
    // Some 9 MB of contacts. Of what is smaller the heap may keep a few pieces.
    constexpr int kSide = 40;
    auto scene = scene_on_plane();
    add_cube(*scene, kSide);
    for (const int threads : {1, 2}) {
        Workers workers(threads);
        look_anew(*scene, 3, workers);
        const double before = resident_bytes();
        look_anew(*scene, 12, workers);
        EXPECT_LT(resident_bytes() - before, 0.5 * static_cast<double>(scene->bytes())) << threads << " threads";
    }
}

}  // namespace
}  // namespace meld::physics
