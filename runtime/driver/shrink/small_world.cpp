#include "runtime/driver/shrink/small_world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string_view>

#include "runtime/world/graph/write.h"

namespace meld::driver {

namespace {

using RegionChange = std::function<std::optional<std::string>(const std::string&)>;

constexpr std::size_t kMostColumns = 100;

std::string toml_text(const toml::node& node) {
    std::ostringstream text;
    text << toml::node_view<const toml::node>(node);
    return text.str();
}

// On a line of its own, whatever it was in the file.
std::string item_text(const toml::node& node) {
    if (!node.is_table()) return toml_text(node);
    toml::table table = *node.as_table();
    table.is_inline(true);
    return toml_text(table);
}

// NAME = [a, b, ...], in lines of a readable length.
std::string list(std::string_view name, const std::vector<std::string>& items) {
    std::string text = fmt::format("{} = [", name), line;
    if (name.size() + fmt::format("{}", fmt::join(items, ", ")).size() + 5 <= kMostColumns)
        return text + fmt::format("{}]\n", fmt::join(items, ", "));
    for (const std::string& item : items) {
        if (line.size() + item.size() + 2 > kMostColumns) text += "\n   " + line, line.clear();
        line += " " + item + ",";
    }
    return text + "\n   " + line + "\n]\n";
}

void change_string(toml::table& table, std::string_view key, const RegionChange& change) {
    const toml::node* node = table.get(key);
    if (node == nullptr || !node->is_string()) return;
    if (const auto text = change(**node->as_string())) table.insert_or_assign(key, *text);
}

// A fact: a region, or a table with one, or an array of these.
void change_facts(toml::table& facts, const RegionChange& change) {
    std::vector<std::string> names;
    for (const auto& [name, value] : facts) names.emplace_back(name.str());
    for (const std::string& name : names) {
        toml::node& value = *facts.get(name);
        if (toml::table* one = value.as_table()) change_string(*one, "where", change);
        toml::array* all = value.as_array();
        if (all == nullptr) change_string(facts, name, change);
        for (std::size_t i = 0; all != nullptr && i < all->size(); ++i) {
            if (toml::table* one = all->get(i)->as_table()) change_string(*one, "where", change);
            if (!all->get(i)->is_string()) continue;
            if (const auto text = change(**all->get(i)->as_string())) all->replace(all->cbegin() + static_cast<std::ptrdiff_t>(i), *text);
        }
    }
}

// A table, or each of several.
void change_where(toml::node* tables, const RegionChange& change) {
    if (tables == nullptr) return;
    if (toml::table* one = tables->as_table()) change_string(*one, "where", change);
    if (toml::array* all = tables->as_array())
        for (toml::node& each : *all)
            if (toml::table* one = each.as_table()) change_string(*one, "where", change);
}

// What happens at a time, as one [[event]].
std::string event_text(const std::vector<const Happening*>& together) {
    const Happening& first = *together.front();
    std::string text = fmt::format("\n[[event]]\ntick = {}\n", first.tick);
    if (first.every > 0) text += fmt::format("every = {}\ntimes = {}\n", first.every, first.times);
    std::vector<std::string> keys;
    std::map<std::string, std::vector<std::string>> items;
    for (const Happening* each : together) {
        const std::string key =
            each->predicate.empty() ? each->key : fmt::format("{}.{}", each->key, toml_text(toml::value(each->predicate)));
        if (!items.contains(key)) keys.push_back(key);
        items[key].push_back(item_text(*each->item.get(0)));
    }
    for (const std::string& key : keys) text += list(key, items[key]);
    return text;
}

std::string events_text(const std::vector<Happening>& events) {
    const auto together = [](const Happening& a, const Happening& b) {
        return a.source == b.source && a.tick == b.tick && a.every == b.every && a.times == b.times;
    };
    std::string text;
    for (auto at = events.begin(); at != events.end();) {
        std::vector<const Happening*> group;
        const Happening& first = *at;
        for (; at != events.end() && together(*at, first); ++at) group.push_back(&*at);
        text += event_text(group);
    }
    return text;
}

std::string cell_text(const world::Cell& cell) { return fmt::format("[{}, {}, {}]", cell.x, cell.y, cell.z); }

// Bodies at positions, in their order: those that say nothing of their sizes here, others in files.
std::string placed_text(const std::vector<world::PlacedCatom>& placed, const std::string& name, WorldTexts& texts) {
    const auto alike = [](const world::PlacedCatom& a, const world::PlacedCatom& b) {
        return a.radius.has_value() == b.radius.has_value() && a.mass.has_value() == b.mass.has_value();
    };
    std::string text;
    for (auto at = placed.begin(); at != placed.end();) {
        const auto end = std::find_if_not(at, placed.end(), [&, &first = *at](const auto& each) { return alike(first, each); });
        text += "\n[[body]]\n";
        if (!at->radius && !at->mass) {
            std::vector<std::string> points;
            for (; at != end; ++at) points.push_back(fmt::format("[{}]", fmt::join(at->position, ", ")));
            text += list("positions", points);
            continue;
        }
        const std::string ending = fmt::format(".positions-{}.csv", texts.beside.size() + 1);
        std::string& lines = texts.beside[ending];
        lines = fmt::format("x,y,z{}{}\n", at->radius ? ",radius" : "", at->mass ? ",mass" : "");
        for (; at != end; ++at) {
            lines += fmt::format("{}", fmt::join(at->position, ","));
            for (const std::optional<double>& size : {at->radius, at->mass})
                if (size) lines += fmt::format(",{}", *size);
            lines += "\n";
        }
        text += fmt::format("positions = {}\n", toml_text(toml::value(name + ending)));
    }
    return text;
}

using WriteList = Result<void> (*)(const graph::Graph&, const graph::Put&);
Result<std::string> written(const graph::Graph& graph, WriteList write) {
    std::string text;
    const Result<void> done = write(graph, [&](std::string_view line) { text += line; });
    if (!done) return tl::unexpected<Error>(done.error());
    return text;
}

// Keys at the top that say which graph it is, and the files that they name.
Result<std::string> graph_list_text(const GraphList& list_of, const std::string& name, WorldTexts& texts) {
    const graph::Graph graph = graph::part(*list_of.whole, list_of.nodes, list_of.links);
    std::string text;
    if (graph.directed) text += "directed = true\n";
    if (list_of.as_files) {
        for (const auto& [key, write] : {std::pair<const char*, WriteList>("links", graph::write_links), {"nodes", graph::write_nodes}}) {
            Result<std::string> lines = written(graph, write);
            if (!lines) return lines;
            const std::string ending = fmt::format(".{}.csv", key);
            texts.beside[ending] = std::move(*lines);
            text += fmt::format("{} = {}\n", key, toml_text(toml::value(name + ending)));
        }
        return text;
    }
    std::vector<std::string> numbers, links;
    for (graph::Node node = 0; node < graph.nodes(); ++node) numbers.push_back(std::to_string(graph.id(node)));
    for (const graph::Entry& link : graph::entries(graph))
        links.push_back(fmt::format("[{}, {}]", graph.id(link.node), graph.id(graph.to[link.at])));
    return text + list("nodes", numbers) + list("links", links);
}

bool is_section(const toml::node& node) { return node.is_table() || node.is_array_of_tables(); }

}  // namespace

std::string region_of(const std::vector<world::Cell>& cells) {
    std::vector<std::string> tests;
    for (const world::Cell& cell : cells) tests.push_back(fmt::format("cell == ({}, {}, {})", cell.x, cell.y, cell.z));
    return tests.empty() ? "!all" : fmt::format("{}", fmt::join(tests, " || "));
}

void change_regions(toml::table& keys, const RegionChange& change) {
    if (toml::table* facts = keys["facts"].as_table()) change_facts(*facts, change);
    for (const char* name : {"program", "faults"}) change_where(keys.get(name), change);
    for (const auto& [section, name] : {std::pair("network", "region"), std::pair("motion", "catoms")})
        if (toml::table* table = keys[section].as_table()) change_where(table->get(name), change);
}

void change_regions(Happening& happening, const RegionChange& change) {
    toml::array& item = happening.item;
    if (item.get(0)->is_string())
        if (const auto text = change(**item.get(0)->as_string())) item.replace(item.cbegin(), *text);
    toml::table* table = item.get(0)->as_table();
    if (table == nullptr) return;
    change_string(*table, "where", change);
    toml::array* between = (*table)["between"].as_array();
    for (std::size_t i = 0; between != nullptr && i < between->size(); ++i)
        if (between->get(i)->is_string())
            if (const auto text = change(**between->get(i)->as_string()))
                between->replace(between->cbegin() + static_cast<std::ptrdiff_t>(i), *text);
}

Result<WorldTexts> texts_of(const SmallWorld& world, const std::string& name) {
    WorldTexts texts;
    toml::table top, sections = world.keys;
    // Of what is left of them.
    std::set<world::Cell> there;
    if (world.cells) there.insert(world.cells->begin(), world.cells->end());
    const RegionChange change = [&](const std::string& region) -> std::optional<std::string> {
        const auto found = world.cells_of_regions.find(region);
        if (found == world.cells_of_regions.end()) return std::nullopt;
        std::vector<world::Cell> left;
        for (const world::Cell& cell : found->second)
            if (there.contains(cell)) left.push_back(cell);
        return region_of(left);
    };
    change_regions(sections, change);
    for (const auto& [key, value] : world.keys)
        if (!is_section(value)) {
            value.visit([&, name_of = key.str()](const auto& typed) { top.insert(name_of, typed); });
            sections.erase(key.str());
        }
    texts.world = top.empty() ? "" : toml_text(top) + "\n";
    if (world.graph) {
        const Result<std::string> keys = graph_list_text(*world.graph, name, texts);
        if (!keys) return tl::unexpected<Error>(keys.error());
        texts.world += *keys;
    }
    if (!sections.empty()) texts.world += "\n" + toml_text(sections) + "\n";
    if (world.cells && !world.cells->empty()) {
        std::vector<std::string> cells;
        for (const world::Cell& cell : *world.cells) cells.push_back(cell_text(cell));
        texts.world += "\n[[body]]\n" + list("cells", cells);
    }
    texts.world += placed_text(world.placed, name, texts);
    if (!world.events) return texts;
    std::vector<Happening> events = *world.events;
    // Where catoms move, others may have come to stand there.
    for (Happening& each : events)
        if (world.still) change_regions(each, change);
    texts.world += events_text(events);
    return texts;
}

}  // namespace meld::driver
