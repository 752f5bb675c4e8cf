#include "runtime/world/graph/layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/base/hash.h"

namespace meld::graph {
namespace {

constexpr double kApart = 2;
constexpr double kTurn = 2 * std::numbers::pi;

Point at_angle(double radius, double turn) { return {radius * std::cos(kTurn * turn), radius * std::sin(kTurn * turn)}; }

double radius_for(Node n) { return n < 2 ? 0 : kApart * n / kTurn; }

// In [-0.5, 0.5), always the same for a number.
double jitter(std::uint64_t number) { return static_cast<double>(mix64(number) >> 11) * 0x1p-53 - 0.5; }

// ---- by distances

constexpr std::size_t kMaxPivots = 16, kFewPivots = 6;
constexpr std::uint64_t kLarge = 300'000;
// Steps of the power iteration; the picture needs no more digits.
constexpr int kSteps = 60;

using Distances = std::vector<std::vector<float>>;  // By pivot and place in the component.

// The nodes of each component, one after the other, and for each node its place in the list.
struct Pieces {
    std::vector<Node> nodes;
    std::vector<std::size_t> first;
};

Pieces pieces_of(const Graph& graph) {
    Pieces out;
    std::vector<bool> seen(graph.nodes());
    for (Node start = 0; start < graph.nodes(); ++start) {
        if (seen[start]) continue;
        seen[start] = true;
        out.first.push_back(out.nodes.size());
        out.nodes.push_back(start);
        for (std::size_t at = out.first.back(); at < out.nodes.size(); ++at)
            for (const Node other : graph.neighbours(out.nodes[at]))
                if (!seen[other]) {
                    seen[other] = true;
                    out.nodes.push_back(other);
                }
    }
    out.first.push_back(out.nodes.size());
    return out;
}

class Embedding {
  public:
    explicit Embedding(const Graph& graph)
        : graph_(graph), level_(graph.nodes(), kFar), pivots_(graph.nodes() > kLarge ? kFewPivots : kMaxPivots) {}

    // Places for the nodes of a component, around its middle.
    std::vector<Point> place(std::span<const Node> nodes) {
        const Distances distances = measure(nodes);
        std::vector<double> means(distances.size());
        for (std::size_t p = 0; p < distances.size(); ++p) {
            for (const float d : distances[p]) means[p] += d;
            means[p] /= static_cast<double>(nodes.size());
        }
        const std::vector<double> spread = covariance(distances, means);
        const std::vector<double> first = axis(spread, {}), second = axis(spread, first);
        std::vector<Point> out(nodes.size());
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            for (std::size_t p = 0; p < distances.size(); ++p) {
                const double away = distances[p][i] - means[p];
                out[i][0] += away * first[p];
                out[i][1] += away * second[p];
            }
        }
        scale(nodes, out);
        return out;
    }

  private:
    static constexpr std::uint32_t kFar = ~std::uint32_t{0};

    // Distances from nodes each of which is as far as possible from those before.
    Distances measure(std::span<const Node> nodes) {
        Distances out;
        std::vector<float> nearest(nodes.size(), std::numeric_limits<float>::max());
        Node from = nodes[0];
        for (std::size_t p = 0; p < std::min(pivots_, nodes.size()); ++p) {
            search(from, nodes);
            std::vector<float>& row = out.emplace_back(nodes.size());
            std::size_t farthest = 0;
            for (std::size_t i = 0; i < nodes.size(); ++i) {
                row[i] = static_cast<float>(level_[nodes[i]]);
                nearest[i] = std::min(nearest[i], row[i]);
                if (nearest[i] > nearest[farthest]) farthest = i;
            }
            if (nearest[farthest] == 0) break;
            from = nodes[farthest];
        }
        return out;
    }

    void search(Node from, std::span<const Node> nodes) {
        for (const Node node : nodes) level_[node] = kFar;
        queue_.assign(1, from);
        level_[from] = 0;
        for (std::size_t at = 0; at < queue_.size(); ++at)
            for (const Node other : graph_.neighbours(queue_[at]))
                if (level_[other] == kFar) {
                    level_[other] = level_[queue_[at]] + 1;
                    queue_.push_back(other);
                }
    }

    static std::vector<double> covariance(const Distances& distances, const std::vector<double>& means) {
        const std::size_t n = distances.size();
        std::vector<double> out(n * n);
        for (std::size_t a = 0; a < n; ++a)
            for (std::size_t b = 0; b <= a; ++b) {
                double sum = 0;
                for (std::size_t i = 0; i < distances[a].size(); ++i) sum += (distances[a][i] - means[a]) * (distances[b][i] - means[b]);
                out[a * n + b] = out[b * n + a] = sum;
            }
        return out;
    }

