// The node-link form of networkx: {"directed": ..., "nodes": [{"id": ...}], "links": [{"source": ..., "target": ...}]}.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "runtime/base/shallow_json.h"
#include "runtime/world/graph/fields.h"
#include "runtime/world/graph/files.h"

namespace meld::graph {
namespace {

using Json = nlohmann::json;

// Nodes that are tuples of tuples, far deeper than anybody has.
constexpr int kMaxDepth = 100;

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

// Where the text ceases to be JSON, from 0.
std::size_t mistake_in(std::string_view text) {
    // The library's parser reports places only by an exception.
    try {
        const Json whole = Json::parse(text);
        return whole.is_discarded() ? 0 : text.size();
    } catch (const Json::parse_error& error) {
        return std::min(text.size(), error.byte == 0 ? 0 : error.byte - 1);
    }
}

// Python writes numbers that JSON does not have: NaN, Infinity and -Infinity.
tl::unexpected<Error> no_json(const FileText& file) {
    const std::string_view text = file.text;
    const std::size_t at = mistake_in(text);
    const auto place = [&](std::size_t here) {
        const std::size_t line = static_cast<std::size_t>(std::ranges::count(text.substr(0, here), '\n')) + 1;
        const std::size_t begin = here == 0 ? std::string_view::npos : text.rfind('\n', here - 1);
        return fmt::format("{}:{}:{}", file.path, line, begin == std::string_view::npos ? here + 1 : here - begin);
    };
    for (const std::string_view number : {"NaN", "-Infinity", "Infinity"}) {
        const std::size_t begin = number.starts_with('-') && at > 0 ? at - 1 : at;
        if (!text.substr(begin).starts_with(number) || (begin == at && at > 0 && text[at - 1] == '-')) continue;
        // "weight": NaN
        const std::string_view before = trimmed(text.substr(0, begin));
        const std::size_t close = before.ends_with(':') ? before.rfind('"') : std::string_view::npos;
        const std::size_t open = close == std::string_view::npos || close == 0 ? std::string_view::npos : before.rfind('"', close - 1);
        const std::string what =
            open == std::string_view::npos ? "a value" : fmt::format("\"{}\"", before.substr(open + 1, close - open - 1));
        return fail(fmt::format("{}: {} is {}, which is no number of JSON", place(begin), what, number),
                    "give it a number, or take this attribute out of the graph, and write it again: "
                    "json.dump(networkx.node_link_data(G), file, allow_nan=False) refuses such values");
    }
    if (at >= text.size()) return fail(place(text.size()) + ": this is no JSON: it ends too early", "the file is cut off: write it again");
    return fail(place(at) + ": this is no JSON", "write it with json.dump(networkx.node_link_data(G), file)");
}

class NodeLinkReader {
  public:
    explicit NodeLinkReader(const FileText& file) { table_.path = file.path, table_.has_lines = false; }

    Result<Table> read(const Json& json) {
        const Json none = Json::array();
        const Json& nodes = json.contains("nodes") ? json["nodes"] : none;
        // Its name has changed between versions.
        const Json& links = json.contains("links") ? json["links"] : json.contains("edges") ? json["edges"] : none;
        if (!json.is_object() || !nodes.is_array() || !links.is_array() || nodes.empty())
            return fail(table_.path + " is no graph in node-link form", "write it with networkx.node_link_data");
        if (json.contains("directed") && json["directed"].is_boolean()) table_.directed = json["directed"].get<bool>();
        words_ = std::ranges::any_of(nodes, [](const Json& node) { return !node.contains("id") || !node["id"].is_number_unsigned(); });
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (auto done = add_node(nodes[i], i); !done) return tl::unexpected<Error>(done.error());
        for (std::size_t i = 0; i < links.size(); ++i)
            if (auto done = add_link(links[i], i); !done) return tl::unexpected<Error>(done.error());
        table_.nodes_listed = true;
        for (ColumnReader& column : node_columns_) table_.node_columns.push_back(column.take());
        for (ColumnReader& column : link_columns_) table_.columns.push_back(column.take());
        return std::move(table_);
    }

  private:
    Result<void> add_node(const Json& node, std::size_t i) {
        if (!node.is_object() || !node.contains("id")) return fail(fmt::format("{}: node {} has no id", table_.path, i));
        const std::size_t known = words_ ? table_.names.all().size() : numbers_.size();
        if (!words_ && node["id"].get<std::uint64_t>() > kMaxNumber)
            return fail(fmt::format("{}: the id of node {}, {}, is too large", table_.path, i, text_of(node["id"])), "number nodes from 0");
        const std::uint64_t number = words_ ? table_.names.number_of(text_of(node["id"])) : node["id"].get<std::uint64_t>();
        numbers_.emplace(number, i);
        if ((words_ ? table_.names.all().size() : numbers_.size()) == known)
            return fail(fmt::format("{}: node {} is listed twice", table_.path, text_of(node["id"])), "take one of them out");
        table_.nodes.push_back(number);
        return add_columns(node, {"id"}, node_columns_, fmt::format("node {}", i), i == 0);
    }

    Result<void> add_link(const Json& link, std::size_t i) {
        std::uint64_t ends[2] = {};
        for (int k = 0; k < 2; ++k) {
            const char* const key = k == 0 ? "source" : "target";
            if (!link.is_object() || !link.contains(key)) return fail(fmt::format("{}: link {} has no {}", table_.path, i, key));
            const Json& end = link[key];
            const auto number = words_                     ? table_.names.find(text_of(end))
                                : end.is_number_unsigned() ? std::optional(end.get<std::uint64_t>())
                                                           : std::nullopt;
            if (!number || !numbers_.contains(*number))
                return fail(fmt::format("{}: the {} of link {} is {}, which is no node", table_.path, key, i, text_of(end)));
            ends[k] = *number;
        }
        table_.add(ends[0], ends[1], i);
        return add_columns(link, {"source", "target", "key"}, link_columns_, fmt::format("link {}", i), i == 0);
    }

    // The columns are those of the first; others must have the same.
    Result<void> add_columns(const Json& item, std::initializer_list<std::string_view> ends, std::vector<ColumnReader>& columns,
                             const std::string& what, bool first) {
        std::size_t at = 0;
        std::vector<std::string>& names = ends.size() == 1 ? node_names_ : link_names_;
        for (const auto& [key, value] : item.items()) {
            if (std::ranges::find(ends, key) != ends.end()) continue;
            if (value.is_structured()) return fail(fmt::format("{}: {} of {} is neither a number nor a string", table_.path, key, what));
            if (first) names.push_back(key), columns.emplace_back(key);
            if (at >= names.size() || names[at] != key) break;
            columns[at++].add(text_of(value));
        }
        if (at == names.size() && item.size() == at + (ends.size() == 1 ? 1 : item.contains("key") ? 3 : 2)) return {};
        return fail(fmt::format("{}: {} has other attributes than the first one", table_.path, what), "give each the same attributes");
    }

    Table table_;
    bool words_ = false;
    std::map<std::uint64_t, std::size_t> numbers_;
    std::vector<std::string> node_names_, link_names_;
    std::vector<ColumnReader> node_columns_, link_columns_;
};

}  // namespace

Result<Table> read_node_link(const FileText& file) {
    const std::optional<Json> json = parse_shallow<Json>(file.text, kMaxDepth);
    if (!json) return fail(fmt::format("{} is nested more than {} levels deep", file.path, kMaxDepth));
    if (json->is_discarded()) return no_json(file);
    return NodeLinkReader(file).read(*json);
}

}  // namespace meld::graph
