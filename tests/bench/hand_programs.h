// The programs of bench_programs as a person would write them in C++ for one machine: dense arrays, neighbours by geometry,
// no messages. Each does the same rounds or the same steps as the Meld program, so that results can be compared.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "runtime/module/abi/geometry_abi.h"

namespace meld::bench {

// Calls visit(neighbour) for each neighbour of a catom, by port.
template <class Visit>
void each_neighbour(const Geometry& g, u32 catom, const Visit& visit) {
    each_link(g, catom, [&](i32, u32 other) { visit(other); });
}

// examples/meld/gradient.meld with one source: links from it, or -1. A search in breadth.
inline std::vector<i32> hand_gradient(const Geometry& g, std::size_t catoms, u32 source) {
    std::vector<i32> distance(catoms, -1);
    std::vector<u32> queue = {source};
    queue.reserve(catoms);
    distance[source] = 0;
    for (std::size_t next = 0; next < queue.size(); ++next) {
        const u32 c = queue[next];
        each_neighbour(g, c, [&](u32 b) {
            if (distance[b] >= 0) return;
            distance[b] = distance[c] + 1;
            queue.push_back(b);
        });
    }
    return distance;
}

// The least catom of each connected component, by union-find with halving of paths.
inline std::vector<u32> hand_components(const Geometry& g, std::size_t catoms) {
    std::vector<u32> parent(catoms);
    for (u32 c = 0; c < catoms; ++c) parent[c] = c;
    const auto root = [&](u32 c) {
        while (parent[c] != c) c = parent[c] = parent[parent[c]];
        return c;
    };
    for (u32 c = 0; c < catoms; ++c)
        each_neighbour(g, c, [&](u32 b) {
            const u32 x = root(c), y = root(b);
            (x < y ? parent[y] : parent[x]) = std::min(x, y);
        });
    for (u32 c = 0; c < catoms; ++c) parent[c] = root(c);
    return parent;
}

// examples/meld/temperature.meld: each round a catom moves towards its neighbours by `rate` of each difference.
inline std::vector<double> hand_diffuse(const Geometry& g, std::vector<double> now, int rounds, double rate) {
    std::vector<double> next(now.size());
    for (int round = 0; round < rounds; ++round) {
        for (u32 c = 0; c < now.size(); ++c) {
            double sum = 0;
            each_neighbour(g, c, [&](u32 b) { sum += now[b] - now[c]; });
            next[c] = now[c] + rate * sum;
        }
        now.swap(next);
    }
    return now;
}

// The same by the steps of tests/bench/graphs/components.meld: in each round, nodes whose label has changed tell their neighbours.
inline std::vector<u32> hand_labels(const Geometry& g, std::size_t catoms) {
    std::vector<u32> label(catoms), changed(catoms), next;
    std::vector<u8> noted(catoms, 0);
    for (u32 c = 0; c < catoms; ++c) label[c] = changed[c] = c;
    while (!changed.empty()) {
        for (const u32 c : changed) noted[c] = 0;
        const std::vector<u32> told = label;
        for (const u32 c : changed)
            each_neighbour(g, c, [&](u32 b) {
                if (told[c] >= label[b]) return;
                label[b] = told[c];
                if (!noted[b]) next.push_back(b);
                noted[b] = 1;
            });
        changed.swap(next);
        next.clear();
    }
    return label;
}

struct Ranks {
    std::vector<double> rank, residue;
};

// examples/meld/pagerank_async.meld: a catom passes on what it has received when that is more than `enough`; only catoms
// that received something are looked at.
inline Ranks hand_pagerank(const Geometry& g, std::size_t catoms, double damping, double enough) {
    Ranks out{std::vector<double>(catoms, 0.0), std::vector<double>(catoms, 1 - damping)};
    std::vector<double> gain(catoms, 0.0), next(catoms, 0.0);
    std::vector<u32> awake(catoms), woken;
    std::vector<u8> is_woken(catoms, 0);
    for (u32 c = 0; c < catoms; ++c) awake[c] = c;
    while (!awake.empty()) {
        for (const u32 c : awake) {
            out.residue[c] += gain[c];
            gain[c] = 0;
            if (out.residue[c] <= enough) continue;
            int degree = 0;
            each_neighbour(g, c, [&](u32) { ++degree; });
            if (degree == 0) continue;
            const double share = damping * out.residue[c] / degree;
            out.rank[c] += out.residue[c];
            out.residue[c] = 0;
            each_neighbour(g, c, [&](u32 b) {
                next[b] += share;
                if (is_woken[b]) return;
                is_woken[b] = 1;
                woken.push_back(b);
            });
        }
        for (const u32 c : woken) {
            is_woken[c] = 0;
            gain[c] = next[c];
            next[c] = 0;
        }
        awake.swap(woken);
        woken.clear();
    }
    return out;
}

// ---- examples/meld/belief_propagation.meld

// Logarithms of likelihoods, one for each colour.
template <std::size_t N>
using Beliefs = std::array<double, N>;
using Belief = Beliefs<3>;

template <std::size_t N>
Beliefs<N> normalized(const Beliefs<N>& b) {
    const double most = *std::max_element(b.begin(), b.end());
    double all = 0;
    for (const double x : b) all += std::exp(x - most);
    const double shift = most + std::log(all);
    Beliefs<N> out;
    for (std::size_t i = 0; i < N; ++i) out[i] = b[i] - shift;
    return out;
}

// What a neighbour hears from one who believes this. potential(x, y): of a link between these colours.
template <std::size_t N, class Potential>
Beliefs<N> said(const Beliefs<N>& b, const Potential& potential) {
    Beliefs<N> out{};
    for (std::size_t x = 0; x < N; ++x) {
        double all = 0;
        for (std::size_t y = 0; y < N; ++y) all += std::exp(b[y] + potential(x, y));
        out[x] = std::log(all);
    }
    return normalized(out);
}

// Each catom sees a colour; in each round it tells every neighbour what it believes without what it heard from that one.
inline std::vector<Belief> hand_beliefs(const Geometry& g, const std::vector<int>& seen, int rounds, double doubt, double rough) {
    const auto catoms = static_cast<u32>(seen.size());
    const auto ports = static_cast<std::size_t>(g.ports);
    const auto slot = [&](u32 catom, i32 port) { return catom * ports + static_cast<std::size_t>(port); };
    std::vector<Belief> heard(catoms * ports), next(catoms * ports), belief(catoms);
    const auto smooth = [&](std::size_t x, std::size_t y) { return x == y ? 0.0 : -rough; };
    const auto evidence = [&](u32 c) {
        Belief b{};
        for (std::size_t i = 0; i < 3; ++i) b[i] = static_cast<int>(i) == seen[c] ? 0.0 : -doubt;
        return b;
    };
    const auto sum = [&](u32 c) {
        Belief all = evidence(c);
        for (i32 port = 0; port < g.ports; ++port)
            if (catom_towards(g, g.catom_site[c], port) >= 0)
                for (std::size_t i = 0; i < 3; ++i) all[i] += heard[slot(c, port)][i];
        return all;
    };
    for (int round = 0; round < rounds; ++round) {
        for (u32 c = 0; c < catoms; ++c) {
            const Belief all = round == 0 ? evidence(c) : sum(c);
            for (i32 port = 0; port < g.ports; ++port) {
                const i32 other = catom_towards(g, g.catom_site[c], port);
                if (other < 0) continue;
                Belief without = all;
                if (round > 0)
                    for (std::size_t i = 0; i < 3; ++i) without[i] -= heard[slot(c, port)][i];
                next[slot(static_cast<u32>(other), g.opposite[port])] = said(without, smooth);
            }
        }
        heard.swap(next);
    }
    for (u32 c = 0; c < catoms; ++c) belief[c] = normalized(sum(c));
    return belief;
}

// ---- tests/bench/programs/residual_beliefs.meld

using Belief5 = Beliefs<5>;

// A catom tells its neighbours what it believes without what it heard from them. It does so again in the round after one that changed
// what it heard from a neighbour by more than `bound`. `step`: the potential of a link, for each step between two colours.
inline std::vector<Belief5> hand_residual_beliefs(const Geometry& g, const std::vector<Belief5>& evidence, double step, double damping,
                                                  double bound) {
    const auto catoms = static_cast<u32>(evidence.size());
    const auto ports = static_cast<std::size_t>(g.ports);
    const auto slot = [&](u32 catom, i32 port) { return catom * ports + static_cast<std::size_t>(port); };
    const auto stepwise = [&](std::size_t x, std::size_t y) { return step * std::fabs(static_cast<double>(x) - static_cast<double>(y)); };
    Belief5 even;
    even.fill(std::log(0.2));
    std::vector<Belief5> belief(catoms, even), heard(catoms * ports, even), next = heard;
    std::vector<u32> due(catoms), later;
    std::vector<bool> is_due(catoms);
    for (u32 c = 0; c < catoms; ++c) due[c] = c;
    while (!due.empty()) {
        for (const u32 c : due) {
            Belief5 all = evidence[c];
            each_link(g, c, [&](i32 port, u32) {
                for (std::size_t i = 0; i < all.size(); ++i) all[i] += heard[slot(c, port)][i];
            });
            all = belief[c] = normalized(all);
            each_link(g, c, [&](i32 port, u32 other) {
                Belief5 without;
                for (std::size_t i = 0; i < all.size(); ++i) without[i] = all[i] - heard[slot(c, port)][i];
                Belief5 now = said(normalized(without), stepwise);
                Belief5& before = next[slot(other, g.opposite[port])];
                double changed = 0;
                for (std::size_t i = 0; i < all.size(); ++i) {
                    now[i] = std::log(damping * std::exp(before[i]) + (1 - damping) * std::exp(now[i]));
                    changed += std::fabs(std::exp(now[i]) - std::exp(before[i]));
                }
                before = now;
                if (changed / static_cast<double>(all.size()) > bound && !is_due[other]) {
                    is_due[other] = true;
                    later.push_back(other);
                }
            });
        }
        // What was said in this round is heard in the next.
        for (const u32 c : due)
            each_link(g, c, [&](i32 port, u32 other) {
                const std::size_t at = slot(other, g.opposite[port]);
                heard[at] = next[at];
            });
        due.swap(later);
        later.clear();
        for (const u32 c : due) is_due[c] = false;
    }
    return belief;
}

// ---- examples/meld/queens.meld: how many ways there are to place one queen a row so that none takes another.
inline std::int64_t hand_queens(int n, int* columns, int row) {
    if (row == n) return 1;
    std::int64_t found = 0;
    for (int column = 0; column < n; ++column) {
        bool safe = true;
        for (int above = 0; above < row && safe; ++above) {
            const int apart = columns[above] - column;
            safe = apart != 0 && apart != row - above && apart != above - row;
        }
        if (!safe) continue;
        columns[row] = column;
        found += hand_queens(n, columns, row + 1);
    }
    return found;
}

}  // namespace meld::bench