    // The direction of the greatest spread at a right angle to another one, by power iteration.
    static std::vector<double> axis(const std::vector<double>& spread, const std::vector<double>& other) {
        const auto n = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(spread.size()))));
        std::vector<double> out(n), next(n);
        for (std::size_t i = 0; i < n; ++i) out[i] = 1 + jitter(i + 1);
        for (int step = 0; step < kSteps; ++step) {
            double along = 0;
            for (std::size_t i = 0; i < other.size(); ++i) along += out[i] * other[i];
            for (std::size_t i = 0; i < other.size(); ++i) out[i] -= along * other[i];
            double length = 0;
            for (const double x : out) length += x * x;
            length = std::sqrt(length);
            if (length < 1e-9) return std::vector<double>(n);
            for (double& x : out) x /= length;
            if (step + 1 == kSteps) break;
            for (std::size_t i = 0; i < n; ++i) {
                next[i] = 0;
                for (std::size_t k = 0; k < n; ++k) next[i] += spread[i * n + k] * out[k];
            }
            std::swap(out, next);
        }
        return out;
    }

    // To an area that has room for all; nodes at the same place move a little apart.
    static void scale(std::span<const Node> nodes, std::vector<Point>& places) {
        double square = 0;
        for (const Point& place : places) square += place[0] * place[0] + place[1] * place[1];
        const double mean = std::sqrt(square / static_cast<double>(places.size()));
        const double wanted = kApart * std::sqrt(static_cast<double>(nodes.size())) / 2;
        for (std::size_t i = 0; i < places.size(); ++i)
            for (std::size_t k = 0; k < 2; ++k) {
                const double shift = nodes.size() > 1 ? kApart * 1.5 * jitter(2 * std::uint64_t{nodes[i]} + k) : 0;
                places[i][k] = (mean > 0 ? places[i][k] * (wanted / mean) : 0) + shift;
            }
    }

    const Graph& graph_;
    std::vector<std::uint32_t> level_;
    std::vector<Node> queue_;
    std::size_t pivots_;
};

}  // namespace

std::vector<Point> on_circle(Node n) {
    std::vector<Point> out(n);
    for (Node i = 0; i < n; ++i) out[i] = at_angle(radius_for(n), static_cast<double>(i) / n);
    return out;
}

std::vector<Point> around_first(Node n) {
    std::vector<Point> out(n);
    for (Node i = 1; i < n; ++i) out[i] = at_angle(std::max(kApart, radius_for(n - 1)), static_cast<double>(i - 1) / (n - 1));
    return out;
}

std::vector<Point> on_grid(Node n, Node width, Node height) {
    std::vector<Point> out(n);
    for (Node i = 0; i < n; ++i) {
        const Node x = i % width, y = i / width % height, z = i / width / height;
        out[i] = {kApart * (x + static_cast<double>(z) * (width + 1)), kApart * y};
    }
    return out;
}

std::vector<Point> in_levels(Node n, Node children) {
    std::vector<Point> out(n);
    // The last level that is full decides the width.
    std::vector<std::pair<std::uint64_t, std::uint64_t>> levels;  // First node and size.
    for (std::uint64_t first = 0, size = 1; first < n; first += size, size *= children) levels.emplace_back(first, size);
    const double width = kApart * static_cast<double>(std::min<std::uint64_t>(levels.back().second, n));
    for (std::size_t level = 0; level < levels.size(); ++level) {
        const auto [first, size] = levels[level];
        for (std::uint64_t i = first; i < std::min<std::uint64_t>(first + size, n); ++i)
            out[i] = {width * ((static_cast<double>(i - first) + 0.5) / static_cast<double>(size) - 0.5),
                      -kApart * static_cast<double>(level) * std::max(1.0, width / 20 / static_cast<double>(levels.size()))};
    }
    return out;
}

std::vector<Point> spread(std::vector<Point> places) {
    const double side = kApart * std::sqrt(static_cast<double>(places.size()));
    for (Point& place : places) place = {place[0] * side, place[1] * side};
    return places;
}

std::vector<Point> by_distances(const Graph& graph) {
    std::vector<Point> out(graph.nodes());
    const Pieces pieces = pieces_of(graph);
    Embedding embedding(graph);
    // The components stand in rows, as on a page.
    const double page = 1.5 * kApart * std::sqrt(static_cast<double>(graph.nodes()));
    double left = 0, below = 0, row_height = 0;
    for (std::size_t piece = 0; piece + 1 < pieces.first.size(); ++piece) {
        const std::span<const Node> nodes(pieces.nodes.data() + pieces.first[piece], pieces.first[piece + 1] - pieces.first[piece]);
        const std::vector<Point> places = embedding.place(nodes);
        Point low = places[0], high = places[0];
        for (const Point& place : places)
            for (std::size_t k = 0; k < 2; ++k) low[k] = std::min(low[k], place[k]), high[k] = std::max(high[k], place[k]);
        if (left > 0 && left + high[0] - low[0] > page) left = 0, below -= row_height, row_height = 0;
        for (std::size_t i = 0; i < nodes.size(); ++i) out[nodes[i]] = {places[i][0] - low[0] + left, places[i][1] - high[1] + below};
        left += high[0] - low[0] + kApart;
        row_height = std::max(row_height, high[1] - low[1] + kApart);
    }
    return out;
}

}  // namespace meld::graph
