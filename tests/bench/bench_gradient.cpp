// The gradient on a million catoms, cubic and face-centred cubic, and on a gyroid's walls, beside the same by hand in the same
// run: from loaded world to quiet; then the source is taken away and given back, and single catoms (their links) are cut. Usage:
// bench_gradient GRADIENT.meld [SIDE]
#include <cinttypes>

#include "tests/bench/floor.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

struct Work {
    double seconds = 0;
    std::uint64_t evaluations = 0, changes = 0;
    std::int64_t ticks = 0;
};

Work settle(Run& run) {
    sim::Summary& s = run.simulation->summary();
    const sim::Summary before = s;
    Work w;
    w.seconds = run.settle();
    w.evaluations = s.evaluations - before.evaluations;
    w.changes = s.changes - before.changes;
    w.ticks = s.ticks - before.ticks;
    return w;
}

Work settle(HandGradient& hand) {
    Work w;
    const std::uint64_t evaluations = hand.evaluations, changes = hand.changes;
    const double before = cpu_now();
    w.ticks = hand.settle();
    w.seconds = cpu_now() - before;
    w.evaluations = hand.evaluations - evaluations;
    w.changes = hand.changes - changes;
    return w;
}

void row(const char* what, const Work& ours, const Work& hand) {
    std::printf("  %-28s %9.4f s %9.4f s   ratio %5.2f   %10" PRIu64 " evaluations %10" PRIu64 " changes %6" PRId64 " ticks\n", what,
                ours.seconds, hand.seconds, hand.seconds > 0 ? ours.seconds / hand.seconds : 0.0, ours.evaluations, ours.changes,
                ours.ticks);
}

void check(Run& run, const HandGradient& hand, u32 dist) {
    sim::Subdomain& subdomain = run.subdomain();
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        std::uint32_t ours = 0xffffffff;
        tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), dist, c,
                         [&](const Value* v) { ours = static_cast<std::uint32_t>(v[0].integer); });
        if (ours != hand.value(c)) {
            std::fprintf(stderr, "catom %u: %u by the program, %u by hand\n", c, ours, hand.value(c));
            std::exit(70);
        }
    }
}

// at: which catom is the source, as a share of all.
void measure(const std::string& program, const std::string& lattice, const std::string& shape, double at) {
    const std::string world = "lattice = \"" + lattice + "\"\n[[body]]\nshape = \"" + shape + "\"\n";
    std::vector<double> seconds, floors;
    std::unique_ptr<Run> run;
    std::unique_ptr<HandGradient> hand;
    Work first, first_hand;
    u32 source = 0, dist = 0;
    sim::Catom origin = 0;
    for (int repeat = 0; repeat < 5; ++repeat) {
        run = std::make_unique<Run>(program, world);
        hand = std::make_unique<HandGradient>(run->subdomain().ensemble);
        dist = *tuple::find_predicate(run->info(), "dist", 1);
        source = run->info().predicates[*tuple::find_predicate(run->info(), "source", 0)].base;
        origin = static_cast<sim::Catom>(at * static_cast<double>(run->subdomain().ensemble.index_count()));
        run->subdomain().give(source, origin, nullptr);
        hand->set_source(origin, true);
        first = settle(*run);
        first_hand = settle(*hand);
        seconds.push_back(first.seconds);
        floors.push_back(first_hand.seconds);
    }
    first.seconds = median(seconds);
    first_hand.seconds = median(floors);
    check(*run, *hand, dist);
    std::printf("%s, %s, %zu catoms: %.1f bytes a catom (by hand %.1f and the ensemble's %.1f)\n", lattice.c_str(), shape.c_str(),
                run->subdomain().ensemble.owned_count(),
                static_cast<double>(run->subdomain().bytes()) / static_cast<double>(run->subdomain().ensemble.owned_count()),
                static_cast<double>(hand->bytes()) / static_cast<double>(run->subdomain().ensemble.owned_count()),
                static_cast<double>(run->subdomain().ensemble.bytes()) / static_cast<double>(run->subdomain().ensemble.owned_count()));
    row("settle", first, first_hand);

    run->subdomain().take(source, origin, nullptr);
    hand->set_source(origin, false);
    const Work gone = settle(*run), gone_hand = settle(*hand);
    row("source removed", gone, gone_hand);
    check(*run, *hand, dist);
    run->subdomain().give(source, origin, nullptr);
    hand->set_source(origin, true);
    const Work back = settle(*run), back_hand = settle(*hand);
    row("source restored", back, back_hand);
    check(*run, *hand, dist);

    // Cutting a catom out takes all its links; the work must not depend on the size of the ensemble.
    Work cut;
    const int cuts = 1000;
    std::uint64_t state = 12345;
    for (int i = 0; i < cuts; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const auto victim = static_cast<sim::Catom>((state >> 20) % run->subdomain().ensemble.index_count());
        if (run->subdomain().ensemble.state(victim) != kCatomOwned || victim == origin) continue;
        run->subdomain().remove_catom(victim);
        const Work w = settle(*run);
        cut.seconds += w.seconds;
        cut.evaluations += w.evaluations;
        cut.changes += w.changes;
        cut.ticks += w.ticks;
    }
    std::printf("  %-28s %9.2f us a cut, %.1f evaluations, %.1f changes, %.1f ticks\n", "a catom cut out", cut.seconds / cuts * 1e6,
                static_cast<double>(cut.evaluations) / cuts, static_cast<double>(cut.changes) / cuts,
                static_cast<double>(cut.ticks) / cuts);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_gradient GRADIENT.meld [SIDE]\n");
        return 2;
    }
    machine_line();
    const int side = argc > 2 ? std::atoi(argv[2]) : 100;
    const std::string n = std::to_string(side);
    measure(argv[1], "cubic", "box(" + n + ", " + n + ", " + n + ")", 0);
    measure(argv[1], "fcc", "box(" + n + ", " + n + ", " + std::to_string(side * 0.7071) + ")", 0);
    // Full of tunnels, so that a cut makes detours.
    measure(argv[1], "cubic", "gyroid(" + std::to_string(side * 2) + ", 4)", 0.5);
    return 0;
}
