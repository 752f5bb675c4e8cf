// Programs of the Meld literature beside the same by hand in C++ (hand_programs.h) in the same run, checked to give the same:
// diffusion, PageRank without rounds, two kinds of belief propagation, and queens on a board. CPU seconds from a loaded world to
// quiet, and bytes a catom. Usage: bench_programs EXAMPLES PROGRAMS [small]
#include <bit>
#include <cinttypes>
#include <cmath>

#include "tests/bench/hand_programs.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

// Sums of floats are made in another order by hand.
constexpr double kRounding = 1e-11;

[[noreturn]] void differs(const char* what, sim::Catom catom, double ours, double hand) {
    std::fprintf(stderr, "%s at catom %u: %.17g by the program, %.17g by hand\n", what, catom, ours, hand);
    std::exit(70);
}
void same(const char* what, sim::Catom catom, double ours, double hand, double tolerance = kRounding) {
    if (!(std::fabs(ours - hand) <= tolerance * (1 + std::fabs(hand)))) differs(what, catom, ours, hand);
}

std::uint32_t predicate(const Run& run, const char* name, std::size_t arity) { return *tuple::find_predicate(run.info(), name, arity); }

void give(Run& run, const char* name, sim::Catom catom, std::vector<Value> arguments) {
    run.subdomain().give(run.info().predicates[predicate(run, name, arguments.size())].base, catom, arguments.data());
}
// The only fact of a predicate that a catom holds.
std::vector<Value> fact(Run& run, std::uint32_t id, sim::Catom catom) {
    std::vector<Value> out;
    sim::Subdomain& subdomain = run.subdomain();
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), id, catom,
                     [&](const Value* v) { out.assign(v, v + subdomain.module.predicates[id].arity); });
    if (out.empty()) differs(subdomain.module.predicates[id].name, catom, NAN, 0);
    return out;
}

// A number that looks random, from 0 to below 1, the same in every run.
double noise(std::uint64_t catom) {
    std::uint64_t x = (catom + 1) * 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 29)) * 0xbf58476d1ce4e5b9u;
    return static_cast<double>((x ^ (x >> 32)) >> 11) * 0x1p-53;
}

struct Case {
    std::string what, program, world;
    double best_meld = 0;  // CPU seconds of the same algorithm, compiled; 0: not known. See docs/lab/linear-rules.md.
};

// Three runs of both: prepare(run) gives the facts, hand(run) is timed, check(run, what hand made) compares the last.
template <class Prepare, class Hand, class Check>
void measure(const Case& c, const Prepare& prepare, const Hand& hand, const Check& check) {
    std::vector<double> seconds, by_hand;
    for (int repeat = 0; repeat < 3; ++repeat) {
        Run run(c.program, c.world);
        prepare(run);
        seconds.push_back(run.settle());
        run.subdomain().refresh();
        const double before = cpu_now();
        const auto made = hand(run);
        by_hand.push_back(cpu_now() - before);
        if (repeat < 2) continue;
        check(run, made);
        const sim::Summary& sum = run.simulation->summary();
        const double ours = median(seconds), theirs = median(by_hand), catoms = static_cast<double>(run.subdomain().ensemble.owned_count());
        char best[32] = "";
        if (c.best_meld > 0) std::snprintf(best, sizeof best, "best Meld %4.2f s", c.best_meld);
        std::printf("%-42s %8.3f s  by hand %8.4f s  ratio %5.1f  %-16s  %8.0f bytes a catom  %10" PRIu64
                    " messages %6.0f ns each  %6" PRId64 " ticks\n",
                    c.what.c_str(), ours, theirs, ours / theirs, best, static_cast<double>(run.subdomain().bytes()) / catoms, sum.messages,
                    sum.messages == 0 ? 0.0 : ours * 1e9 / static_cast<double>(sum.messages), sum.ticks);
        std::fflush(stdout);
    }
}

std::string box(const char* lattice, int x, int y, int z, const std::string& rest = "") {
    return "lattice = \"" + std::string(lattice) + "\"\n[[body]]\nshape = \"box(" + std::to_string(x) + ", " + std::to_string(y) + ", " +
           std::to_string(z) + ")\"\n" + rest;
}

void diffuse(const std::string& folder, int side) {
    const Case c{"diffuse, 20 steps, " + std::to_string(side * side * side) + " catoms", folder + "/temperature.meld",
                 box("cubic", side, side, side), 1.02};
    const auto start = [](sim::Catom a) { return 100 * noise(a); };
    const auto prepare = [&](Run& run) {
        for (sim::Catom a = 0; a < run.subdomain().ensemble.index_count(); ++a)
            give(run, "temperature", a, {Value{.integer = 0}, Value{.real = start(a)}});
    };
    const auto hand = [&](Run& run) {
        std::vector<double> now(run.subdomain().ensemble.index_count());
        for (sim::Catom a = 0; a < now.size(); ++a) now[a] = start(a);
        return hand_diffuse(run.subdomain().geometry(), std::move(now), 20, 0.0625);
    };
    measure(c, prepare, hand, [](Run& run, const std::vector<double>& made) {
        for (sim::Catom a = 0; a < made.size(); ++a)
            same("temperature", a, fact(run, predicate(run, "temperature", 2), a)[1].real, made[a]);
    });
}

