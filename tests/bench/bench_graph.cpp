// Programs on graphs beside the same by hand in C++ (hand_programs.h) on the same table of links in the same run, checked to give
// the same. CPU seconds from a loaded world to quiet, the median of three runs where these are short, and bytes a link.
// Usage: bench_graph EXAMPLES GRAPHS [small] [graph ...]
#include <chrono>
#include <cmath>
#include <cstring>

#include "tests/bench/hand_programs.h"
#include "tests/bench/measure.h"

namespace {

using namespace meld;
using namespace meld::bench;

[[noreturn]] void differs(const char* what, sim::Catom node, double ours, double hand) {
    std::fprintf(stderr, "%s of node %u: %.17g by the program, %.17g by hand\n", what, node, ours, hand);
    std::exit(70);
}

// The argument of the fact of a predicate that a node holds; `none` if it holds none.
Value argument_of(Run& run, const char* name, std::size_t arity, sim::Catom node, Value none) {
    const std::uint32_t id = *tuple::find_predicate(run.info(), name, arity);
    sim::Subdomain& subdomain = run.subdomain();
    Value out = none;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), id, node, [&](const Value* v) { out = v[0]; });
    return out;
}

// Some runs of both; check(run, what hand made) compares the last.
template <class Hand, class Check>
void measure(const std::string& what, const std::string& program, const std::string& graph, const std::string& rest, int runs,
             const Hand& hand, const Check& check) {
    std::vector<double> seconds, by_hand;
    for (int repeat = 0; repeat < runs; ++repeat) {
        Run run(program, "lattice = \"graph\"\nseed = 5\ngraph = \"" + graph + "\"\n" + rest);
        seconds.push_back(run.settle());
        run.subdomain().refresh();
        const double before = cpu_now();
        const auto made = hand(run);
        by_hand.push_back(cpu_now() - before);
        if (repeat + 1 < runs) continue;
        check(run, made);
        const Geometry& g = run.subdomain().geometry();
        double ends = 0;
        const std::size_t nodes = run.subdomain().ensemble.owned_count();
        for (u32 node = 0; node < nodes; ++node) each_neighbour(g, node, [&](u32) { ++ends; });
        const double ours = median(seconds), theirs = median(by_hand);
        std::printf(
            "%-22s %-24s %9zu nodes %10.0f links  %8.3f s  by hand %8.4f s  ratio %5.1f  %5.0f bytes a node, %4.0f a link  %5lld ticks\n",
            what.c_str(), graph.c_str(), nodes, ends / 2, ours, theirs, ours / theirs,
            static_cast<double>(run.subdomain().bytes()) / static_cast<double>(nodes),
            static_cast<double>(run.subdomain().bytes()) / (ends / 2), static_cast<long long>(run.simulation->summary().ticks));
        std::fflush(stdout);
    }
}

void breadth_first(const std::string& examples, const std::string& graph) {
    measure(
        "breadth", examples + "/gradient.meld", graph, "[facts]\nsource = \"id == 0\"\n", 3,
        [](Run& run) { return hand_gradient(run.subdomain().geometry(), run.subdomain().ensemble.index_count(), 0); },
        [](Run& run, const std::vector<i32>& made) {
            for (sim::Catom node = 0; node < made.size(); ++node) {
                const i64 ours = argument_of(run, "dist", 1, node, Value{.integer = -1}).integer;
                if (ours != made[node]) differs("distance", node, static_cast<double>(ours), made[node]);
            }
        });
}

using Components = std::vector<u32> (*)(const Geometry&, std::size_t);

void components(const std::string& graphs, const std::string& graph, const char* how, Components by_hand) {
    measure(
        std::string("components, ") + how, graphs + "/components.meld", graph, "", 3,
        [&](Run& run) { return by_hand(run.subdomain().geometry(), run.subdomain().ensemble.index_count()); },
        [](Run& run, const std::vector<u32>& made) {
            for (sim::Catom node = 0; node < made.size(); ++node) {
                const i64 ours = argument_of(run, "label", 1, node, Value{.integer = -1}).integer;
                if (ours != made[node]) differs("component", node, static_cast<double>(ours), made[node]);
            }
        });
}

void pagerank(const std::string& examples, const std::string& graph, double enough) {
    char setting[64];
    std::snprintf(setting, sizeof setting, "[set]\nenough = %g\n", enough);
    measure(
        "PageRank", examples + "/pagerank_async.meld", graph, setting, 1,
        [&](Run& run) { return hand_pagerank(run.subdomain().geometry(), run.subdomain().ensemble.index_count(), 0.85, enough); },
        [](Run& run, const Ranks& made) {
            for (sim::Catom node = 0; node < made.rank.size(); ++node) {
                const double ours = argument_of(run, "rank", 1, node, Value{.real = NAN}).real;
                // Sums are made in another order by hand.
                if (!(std::fabs(ours - made.rank[node]) <= 1e-9 * (1 + made.rank[node]))) differs("rank", node, ours, made.rank[node]);
            }
        });
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: bench_graph EXAMPLES GRAPHS [small] [graph ...]\n");
        return 2;
    }
    machine_line();
    const bool small = argc > 3 && std::strcmp(argv[3], "small") == 0;
    std::vector<std::string> graphs(argv + 3 + small, argv + argc);
    if (graphs.empty() && small) graphs = {"scale_free(500, 4)", "geometric(400, 0.08)"};
    // Eight links a node, as in the other.
    if (graphs.empty()) graphs = {"scale_free(1000000, 8)", "geometric(1000000, 0.00226)"};
    for (const std::string& graph : graphs) {
        breadth_first(argv[1], graph);
        components(argv[2], graph, "union-find", hand_components);
        components(argv[2], graph, "labels", hand_labels);
        pagerank(argv[1], graph, 0.01);
    }
    return 0;
}
