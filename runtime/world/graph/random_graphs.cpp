#include <algorithm>
#include <cmath>

#include "runtime/base/assert.h"
#include "runtime/world/graph/generators.h"
#include "runtime/world/graph/link_set.h"

namespace meld::graph {
namespace {

constexpr int kMaxTries = 100;

// The pairs (a, b) with b < a in order: (1, 0), (2, 0), (2, 1), ... Returns whether there is one that far ahead.
bool advance(Node n, Node& a, std::uint64_t& b, double pairs) {
    // Beyond all pairs that there are.
    if (pairs > 0.5 * static_cast<double>(n) * n) return false;
    b += static_cast<std::uint64_t>(pairs);
    while (a < n && b >= a) b -= a++;
    return a < n;
}

// A pairing of all ends, some of whose links are loops or doubled; these exchange ends with links chosen at random until none is left.
std::optional<Links> pair_ends(Node n, Node d, Draws& draws) {
    std::vector<Node> ends(std::size_t{n} * d);
    for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = static_cast<Node>(i / d);
    for (std::size_t i = ends.size(); i > 1; --i) std::swap(ends[i - 1], ends[draws.below(i)]);
    Links links;
    links.reserve(ends.size() / 2);
    LinkSet known(ends.size() / 2);
    std::vector<Link> wrong;
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
        const Link link{ends[i], ends[i + 1]};
        if (link.from != link.to && known.insert(link.from, link.to))
            links.push_back(link);
        else
            wrong.push_back(link);
    }
    const std::size_t limit = std::size_t{kMaxTries} * (wrong.size() + 10);
    for (std::size_t tries = 0; !wrong.empty() && !links.empty(); ++tries) {
        if (tries > limit) return std::nullopt;
        const Link bad = wrong.back();
        Link& other = links[draws.below(links.size())];
        const Link one{bad.from, other.from}, two{bad.to, other.to};
        const bool fine = one.from != one.to && two.from != two.to && !known.contains(one.from, one.to) &&
                          !known.contains(two.from, two.to) && !(std::minmax(one.from, one.to) == std::minmax(two.from, two.to));
        if (!fine) continue;
        wrong.pop_back();
        known.erase(other.from, other.to);
        known.insert(one.from, one.to);
        known.insert(two.from, two.to);
        other = one;
        links.push_back(two);
    }
    return wrong.empty() ? std::optional(std::move(links)) : std::nullopt;
}

Links complement(Node n, const Links& links) {
    LinkSet known(links.size());
    for (const Link& link : links) known.insert(link.from, link.to);
    Links out;
    for (Node i = 0; i < n; ++i)
        for (Node k = i + 1; k < n; ++k)
            if (!known.contains(i, k)) out.push_back({i, k});
    return out;
}

}  // namespace

Links random(Node n, double p, Draws draws) {
    if (p >= 1) return complete(n);
    Links out;
    if (p <= 0 || n < 2) return out;
    out.reserve(static_cast<std::size_t>(0.5 * static_cast<double>(n) * n * p * 1.01));
    const double log_without = std::log1p(-p);
    // The number of pairs left out before the next link has a geometric distribution.
    const auto skipped = [&] { return std::floor(std::log1p(-draws.unit()) / log_without); };
    Node a = 1;
    std::uint64_t b = 0;
    for (bool more = advance(n, a, b, skipped()); more; more = advance(n, a, b, 1 + skipped())) out.push_back({static_cast<Node>(b), a});
    return out;
}

std::optional<Links> regular(Node n, Node d, Draws draws) {
    MELD_EXPECT(d < n && std::uint64_t{n} * d % 2 == 0, "{} nodes of degree {}", n, d);
    if (d == 0) return Links();
    // In a dense graph nearly every exchange would be refused.
    const bool dense = d > (n - 1) / 2;
    if (dense && d == n - 1) return complete(n);
    for (int tries = 0; tries < kMaxTries; ++tries) {
        const std::optional<Links> links = pair_ends(n, dense ? n - 1 - d : d, draws);
        if (links) return dense ? complement(n, *links) : *links;
    }
    return std::nullopt;
}