void pagerank(const std::string& folder, int side, double enough) {
    char setting[64];
    std::snprintf(setting, sizeof setting, "[set]\nenough = %g\n", enough);
    char what[64];
    std::snprintf(what, sizeof what, "PageRank, %d catoms, to %g", side * side * side, enough);
    const Case c{what, folder + "/pagerank_async.meld", box("cubic", side, side, side, setting)};
    measure(
        c, [](Run&) {},
        [&](Run& run) { return hand_pagerank(run.subdomain().geometry(), run.subdomain().ensemble.index_count(), 0.85, enough); },
        [&](Run& run, const Ranks& made) {
            for (sim::Catom a = 0; a < made.rank.size(); ++a) {
                same("rank", a, fact(run, predicate(run, "rank", 1), a)[0].real, made.rank[a]);
                same("residue", a, fact(run, predicate(run, "residue", 1), a)[0].real, made.residue[a]);
            }
        });
}

void beliefs(const std::string& folder, int side) {
    const Case c{"belief propagation, 12 rounds, " + std::to_string(side * side) + " catoms", folder + "/belief_propagation.meld",
                 box("square", side, side, 1)};
    // Stripes of three colours; one pixel in ten is another.
    const auto seen = [&](Run& run, sim::Catom a) {
        const auto stripe = static_cast<int>(3 * (run.subdomain().ensemble.position(a)[0] + side / 2.0) / side);
        return noise(a) < 0.1 ? static_cast<int>(noise(a) * 30) : std::min(2, std::max(0, stripe));
    };
    const auto prepare = [&](Run& run) {
        for (sim::Catom a = 0; a < run.subdomain().ensemble.index_count(); ++a) give(run, "seen", a, {Value{.integer = seen(run, a)}});
    };
    const auto hand = [&](Run& run) {
        std::vector<int> colours(run.subdomain().ensemble.index_count());
        for (sim::Catom a = 0; a < colours.size(); ++a) colours[a] = seen(run, a);
        return hand_beliefs(run.subdomain().geometry(), colours, 12, 1.6, 1.2);
    };
    measure(c, prepare, hand, [](Run& run, const std::vector<Belief>& made) {
        for (sim::Catom a = 0; a < made.size(); ++a) {
            const List* belief = fact(run, predicate(run, "belief", 1), a)[0].list;
            for (std::size_t i = 0; i < 3; ++i) same("belief", a, tuple::item(belief, i).real, made[a][i]);
        }
    });
}

// Stripes of five colours with noise, as a camera sees them.
void residual_beliefs(const std::string& folder, int side) {
    const Case c{"belief propagation by residuals, " + std::to_string(side * side) + " catoms", folder + "/residual_beliefs.meld",
                 box("square", side, side, 1)};
    const auto potential = [&](Run& run, sim::Catom a) {
        const double stripe = std::floor(5 * (run.subdomain().ensemble.position(a)[0] + side / 2.0) / side);
        const double seen = stripe + 3 * (noise(a) + noise(a + 1000000) - 1);
        Belief5 out;
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = -(static_cast<double>(i) - seen) * (static_cast<double>(i) - seen) / 2;
        return out;
    };
    const auto prepare = [&](Run& run) {
        tuple::Arena arena;
        for (sim::Catom a = 0; a < run.subdomain().ensemble.index_count(); ++a) {
            std::vector<std::uint64_t> items;
            for (const double likelihood : potential(run, a)) items.push_back(std::bit_cast<std::uint64_t>(likelihood));
            give(run, "potential", a, {Value{.list = arena.list(items)}});
        }
    };
    const auto hand = [&](Run& run) {
        std::vector<Belief5> given(run.subdomain().ensemble.index_count());
        for (sim::Catom a = 0; a < given.size(); ++a) given[a] = potential(run, a);
        return hand_residual_beliefs(run.subdomain().geometry(), given, -2, 0.1, 0.0001);
    };
    measure(c, prepare, hand, [](Run& run, const std::vector<Belief5>& made) {
        for (sim::Catom a = 0; a < made.size(); ++a) {
            const List* belief = fact(run, predicate(run, "belief", 1), a)[0].list;
            for (std::size_t i = 0; i < 5; ++i) same("belief", a, tuple::item(belief, i).real, made[a][i]);
        }
    });
}

void queens(const std::string& folder, int n) {
    const Case c{std::to_string(n) + " queens", folder + "/queens.meld",
                 box("square", n, 1, 1, "[set]\ncolumns = " + std::to_string(n) + "\n[limits]\nmax_derivations_per_tick = 1000000000\n"),
                 0.43};
    const auto end = [](Run& run, bool first) {
        sim::Catom found = 0;
        const sim::Subdomain& subdomain = run.subdomain();
        for (sim::Catom a = 1; a < subdomain.ensemble.index_count(); ++a)
            if ((subdomain.ensemble.position(a)[0] < subdomain.ensemble.position(found)[0]) == first) found = a;
        return found;
    };
    const auto prepare = [&](Run& run) { give(run, "placed", end(run, true), {Value{.list = nullptr}}); };
    const auto hand = [&](Run&) {
        std::vector<int> columns(static_cast<std::size_t>(n));
        return hand_queens(n, columns.data(), 0);
    };
    measure(c, prepare, hand, [&](Run& run, std::int64_t made) {
        const sim::Catom last = end(run, false);
        const std::int64_t ours = fact(run, predicate(run, "ways", 1), last)[0].integer;
        if (ours != made) differs("ways", last, static_cast<double>(ours), static_cast<double>(made));
    });
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: bench_programs EXAMPLES PROGRAMS [small]\n");
        return 2;
    }
    machine_line();
    const std::string folder = argv[1];
    const bool small = argc > 3;
    diffuse(folder, small ? 8 : 40);
    pagerank(folder, small ? 8 : 40, 0.01);
    pagerank(folder, small ? 8 : 40, 0.0001);
    beliefs(folder, small ? 12 : 100);
    residual_beliefs(argv[2], small ? 12 : 100);
    queens(folder, small ? 6 : 12);
    return 0;
}
