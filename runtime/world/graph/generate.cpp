// Reading "name(arguments)", and checking that they make a graph.
#include "runtime/world/graph/generate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/units.h"
#include "runtime/world/graph/fields.h"
#include "runtime/world/graph/generators.h"
#include "runtime/world/graph/layout.h"
#include "runtime/world/graph/memory_check.h"

namespace meld::graph {
namespace {

// Whole numbers of one side of the graph's arguments, so that no product overflows.
constexpr double kMaxArgument = 2e9;

struct Call {
    const GeneratorInfo* info = nullptr;
    std::vector<double> arguments;
    std::string text;

    Node whole(std::size_t i, double missing = 1) const { return static_cast<Node>(i < arguments.size() ? arguments[i] : missing); }
};

std::string written(const GeneratorInfo& info) { return fmt::format("{}({})", info.name, info.arguments); }

Result<Call> parse(std::string_view text) {
    const std::size_t open = text.find('(');
    const std::string_view name = trimmed(text.substr(0, open));
    std::vector<std::string_view> names;
    Call call;
    call.text = trimmed(text);
    for (const GeneratorInfo& info : generators()) {
        names.push_back(info.name);
        if (info.name == name) call.info = &info;
    }
    if (call.info == nullptr) return fail(fmt::format("there is no graph '{}'", name), did_you_mean(name, names));
    const std::string cure = "write " + written(*call.info);
    if (open == std::string_view::npos || trimmed(text).back() != ')')
        return fail(fmt::format("the graph '{}' has no arguments in parentheses", trimmed(text)), cure);
    std::string_view rest = trimmed(text).substr(open - text.find_first_not_of(" \t") + 1);
    rest.remove_suffix(1);
    const auto needed = static_cast<std::size_t>(std::ranges::count(call.info->arguments, ',')) + 1;
    while (!trimmed(rest).empty()) {
        const std::size_t end = std::min(rest.find(','), rest.size());
        const Result<double> number = parse_number(rest.substr(0, end));
        if (!number) return fail(number.error().problem, number.error().suggestion);
        call.arguments.push_back(*number);
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    const std::size_t most = name == "grid" || name == "torus" ? 3 : name == "scatter" ? 4 : needed;
    if (call.arguments.size() < needed || call.arguments.size() > most)
        return fail(fmt::format("{} has {} argument{}, here are {}", name, needed, needed == 1 ? "" : "s", call.arguments.size()), cure);
    return call;
}

// Points without links.
bool are_points(std::string_view name) { return name == "scatter" || name == "disc" || name == "ball"; }

// The arguments that are probabilities or lengths.
bool is_real(const Call& call, std::size_t i) {
    const std::string_view name = call.info->name;
    return ((name == "random" || name == "geometric") && i == 1) || (are_points(name) && i > 0) || (name == "small_world" && i == 2);
}

Result<void> check_numbers(const Call& call) {
    for (std::size_t i = 0; i < call.arguments.size(); ++i) {
        const double value = call.arguments[i];
        if (is_real(call, i)) {
            if (!(value >= 0)) return fail(fmt::format("{} is below 0 in {}", value, call.text));
            if (!std::isfinite(value)) return fail(fmt::format("{} is no length in {}", value, call.text));
            if (value > 1 && call.info->name != "geometric" && !are_points(call.info->name))
                return fail(fmt::format("{} is no probability in {}", value, call.text), "write a number from 0 to 1");
        } else if (std::trunc(value) != value || value < (i == 0 ? 1 : 0) || value > kMaxArgument) {
            return fail(fmt::format("{} is not a whole number of at least {} in {}", value, i == 0 ? 1 : 0, call.text),
                        "write " + written(*call.info));
        }
    }
    return {};
}

// How many nodes and links the graph has, about.
std::pair<double, double> size_of(const Call& call) {
    const std::string_view name = call.info->name;
    const std::vector<double>& a = call.arguments;
    if (name == "complete") return {a[0], a[0] * (a[0] - 1) / 2};
    if (name == "grid" || name == "torus") {
        const double n = a[0] * a[1] * (a.size() > 2 ? a[2] : 1);
        return {n, n * static_cast<double>(a.size())};
    }
    if (name == "hypercube") return {std::exp2(a[0]), std::exp2(a[0]) * a[0] / 2};
    if (name == "random") return {a[0], a[0] * (a[0] - 1) / 2 * a[1]};
    if (name == "regular") return {a[0], a[0] * a[1] / 2};
    if (name == "geometric") return {a[0], a[0] * a[0] / 2 * std::min(1.0, 3.15 * a[1] * a[1])};
    if (are_points(name)) return {a[0], 0};
    if (name == "scale_free") return {a[0], a[0] * a[1]};
    if (name == "small_world") return {a[0], a[0] * a[1] / 2};
    return {a[0], a[0]};
}

Result<void> check_meaning(const Call& call) {
    const std::string_view name = call.info->name;
    const std::vector<double>& a = call.arguments;
    const auto [nodes, links] = size_of(call);
    if (nodes > static_cast<double>(kMaxNodes) || links > kMaxLinks)
        return fail(fmt::format("{} has {} nodes and about {} links, and a graph has at most {} and {}", call.text, format_count(nodes),
                                format_count(links), format_count(static_cast<double>(kMaxNodes)), format_count(kMaxLinks)),
                    "make it smaller");
    if (name == "regular" && a[1] >= a[0]) return fail(fmt::format("no node of {} has {} neighbours", a[0], a[1]), "make d less than n");
    if (name == "regular" && std::fmod(a[0] * a[1], 2) != 0)
        return fail(fmt::format("there is no graph of {} nodes with {} links each: every link has two ends", a[0], a[1]),
                    "make one of the two even");
    if (name == "tree" && a[1] < 1) return fail("in this tree no node has a child", "make k at least 1");
    if ((name == "grid" || name == "torus") && std::ranges::any_of(a, [](double side) { return side < 1; }))
        return fail(fmt::format("a side of {} has no nodes", call.text), "make each side at least 1");
    if (name == "scale_free" && (a[1] < 1 || a[1] >= a[0]))
        return fail(fmt::format("in {} a new node cannot have {} links with earlier ones", call.text, a[1]),
                    "make m at least 1 and less than n");
    if (name == "small_world" && (a[1] >= a[0] || std::fmod(a[1], 2) != 0))
        return fail(fmt::format("in {} a node cannot be linked with the nearest {}, half of them on each side", call.text, a[1]),
                    "make k even and less than n");
    return {};
}

// Of the generators that look links up as they make them: the link, and at most half of the entries of a table of 8 bytes each; `regular`
// also has a list of ends.
double making_link(std::string_view name) { return name == "regular" ? 32 : name == "small_world" ? 24 : kMaking_link; }

Result<Links> links_of(const Call& call, std::uint64_t seed, std::vector<Point>& places) {
    const std::string_view name = call.info->name;
    const std::vector<double>& a = call.arguments;
    const Draws draws(seed, 0);
    if (name == "scatter") return places = points_in_box(call.whole(0), {a[1], a[2], a.size() > 3 ? a[3] : 0}, draws), Links();
    if (name == "disc" || name == "ball") return places = points_in_ball(call.whole(0), a[1], name == "disc" ? 2 : 3, draws), Links();
    if (name == "line") return line(call.whole(0));
    if (name == "ring") return ring(call.whole(0));
    if (name == "star") return star(call.whole(0));
    if (name == "complete") return complete(call.whole(0));
    if (name == "grid" || name == "torus") return grid(call.whole(0), call.whole(1), call.whole(2), name == "torus");
    if (name == "hypercube") return hypercube(static_cast<int>(call.arguments[0]));
    if (name == "tree") return tree(call.whole(0), call.whole(1));
    if (name == "random") return random(call.whole(0), call.arguments[1], draws);
    if (name == "geometric") return geometric(call.whole(0), call.arguments[1], draws, places);
    if (name == "scale_free") return scale_free(call.whole(0), call.whole(1), draws);
    if (name == "small_world") return small_world(call.whole(0), call.whole(1), call.arguments[2], draws);
    std::optional<Links> found = regular(call.whole(0), call.whole(1), draws);
    if (!found) return fail(fmt::format("no graph {} was found by this seed", call.text), "try another seed");
    return std::move(*found);
}

void place(const Call& call, Graph& graph, std::vector<Point>&& random_places) {
    const std::string_view name = call.info->name;
    const auto n = static_cast<Node>(graph.nodes());
    if (are_points(name))
        graph.places = std::move(random_places);
    else if (name == "geometric")
        graph.places = spread(std::move(random_places));
    else if (name == "line")
        graph.places = on_grid(n, n, 1);
    else if (name == "ring" || name == "complete" || name == "small_world")
        graph.places = on_circle(n);
    else if (name == "star")
        graph.places = around_first(n);
    else if (name == "grid" || name == "torus")
        graph.places = on_grid(n, call.whole(0), call.whole(1));
    else if (name == "tree")
        graph.places = in_levels(n, call.whole(1));
}

}  // namespace

const std::vector<GeneratorInfo>& generators() {
    static const std::vector<GeneratorInfo> all = {
        {"line", "n", "n nodes in a row"},
        {"ring", "n", "n nodes in a circle"},
        {"star", "n", "node 0, linked with the n - 1 others"},
        {"complete", "n", "n nodes, each linked with all others"},
        {"grid", "w, h", "w times h nodes, also grid(w, h, d); node x + w (y + h z) is at (x, y, z)"},
        {"torus", "w, h", "a grid whose opposite sides are linked, also torus(w, h, d)"},
        {"hypercube", "d", "2^d nodes; those whose numbers differ in one bit are linked"},
        {"tree", "n, k", "n nodes; node i is a child of (i - 1) / k"},
        {"random", "n, p", "n nodes; each pair is linked with probability p"},
        {"regular", "n, d", "n nodes with d links each, at random"},
        {"geometric", "n, r", "n points of the unit square, linked up to the distance r"},
        {"scatter", "n, w, h", "n random points of a rectangle w times h, also scatter(n, w, h, d); without links, for [links] range"},
        {"disc", "n, r", "n random points of a disc with radius r; without links"},
        {"ball", "n, r", "n random points of a ball with radius r; without links"},
        {"scale_free", "n, m", "n nodes; each new one is linked with m earlier ones, rather with those that have many links"},
        {"small_world", "n, k, p", "a ring with links to the nearest k nodes, each of which leads elsewhere with probability p"},
    };
    return all;
}

bool makes_points(std::string_view text) {
    const Result<Call> call = parse(text);
    return !call || are_points(call->info->name);
}

Result<Graph> generate(std::string_view text, std::uint64_t seed, const MemoryLimit& room) {
    const Result<Call> call = parse(text);
    if (!call) return tl::unexpected<Error>(call.error());
    if (const auto fine = check_numbers(*call); !fine) return tl::unexpected<Error>(fine.error());
    if (const auto fine = check_meaning(*call); !fine) return tl::unexpected<Error>(fine.error());
    const auto [nodes, about_links] = size_of(*call);
    const double need_bytes = kMaking_node * nodes + making_link(call->info->name) * about_links;
    if (const auto fits = check_memory(call->text, nodes, about_links, need_bytes, room); !fits) return tl::unexpected<Error>(fits.error());
    std::vector<Point> places;
    Result<Links> links = links_of(*call, seed, places);
    if (!links) return tl::unexpected<Error>(links.error());
    Graph graph = make(static_cast<std::uint64_t>(nodes), std::move(*links)).graph;
    place(*call, graph, std::move(places));
    return graph;
}

}  // namespace meld::graph