Links geometric(Node n, double r, Draws draws, std::vector<Point>& places) {
    places.resize(n);
    for (Point& place : places) place = {draws.unit(), draws.unit()};
    Links out;
    if (n == 0) return out;
    // Squares at least as wide as r, but no more of them than nodes.
    const double most = std::max(1.0, std::floor(std::sqrt(static_cast<double>(n))));
    const auto side = static_cast<Node>(r > 0 ? std::clamp(std::floor(1 / r), 1.0, most) : most);
    const auto square = [&](double x) { return std::min(static_cast<Node>(x * side), side - 1); };
    std::vector<Node> first(std::size_t{side} * side + 1), inside(n);
    const auto of = [&](const Point& place) { return std::size_t{square(place[1])} * side + square(place[0]); };
    for (const Point& place : places) ++first[of(place) + 1];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    std::vector<Node> next(first.begin(), first.end() - 1);
    for (Node node = 0; node < n; ++node) inside[next[of(places[node])]++] = node;
    for (Node node = 0; node < n; ++node) {
        const Point here = places[node];
        const Node x = square(here[0]), y = square(here[1]);
        for (Node row = y > 0 ? y - 1 : 0; row <= std::min(y + 1, side - 1); ++row) {
            const std::size_t begin = first[std::size_t{row} * side + (x > 0 ? x - 1 : 0)];
            const std::size_t end = first[std::size_t{row} * side + std::min(x + 1, side - 1) + 1];
            for (std::size_t at = begin; at < end; ++at) {
                const Node other = inside[at];
                if (other <= node) continue;
                const double dx = places[other][0] - here[0], dy = places[other][1] - here[1];
                if (dx * dx + dy * dy <= r * r) out.push_back({node, other});
            }
        }
    }
    return out;
}

std::vector<Point> points_in_box(Node n, const Point& sides, Draws draws) {
    std::vector<Point> places(n);
    for (Point& place : places)
        for (std::size_t i = 0; i < 3; ++i) place[i] = sides[i] > 0 ? sides[i] * (draws.unit() - 0.5) : 0;
    return places;
}

std::vector<Point> points_in_ball(Node n, double radius, std::size_t dimensions, Draws draws) {
    std::vector<Point> places(n);
    for (Point& place : places) {
        // Of the box around it, drawn again while outside: no function of the library decides about the bits.
        double square = 2;
        while (square > 1) {
            square = 0;
            for (std::size_t i = 0; i < dimensions; ++i) {
                place[i] = 2 * draws.unit() - 1;
                square += place[i] * place[i];
            }
        }
        for (double& x : place) x *= radius;
    }
    return places;
}

Links scale_free(Node n, Node m, Draws draws) {
    MELD_EXPECT(m >= 1 && m < n, "{} links of each of {} nodes", m, n);
    Links out;
    out.reserve(std::size_t{n - m} * m);
    for (Node i = 1; i <= m; ++i) out.push_back({0, i});
    std::vector<Node> chosen(m);
    for (Node node = m + 1; node < n; ++node) {
        const std::size_t ends = 2 * out.size();
        for (Node k = 0; k < m;) {
            // An end of any link: each node as often as it has links.
            const std::size_t end = draws.below(ends);
            const Node other = end % 2 == 0 ? out[end / 2].from : out[end / 2].to;
            if (std::find(chosen.begin(), chosen.begin() + k, other) != chosen.begin() + k) continue;
            chosen[k++] = other;
        }
        for (const Node other : chosen) out.push_back({other, node});
    }
    return out;
}

Links small_world(Node n, Node k, double p, Draws draws) {
    MELD_EXPECT(k < n && k % 2 == 0, "{} nodes, {} neighbours", n, k);
    Links out;
    out.reserve(std::size_t{n} * (k / 2));
    for (Node step = 1; step <= k / 2; ++step)
        for (Node node = 0; node < n; ++node) out.push_back({node, node + step < n ? node + step : node + step - n});
    if (p <= 0) return out;
    LinkSet known(out.size());
    for (const Link& link : out) known.insert(link.from, link.to);
    std::vector<Node> degree(n, k);
    for (Link& link : out) {
        if (draws.unit() >= p || degree[link.from] >= n - 1) continue;
        Node other = link.from;
        while (other == link.from || known.contains(link.from, other)) other = static_cast<Node>(draws.below(n));
        known.erase(link.from, link.to);
        known.insert(link.from, other);
        --degree[link.to];
        ++degree[other];
        link.to = other;
    }
    return out;
}

}  // namespace meld::graph
