// Shape change keeps its promises in every tick: mass is conserved, the ensemble stays in one piece, and in the end every
// cell of the target is full, nobody stands outside and nobody holds a unit. On one process and several, to the same digest.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <set>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/run.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/module/load/module.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/file/world_file.h"

namespace meld {
namespace {

using world::Cell;

// What every tick must satisfy, seen over all processes.
class Invariants : public sim::SimModule {
  public:
    Invariants(std::uint64_t mass, std::vector<Digest>& digests) : mass_(mass), digests_(digests) {}

    Result<void> after(sim::Subdomain& subdomain) override {
        ByteWriter mine;
        const u32 holds = subdomain.module.predicates[*tuple::find_predicate(subdomain.module, "holds", 1)].base;
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            if (!subdomain.owned(c)) continue;
            std::int64_t held = 0;
            tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), holds, c,
                             [&](const Value* v) { held = v[0].integer; });
            mine.write(subdomain.ensemble.cell(c));
            mine.write(held);
            mine.write(subdomain.ensemble.target(subdomain.ensemble.cell(c)));
        }
        std::set<Cell> cells;
        std::uint64_t mass = 0;
        outside = 0;
        for (const auto& bytes : subdomain.comm.allgather_any(mine.view()))
            for (ByteReader in(bytes, "catoms of a part"); !in.done();) {
                EXPECT_TRUE(cells.insert(in.read<Cell>()).second) << "two catoms in one cell";
                const auto held = in.read<std::int64_t>();
                EXPECT_GE(held, 0);
                EXPECT_LE(held, subdomain.world.motion.capacity);
                mass += 1 + static_cast<std::uint64_t>(held);
                outside += !in.read<bool>();
            }
        EXPECT_EQ(mass, mass_) << "in tick " << subdomain.tick();
        EXPECT_EQ(pieces(subdomain.lattice, cells), 1) << "in tick " << subdomain.tick();
        const Digest digest = running_.of(subdomain);
        if (const Result<void> same = running_.check(subdomain); !same) return same;
        if (subdomain.comm.process() == 0) digests_.push_back(digest);
        return {};
    }

    std::uint64_t outside = 0;

  private:
    static int pieces(const world::Lattice& lattice, std::set<Cell> cells) {
        int count = 0;
        while (!cells.empty()) {
            ++count;
            std::vector<Cell> todo{*cells.begin()};
            cells.erase(cells.begin());
            while (!todo.empty()) {
                const Cell at = todo.back();
                todo.pop_back();
                for (int port = 0; port < lattice.ports(); ++port) {
                    const auto next = cells.find(lattice.neighbour(at, port));
                    if (next == cells.end()) continue;
                    todo.push_back(*next);
                    cells.erase(next);
                }
            }
        }
        return count;
    }

    std::uint64_t mass_;
    record::RunningDigest running_;
    std::vector<Digest>& digests_;
};

struct ShapeCase {
    const char* lattice;
    const char* body;
    const char* target;
    int capacity;
    int held;
};

// The first target cell of the body, as text for [facts]; the case must have one.
std::string seed_region(const world::World& world, const world::Target& target) {
    const world::Lattice lattice(world.lattice);
    std::vector<std::uint32_t> cells;
    for (const auto& [key, count] : world::count_bricks(world, lattice, 0, 1)) {
        world::cells_of_brick(world, lattice, key, cells);
        for (const std::uint32_t n : cells) {
            const Cell c = lattice.cell_in_brick(lattice.brick_at(key), n);
            if (target.contains(c)) return fmt::format("cell == ({}, {}, {})", c.x, c.y, c.z);
        }
    }
    ADD_FAILURE() << "no catom stands in the target";
    return "id == 0";
}

// Runs a case and returns the digest of every tick.
std::vector<Digest> run_case(const ShapeCase& c, int processes, int threads) {
    const std::string text = fmt::format(
        "lattice = \"{}\"\nheld = {}\n[[body]]\nshape = \"{}\"\n[target]\nshape = \"{}\"\ncells = \"mass\"\n[motion]\nkind = "
        "\"lattice\"\ncapacity = {}\n",
        c.lattice, c.held, c.body, c.target, c.capacity);
    world::World world = *world::parse_world(text, "test");
    const world::Target target = *world::Target::make(world, world::Lattice(world.lattice));
    const std::string seed = fmt::format("{}[facts]\ngiven-seed = [\"{}\"]\n", text, seed_region(world, target));
    world = *world::parse_world(seed, "test");
    const std::string module_path = *driver::compile_program({.program = CLAYMELD_EXAMPLES "/shape_change.meld"});
    const Module module = *load_module(module_path, kAbiVersion);
    const std::uint64_t mass = world::count_catoms(world, world::Lattice(world.lattice)) * static_cast<std::uint64_t>(1 + c.held);
    std::vector<Digest> digests;
    comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
        sim::Simulation simulation(*static_cast<const ModuleInfo*>(module.table()), world, target, comm, threads);
        simulation.add(std::make_unique<Invariants>(mass, digests));
        ASSERT_TRUE(simulation.start(sim::Registry::standard()).has_value());
        const Result<void> ran = simulation.run({20'000}, [] {});
        ASSERT_TRUE(ran.has_value()) << ran.error().message();
        EXPECT_EQ(simulation.summary().ending, sim::Ending::Quiet);
        ASSERT_FALSE(simulation.summary().outcomes.empty());
        EXPECT_TRUE(simulation.summary().outcomes[0].starts_with("target reached")) << simulation.summary().outcomes[0];
    });
    return digests;
}

const ShapeCase kCases[] = {
    {"cubic", "box(8, 8, 8)", "move(trumpet(length=24, bell=12, wall=2), -14, 0, 0)", 1, 0},
    {"cubic", "box(6, 6, 6)", "box(3, 3, 40)", 1, 0},
    {"cubic", "box(6, 6, 6)", "box(3, 3, 60)", 1, 1},
    {"cubic", "box(5, 5, 9)", "union(torus(8, 2), box(16, 2, 2))", 2, 0},
    {"square", "box(14, 14, 1)", "box(60, 4, 1)", 1, 0},
    {"square", "box(14, 14, 1)", "union(box(50, 3, 1), box(3, 50, 1))", 3, 0},
    {"hex", "box(12, 10, 1)", "box(50, 4, 1)", 1, 0},
    {"fcc", "sphere(4)", "box(3, 3, 30)", 1, 0},
    {"fcc", "box(5, 5, 5)", "union(box(24, 3, 3), box(3, 24, 3))", 1, 0},
};

class ShapeChange : public testing::TestWithParam<ShapeCase> {};

TEST_P(ShapeChange, ReachesTheTargetInOnePieceWithAllItsMassOnAnyNumberOfProcesses) {
    const std::vector<Digest> one = run_case(GetParam(), 1, 1);
    ASSERT_FALSE(one.empty());
    EXPECT_EQ(run_case(GetParam(), 3, 1), one);
    EXPECT_EQ(run_case(GetParam(), 2, 2), one);
}

std::string case_name(const testing::TestParamInfo<ShapeCase>& info) { return fmt::format("{}{}", info.param.lattice, info.index); }
INSTANTIATE_TEST_SUITE_P(Shapes, ShapeChange, testing::ValuesIn(kCases), case_name);

}  // namespace
}  // namespace meld
