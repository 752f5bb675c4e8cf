// A world of which parts can be taken away: its catoms, links and events as lists, and all else as it is written.
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/description/world.h"
#include "runtime/world/graph/part.h"

namespace meld::driver {

// One thing that happens to one target: a catom, a link, a region of them, or a fact.
struct Happening {
    std::int64_t tick = 0, every = 0, times = 1;
    std::size_t source = 0;  // Those of one [[event]] have the same.
    std::string key;         // "kill", "cut", "give", ...
    std::string predicate = {};
    toml::array item = {};  // As it is written: an array with one element.
    // The nodes that it joins, which must be there.
    std::optional<std::pair<std::uint64_t, std::uint64_t>> joins = {};
};

// Nodes and links of a graph that are left of it.
struct GraphList {
    std::shared_ptr<const graph::Graph> whole;
    std::vector<graph::Node> nodes;  // Ascending.
    std::vector<graph::Entry> links;
    // Nodes and links have columns, or regions ask for places: they are written as files.
    bool as_files = false;
};

struct SmallWorld {
    toml::table keys;
    std::optional<GraphList> graph = {};
    std::optional<std::vector<world::Cell>> cells = {};
    std::vector<world::PlacedCatom> placed = {};  // With cells: bodies at positions of their own.
    std::optional<std::vector<Happening>> events = {};
    // What regions that name catoms by number mean, by their text: numbers change where cells are taken away.
    std::map<std::string, std::vector<world::Cell>> cells_of_regions = {};
    bool still = false;       // Catoms stay where they are, and no others are made.
    std::int64_t ticks = -1;  // Of the run; -1: as the study says.
};

// As files: the world itself, which names the others by their endings after its own name, if there are any.
struct WorldTexts {
    std::string world;
    std::map<std::string, std::string> beside = {};  // By ending: ".links.csv".
};

// `name` is that of the world's file without its ending. Errors: a column of the graph cannot be written.
Result<WorldTexts> texts_of(const SmallWorld& world, const std::string& name);

// Calls change(region) for each region of a world but those of events; what it returns takes its place, unless it is nothing.
void change_regions(toml::table& keys, const std::function<std::optional<std::string>(const std::string&)>& change);
// The same for the item of an event.
void change_regions(Happening& happening, const std::function<std::optional<std::string>(const std::string&)>& change);

// "cell == (0, 0, 0) || cell == (1, 0, 0)"; of none a region that matches nothing.
std::string region_of(const std::vector<world::Cell>& cells);

}  // namespace meld::driver
