// What a world holds does not grow with the number of its candidate lists, and lists that are used up are given back.
#include <algorithm>
#include <fstream>
#include <string>

#include "physics/solver/warm_start_cache.h"
#include "tests/unit/physics/scenes.h"

// Sanitizers keep what is freed until they are asked to give it back; without one there is nobody to ask.
extern "C" [[gnu::weak]] void __sanitizer_purge_allocator();

namespace meld::physics {
namespace {

// What the system keeps resident for this process.
double resident_bytes() {
    if (__sanitizer_purge_allocator != nullptr) __sanitizer_purge_allocator();
    std::ifstream status("/proc/self/status");
    std::string line;
    while (std::getline(status, line))
        if (line.starts_with("VmRSS:")) return 1024 * std::strtod(line.c_str() + 6, nullptr);
    ADD_FAILURE() << "/proc/self/status does not tell";
    return 0;
}

// Moving one body forces a new neighbour search for all.
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

// Enough contacts that they lie in pages of their own; each body has two, with made-up partners and impulses that tell whose they are.
TEST(Memory, FormerContactsGoWhenTheBlocksAroundAreDone) {
    constexpr std::uint32_t kSide = 60, kJob = 4;
    Bodies bodies;
    std::vector<Chunks<CachedContact>> lists(3);
    for (std::uint32_t id = 0; id < kSide * kSide * kSide; ++id) {
        const std::uint32_t x = id % kSide, y = id / kSide % kSide, z = id / kSide / kSide;
        bodies.add({double(x), double(y), double(z), 0.5}, {1, 0, 0, 0}, {},
                   {.id = id, .mass = 1, .inertia_factor = 0.4f, .material = 0, .flags = 0, .still_ticks = 0});
        for (const std::uint32_t n : {0u, 1u})
            lists[(id + n) % lists.size()].push_back({id << 1 | n, id + 7 + n, static_cast<float>(id + n), {1, 2, 3}});
    }
    // Nobody here has this one.
    lists[0].push_back({(kSide * kSide * kSide + 5) << 1, 0, 1, {0, 0, 0}});
    Workers workers(2);
    BlockGrid grid;
    Buffer<std::uint32_t> order;
    need(grid.build(bodies, GridShape::fitting(0.5, 0.5, 0.1), 0.1, workers, order));
    WarmStartCache former(lists, grid, bodies, kJob, workers);
    EXPECT_TRUE(lists.empty());

    const std::size_t blocks = grid.blocks().size(), jobs = (blocks + kJob - 1) / kJob;
    std::size_t wrong = 0;
    const auto ask = [&](std::size_t block) {
        for (const std::uint32_t around : grid.blocks()[block].neighbours) {
            if (around == kNoBlock) continue;
            const Block& asked = grid.blocks()[around];
            for (std::uint32_t slot = asked.first; slot < asked.first + asked.count; ++slot)
                for (const std::uint32_t n : {0u, 1u}) {
                    const std::uint32_t id = bodies.properties[slot].id;
                    const CachedContact* found = former.find(slot, id + 7 + n);
                    wrong +=
                        !found || found->id() != id || found->touching() != (n == 1) || found->normal_impulse != static_cast<float>(id + n);
                }
        }
    };
    const double before = resident_bytes();
    // Workers end their jobs in no order: every second one comes late.
    for (std::size_t pair = 0; pair < jobs; pair += 2)
        for (const std::size_t job : {pair + 1, pair}) {
            if (job >= jobs) continue;
            for (std::size_t block = job * kJob; block < std::min(blocks, (job + 1) * kJob); ++block) ask(block);
            former.done(job);
        }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(before - resident_bytes(), 0.7 * 2 * kSide * kSide * kSide * sizeof(CachedContact));
}

}  // namespace
}  // namespace meld::physics
