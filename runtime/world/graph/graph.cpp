// Rows of neighbours from a list of links, by two passes that need no sorting.
#include "runtime/world/graph/graph.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/base/release_memory.h"

namespace meld::graph {
namespace {

template <class T>
std::uint64_t hash_array(const std::vector<T>& array, std::uint64_t seed) {
    return hash_bytes(std::as_bytes(std::span(array)), seed);
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

std::string literal(double number) {
    const std::string text = fmt::format("{}", number);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

struct Entries {
    std::vector<std::uint64_t> first;
    std::vector<Node> to;
    std::vector<Row> row;
};

// The entries of links by node, in the order listed. The row of a directed link is noted at its far end, for transposed().
Entries by_node(std::uint64_t nodes, const std::vector<Link>& links, bool directed, bool keep_rows) {
    Entries out{.first = std::vector<std::uint64_t>(nodes + 1), .to = {}, .row = {}};
    for (const Link& link : links) {
        if (link.from == link.to) continue;
        ++out.first[link.from + 1];
        ++out.first[link.to + 1];
    }
    for (std::uint64_t n = 0; n < nodes; ++n) out.first[n + 1] += out.first[n];
    out.to.resize(out.first[nodes]);
    if (keep_rows) out.row.resize(out.to.size());
    std::vector<std::uint64_t> next(out.first.begin(), out.first.end() - 1);
    for (std::size_t i = 0; i < links.size(); ++i) {
        const Link& link = links[i];
        if (link.from == link.to) continue;
        const std::uint64_t there = next[link.from]++, back = next[link.to]++;
        out.to[there] = link.to;
        out.to[back] = link.from;
        if (!keep_rows) continue;
        out.row[there] = directed ? kNoRow : static_cast<Row>(i);
        out.row[back] = static_cast<Row>(i);
    }
    return out;
}

// Each entry at its other end. As the nodes are visited in order, the entries of each node come out in ascending order.
Entries transposed(const Entries& in) {
    const std::uint64_t nodes = in.first.size() - 1;
    Entries out{.first = in.first, .to = std::vector<Node>(in.to.size()), .row = std::vector<Row>(in.row.size())};
    std::vector<std::uint64_t> next(in.first.begin(), in.first.end() - 1);
    for (Node node = 0; node < nodes; ++node)
        for (std::uint64_t at = in.first[node]; at < in.first[node + 1]; ++at) {
            const std::uint64_t place = next[in.to[at]]++;
            out.to[place] = node;
            if (!in.row.empty()) out.row[place] = in.row[at];
        }
    return out;
}

// Makes one entry of equal ones, with the earliest row that lists it.
void merge(Entries& entries, const std::vector<Column>& columns, bool directed, Made& made) {
    std::uint64_t out = 0;
    const std::uint64_t nodes = entries.first.size() - 1;
    const auto take = [&](Row kept, Row again) {
        ++made.doubled;
        made.first_doubled = std::min(made.first_doubled, again);
        for (std::size_t c = 0; c < columns.size(); ++c) {
            if (columns[c].same(kept, again)) continue;
            if (!made.conflict || again < made.conflict->second) made.conflict = {kept, again, c};
            return;
        }
    };
    for (Node node = 0; node < nodes; ++node) {
        const std::uint64_t begin = entries.first[node], end = entries.first[node + 1];
        entries.first[node] = out;
        for (std::uint64_t at = begin; at < end;) {
            const Node to = entries.to[at];
            std::uint64_t same = at;
            Row kept = kNoRow;
            for (; same < end && entries.to[same] == to; ++same)
                if (!entries.row.empty()) kept = std::min(kept, entries.row[same]);
            // An undirected link is seen from both of its ends.
            for (std::uint64_t other = at; !entries.row.empty() && (directed || node < to) && other < same; ++other)
                if (entries.row[other] != kNoRow && entries.row[other] != kept) take(kept, entries.row[other]);
            if (entries.row.empty() && node < to) made.doubled += same - at - 1;
            entries.to[out] = to;
            if (!entries.row.empty()) entries.row[out] = kept;
            ++out;
            at = same;
        }
    }
    entries.first[nodes] = out;
    entries.to.resize(out);
    if (!entries.row.empty()) entries.row.resize(out);
}

}  // namespace

std::string Column::text(std::size_t row) const {
    if (const auto* integers = std::get_if<0>(&values)) return fmt::format("{}", (*integers)[row]);
    if (const auto* numbers = std::get_if<1>(&values)) return literal((*numbers)[row]);
    return quoted(std::get<2>(values)[row]);
}

bool Column::same(std::size_t a, std::size_t b) const {
    return std::visit([&](const auto& all) { return all[a] == all[b]; }, values);
}

std::size_t Column::size() const {
    return std::visit([](const auto& all) { return all.size(); }, values);
}

std::optional<Node> Graph::find(std::uint64_t id) const {
    if (ids.empty()) return id < nodes() ? std::optional(static_cast<Node>(id)) : std::nullopt;
    const auto at = std::lower_bound(ids.begin(), ids.end(), id);
    return at != ids.end() && *at == id ? std::optional(static_cast<Node>(at - ids.begin())) : std::nullopt;
}

std::uint64_t Graph::hash() const {
    std::uint64_t hash = hash_array(row, hash_array(to, hash_array(first, directed ? 2 : 1)));
    hash = hash_array(places, hash_array(ids, hash));
    for (const auto* all : {&columns, &node_columns})
        for (const Column& column : *all) {
            hash = hash_text(column.name, hash);
            if (const auto* words = std::get_if<2>(&column.values))
                for (const std::string& word : *words) hash = hash_text(word, hash);
            else if (const auto* integers = std::get_if<0>(&column.values))
                hash = hash_array(*integers, hash);
            else
                hash = hash_array(std::get<1>(column.values), hash);
        }
    return hash;
}

Made make(std::uint64_t nodes, std::vector<Link> links, bool directed, std::vector<Column> columns) {
    MELD_EXPECT(nodes <= kMaxNodes && links.size() < kNoRow, "{} nodes, {} links", nodes, links.size());
    Made made;
    for (std::size_t i = 0; i < links.size(); ++i) {
        MELD_EXPECT(links[i].from < nodes && links[i].to < nodes, "link {} of {} nodes", i, nodes);
        if (links[i].from != links[i].to) continue;
        ++made.loops;
        made.first_loop = std::min(made.first_loop, static_cast<Row>(i));
    }
    const bool keep_rows = directed || !columns.empty();
    Entries entries = by_node(nodes, links, directed, keep_rows);
    release_memory(links);
    entries = transposed(entries);
    merge(entries, columns, directed, made);
    made.graph.directed = directed;
    made.graph.first = std::move(entries.first);
    made.graph.to = std::move(entries.to);
    made.graph.row = std::move(entries.row);
    made.graph.columns = std::move(columns);
    return made;
}

std::uint64_t components(const Graph& graph) {
    std::vector<bool> seen(graph.nodes());
    std::vector<Node> left;
    std::uint64_t count = 0;
    for (Node start = 0; start < graph.nodes(); ++start) {
        if (seen[start]) continue;
        ++count;
        seen[start] = true;
        left.push_back(start);
        while (!left.empty()) {
            const Node node = left.back();
            left.pop_back();
            for (const Node other : graph.neighbours(node))
                if (!seen[other]) {
                    seen[other] = true;
                    left.push_back(other);
                }
        }
    }
    return count;
}

Degrees degrees(const Graph& graph) {
    if (graph.nodes() == 0) return {};
    Degrees out{.least = graph.degree(0),
                .most = graph.degree(0),
                .mean = static_cast<double>(graph.to.size()) / static_cast<double>(graph.nodes())};
    for (Node node = 0; node < graph.nodes(); ++node) {
        out.least = std::min(out.least, graph.degree(node));
        out.most = std::max(out.most, graph.degree(node));
    }
    return out;
}

}  // namespace meld::graph
