// Shape change at three sizes: ticks, creations, CPU, beside the ticks and CPU of the prototype's own rules and target
// (10,648: 869 ticks; 32,768: 3,349; 97,336: 5,704 ticks and 21-63 CPU s in hand-written C++). The shapes differ, so the
// ratio of ticks is a guide only. Usage: bench_shape SHAPE_CHANGE.meld [LARGEST SIDE]
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

struct Size {
    int side;
    const char* target;
    const char* seed;
    int prototype_ticks;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_shape SHAPE_CHANGE.meld [LARGEST SIDE]\n");
        return 2;
    }
    machine_line();
    const int largest = argc > 2 ? std::atoi(argv[2]) : 46;
    const Size sizes[] = {{22, "move(trumpet(length=60, bell=30, wall=3), -42, 0, 0)", "(-3, -6, -2)", 869},
                          {32, "move(scale(trumpet(length=60, bell=30, wall=3), 1.4545), -61.1, 0, 0)", "", 3349},
                          {46, "move(scale(trumpet(length=60, bell=30, wall=3), 2.0909), -87.8, 0, 0)", "", 5704}};
    for (const Size& size : sizes) {
        if (size.side > largest) break;
        const std::string s = std::to_string(size.side);
        // The seed is the catom of the target nearest the middle; every process would choose the same.
        std::string world = "lattice = \"cubic\"\n[[body]]\nshape = \"box(" + s + "," + s + "," + s + ")\"\n[target]\nshape = \"" +
                            size.target + "\"\ncells = \"mass\"\n[motion]\nkind = \"lattice\"\ncapacity = 1\n";
        Run run(argv[1], world);
        sim::Subdomain& subdomain = run.subdomain();
        sim::Catom seed = 0;
        double nearest = 1e300;
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            const world::Vec3 p = subdomain.ensemble.position(c);
            const double d = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            if (!subdomain.ensemble.target(subdomain.ensemble.cell(c)) || d >= nearest) continue;
            nearest = d;
            seed = c;
        }
        subdomain.give(run.info().predicates[*tuple::find_predicate(run.info(), "given-seed", 0)].base, seed, nullptr);
        const double seconds = run.settle();
        const sim::Summary& sum = run.simulation->summary();
        std::printf("%d^3: %s; prototype's own target %d ticks; %.1f s CPU, %.0f ns an evaluation, %.0f bytes a catom\n", size.side,
                    sum.outcomes.empty() ? "" : sum.outcomes[0].c_str(), size.prototype_ticks, seconds,
                    seconds * 1e9 / static_cast<double>(sum.evaluations), sum.bytes_per_catom);
        std::fflush(stdout);
    }
    return 0;
}
