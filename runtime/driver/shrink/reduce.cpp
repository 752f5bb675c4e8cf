#include "runtime/driver/shrink/reduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include "runtime/base/units.h"
#include "runtime/driver/shrink/ddmin.h"
#include "runtime/driver/shrink/list_world.h"
#include "runtime/driver/shrink/sizes.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

// How much there is of each kind of thing.
struct Counts {
    std::size_t catoms = 0, links = 0, events = 0, faults = 0, facts = 0;
};

template <class T>
std::vector<T> only(const std::vector<T>& all, const Kept& kept) {
    std::vector<T> out;
    out.reserve(kept.size());
    for (const std::size_t i : kept) out.push_back(all[i]);
    return out;
}

// Links of nodes that are not there any more, and events that would join such nodes.
void drop_lost_links(SmallWorld& world) {
    GraphList& graph = *world.graph;
    std::vector<bool> there(graph.whole->nodes());
    for (const graph::Node node : graph.nodes) there[node] = true;
    std::erase_if(graph.links, [&](const graph::Entry& link) { return !there[link.node] || !there[graph.whole->to[link.at]]; });
    if (!world.events) return;
    const auto gone = [&](std::uint64_t id) {
        const auto node = graph.whole->find(id);
        return node && !there[*node];
    };
    std::erase_if(*world.events,
                  [&](const Happening& each) { return each.joins && (gone(each.joins->first) || gone(each.joins->second)); });
}

// What is under a key at the top, or in a section; whether there was something.
bool erase(toml::table& keys, const std::string& name) {
    const std::size_t dot = name.find('.');
    if (dot == std::string::npos) return keys.erase(name) > 0;
    toml::table* section = keys[name.substr(0, dot)].as_table();
    return section != nullptr && section->erase(name.substr(dot + 1)) > 0;
}

// network = { kind = "ideal" }, clock = { kind = "synchronous" }
bool is_plain(const toml::table& keys, const std::string& section) {
    const toml::table* table = keys[section].as_table();
    const std::string kind = table != nullptr && table->size() == 1 ? (*table)["kind"].value_or(std::string()) : "";
    return kind == "ideal" || kind == "synchronous";
}

// The facts of the world, each by the name of its predicate and its number there.
using FactPlace = std::pair<std::string, std::size_t>;
std::vector<FactPlace> facts_of(const toml::table& keys) {
    std::vector<FactPlace> all;
    if (const toml::table* facts = keys["facts"].as_table())
        for (const auto& [name, value] : *facts) {
            const std::size_t count = value.is_array() ? value.as_array()->size() : 1;
            for (std::size_t i = 0; i < count; ++i) all.emplace_back(std::string(name.str()), i);
        }
    return all;
}

toml::table with_facts(const toml::table& keys, const std::vector<FactPlace>& kept) {
    toml::table out = keys, facts;
    const toml::table& all = *keys["facts"].as_table();
    for (const auto& [name, number] : kept) {
        if (!all.get(name)->is_array()) {
            all.get(name)->visit([&, &key = name](const auto& typed) { facts.insert(key, typed); });
            continue;
        }
        if (!facts.contains(name)) facts.insert(name, toml::array{});
        facts[name].as_array()->push_back(*all.get(name)->as_array()->get(number));
    }
    out.erase("facts");
    if (!facts.empty()) out.insert("facts", facts);
    return out;
}

class Reducer {
  public:
    Reducer(const toml::table& keys, std::uint64_t seed, const Failure& failure, bool makes_nodes, Trials& trials)
        : seed_(seed), failure_(failure), makes_nodes_(makes_nodes), trials_(trials) {
        best_.keys = keys;
    }

    Result<Reduced> run();

  private:
    // ---- once, with the world as it is written
    // The world as it is now, before it has lists.
    Result<world::World> read(const SmallWorld& world) const;
    Result<Counts> count() const;
    Result<void> simplify_randomness();
    Result<void> shrink_sizes();
    Result<void> make_lists();

    // ---- until none of these finds anything more
    Result<bool> reduce_events();
    Result<bool> reduce_catoms();
    Result<bool> reduce_links();
    Result<bool> reduce_facts();
    Result<void> reduce_ticks();

    // Tries one world; whether it fails, and is the best one now.
    Result<bool> take(const SmallWorld& candidate);
    Result<bool> take_without(const std::vector<std::string>& names, const char* said);
    // Looks for the items of a list that are needed: `with` makes the world that has only these, `fits` says whether it is worth a try.
    // Returns whether there are fewer now.
    using With = std::function<SmallWorld(const Kept&)>;
    using Fits = std::function<bool(const Kept&)>;
    Result<bool> reduce_list(const char* what, std::size_t items, const With& with, const Fits& fits = {});
    std::vector<bool> facts_given(const world::World& world) const;
    Fits keeps_facts(const std::vector<std::size_t>& catoms) const;
    Counts counts_now() const;

    const std::uint64_t seed_;
    const Failure failure_;
    const bool makes_nodes_;
    Trials& trials_;
    SmallWorld best_;
    StartCatoms start_;
    // Of each fact that the world gives to some catoms at the start, whether a catom is one of these.
    std::vector<std::vector<bool>> given_;
    std::vector<std::string> simplified_;
};

Result<world::World> Reducer::read(const SmallWorld& small) const {
    const Result<WorldTexts> texts = texts_of(small, "");
    if (!texts) return tl::unexpected<Error>(texts.error());
    Result<world::World> world = world::parse_world(texts->world, "the world");
    if (world)
        if (const auto done = world::set_seed(*world, seed_); !done) return tl::unexpected<Error>(done.error());
    return world;
}

Result<Counts> Reducer::count() const {
    const Result<world::World> world = read(best_);
    if (!world) return tl::unexpected<Error>(world.error());
    Counts counts{.facts = facts_of(best_.keys).size()};
    for (const world::Event& event : world->events)
        counts.events += static_cast<std::size_t>(event.times) *
                         (event.give.size() + event.take.size() + event.kill.size() + event.hang.size() + event.restart.size() +
                          event.cut.size() + event.heal.size() + event.join.size() + event.jam.size());
    counts.faults = world->faults.size();
    if (world->is_graph()) {
        counts.catoms = world->graph->nodes();
        counts.links = world->graph->links();
    } else {
        counts.catoms = world::count_catoms(*world, world::Lattice(world->lattice));
    }
    return counts;
}

Result<bool> Reducer::take(const SmallWorld& candidate) {
    const auto found = trials_.first(1, [&](std::size_t) { return candidate; });
    if (!found) return tl::unexpected<Error>(found.error());
    if (!*found) return false;
    best_ = candidate;
    return true;
}

Result<bool> Reducer::take_without(const std::vector<std::string>& names, const char* said) {
    SmallWorld candidate = best_;
    // What only says so is no loss.
    const bool plain = names.size() == 1 && is_plain(best_.keys, names.front());
    for (const std::string& name : names)
        if (!erase(candidate.keys, name)) return false;
    const Result<bool> done = take(candidate);
    if (done && *done && !plain) simplified_.emplace_back(said);
    return done;
}

// A network without chance or delay, and catoms that act in every tick; or as much of that as still fails.
Result<void> Reducer::simplify_randomness() {
    trials_.about("network and clock");
    // A region or a file of links has terms of its own.
    const std::vector<std::pair<std::vector<std::string>, const char*>> ways = {{{"network", "clock"}, "network, clock: ideal"},
                                                                                {{"network"}, "network: ideal"},
                                                                                {{"clock"}, "clock: synchronous"},
                                                                                {{"network.region"}, "network: the same in all regions"},
                                                                                {{"network.links"}, "network: the same on all links"},
                                                                                {{"network.reorder"}, "network: nothing overtakes"},
                                                                                {{"network.duplicate"}, "network: nothing comes twice"},
                                                                                {{"network.loss"}, "network: nothing is lost"},
                                                                                {{"network.most"}, "network: delays are the same"},
                                                                                {{"network.detect"}, "network: ends are sensed at once"}};
    for (const auto& [names, said] : ways)
        if (const Result<bool> done = take_without(names, said); !done) return tl::unexpected<Error>(done.error());
    return {};
}

// Of each fact that the world gives at the start, whether some catom gets it. Where that does not matter, none.
std::vector<bool> Reducer::facts_given(const world::World& world) const {
    std::vector<bool> given;
    if (!failure_.of_the_end() || world.is_free()) return given;
    const StartCatoms start = StartCatoms::of(world);
    for (const world::GivenFact& fact : world.facts) given.push_back(!start.in(fact.where).empty());
    return given;
}

// Numbers of nodes and lengths of sides: as small as halving makes them.
Result<void> Reducer::shrink_sizes() {
    const Result<world::World> world = read(best_);
    if (!world) return tl::unexpected<Error>(world.error());
    const std::vector<bool> given = facts_given(*world);
    for (const SizePlace& place : sizes_in(best_.keys)) {
        trials_.about("sizes of the world");
        std::int64_t least = 1, most = size_at(best_.keys, place);
        while (least < most && !trials_.over()) {
            SmallWorld candidate = best_;
            const std::int64_t middle = least + (most - least) / 2;
            set_size(candidate.keys, place, middle);
            const Result<world::World> smaller = read(candidate);
            const Result<bool> done = smaller && facts_given(*smaller) == given ? take(candidate) : Result<bool>(false);
            if (!done) return tl::unexpected<Error>(done.error());
            (*done ? most : least) = *done ? middle : middle + 1;
        }
    }
    return {};
}

Result<void> Reducer::make_lists() {
    trials_.about("lists of what there is");
    const Result<world::World> world = read(best_);
    if (!world) return tl::unexpected<Error>(world.error());
    start_ = StartCatoms::of(*world);
    best_.still = stays_still(*world, makes_nodes_);
    if (failure_.of_the_end())
        for (const world::GivenFact& fact : world->facts) {
            const std::vector<std::size_t> catoms = start_.in(fact.where);
            if (catoms.empty()) continue;
            given_.emplace_back(start_.all().size());
            for (const std::size_t catom : catoms) given_.back()[catom] = true;
        }
    if (!world->events.empty() || !world->faults.empty()) {
        SmallWorld candidate = best_;
        list_events(candidate, *world, start_, std::max<std::int64_t>(failure_.ticks, 1));
        if (const Result<bool> done = take(candidate); !done) return tl::unexpected<Error>(done.error());
    }
    SmallWorld candidate = best_;
    if (!list_catoms(candidate, *world, start_)) return {};
    Result<bool> done = take(candidate);
    // A program may read where nodes are.
    if (done && !*done && candidate.graph && !std::exchange(candidate.graph->as_files, true)) done = take(candidate);
    if (!done) return tl::unexpected<Error>(done.error());
    return {};
}

Result<bool> Reducer::reduce_list(const char* what, std::size_t items, const With& with, const Fits& fits) {
    std::size_t left = items;
    const auto kept = ddmin(items, [&](std::size_t count, const std::function<Kept(std::size_t)>& candidate) {
        trials_.about(fmt::format("{} {} left", grouped(left), what));
        std::vector<std::size_t> fit;
        for (std::size_t i = 0; i < count; ++i)
            if (!fits || fits(candidate(i))) fit.push_back(i);
        auto found = trials_.first(fit.size(), [&](std::size_t i) { return with(candidate(fit[i])); });
        if (!found || !*found) return found;
        *found = fit[**found];
        left = candidate(**found).size();
        return found;
    });
    if (!kept) return tl::unexpected<Error>(kept.error());
    if (kept->size() == items) return false;
    best_ = with(*kept);
    return true;
}

// First as they are written, then each target of those that are left.
Result<bool> Reducer::reduce_events() {
    bool any = false;
    for (int round = 0; round < 2 && best_.events && !trials_.over(); ++round) {
        if (round == 1) {
            SmallWorld candidate = best_;
            if (!split_regions(candidate, start_)) break;
            const Result<bool> done = take(candidate);
            if (!done) return done;
            if (!*done) break;
        }
        const SmallWorld before = best_;
        const Result<bool> fewer = reduce_list("events", before.events->size(), [&](const Kept& kept) {
            SmallWorld out = before;
            out.events = only(*before.events, kept);
            return out;
        });
        if (!fewer) return fewer;
        any = any || *fewer;
    }
    return any;
}

// What the world gives to some catoms is still given to one: without it, nothing that is expected would come about, for another reason.
Reducer::Fits Reducer::keeps_facts(const std::vector<std::size_t>& catoms) const {
    if (given_.empty()) return {};
    return [this, catoms](const Kept& kept) {
        return std::ranges::all_of(given_, [&](const std::vector<bool>& to) {
            return std::ranges::any_of(kept, [&](std::size_t i) { return i < catoms.size() && to[catoms[i]]; });
        });
    };
}

Result<bool> Reducer::reduce_catoms() {
    const SmallWorld before = best_;
    if (before.graph) {
        const std::vector<std::size_t> catoms(before.graph->nodes.begin(), before.graph->nodes.end());
        return reduce_list(
            "nodes", catoms.size(),
            [&](const Kept& kept) {
                SmallWorld out = before;
                out.graph->nodes = only(before.graph->nodes, kept);
                drop_lost_links(out);
                return out;
            },
            keeps_facts(catoms));
    }
    if (!before.cells) return false;
    std::vector<std::size_t> catoms;
    for (const world::Cell& cell : *before.cells)
        if (const auto number = start_.at(cell)) catoms.push_back(*number);
    const std::size_t cells = before.cells->size();
    return reduce_list(
        "catoms", cells + before.placed.size(),
        [&](const Kept& kept) {
            SmallWorld out = before;
            const auto first_placed = std::ranges::lower_bound(kept, cells);
            out.cells = only(*before.cells, Kept(kept.begin(), first_placed));
            Kept placed(first_placed, kept.end());
            for (std::size_t& i : placed) i -= cells;
            out.placed = only(before.placed, placed);
            return out;
        },
        keeps_facts(catoms));
}

Result<bool> Reducer::reduce_links() {
    if (!best_.graph) return false;
    const SmallWorld before = best_;
    return reduce_list("links", before.graph->links.size(), [&](const Kept& kept) {
        SmallWorld out = before;
        out.graph->links = only(before.graph->links, kept);
        return out;
    });
}

// Where what is expected at the end counts, facts stay: without them it would not come about, for another reason.
Result<bool> Reducer::reduce_facts() {
    if (failure_.of_the_end()) return false;
    const SmallWorld before = best_;
    const std::vector<FactPlace> all = facts_of(before.keys);
    return reduce_list("facts", all.size(), [&](const Kept& kept) {
        SmallWorld out = before;
        out.keys = with_facts(before.keys, only(all, kept));
        return out;
    });
}

// What has happened by a tick has happened by later ones.
Result<void> Reducer::reduce_ticks() {
    if (failure_.of_the_end() || failure_.ticks < 1) return {};
    trials_.about("ticks");
    std::int64_t least = 1, most = failure_.ticks + 1;
    while (least < most && !trials_.over()) {
        SmallWorld candidate = best_;
        candidate.ticks = least + (most - least) / 2;
        const Result<bool> done = take(candidate);
        if (!done) return tl::unexpected<Error>(done.error());
        if (*done)
            most = candidate.ticks;
        else
            least = candidate.ticks + 1;
    }
    return {};
}

Counts Reducer::counts_now() const {
    Counts counts{.events = best_.events ? best_.events->size() : 0, .facts = facts_of(best_.keys).size()};
    counts.faults = best_.keys.contains("faults") ? 1 : 0;
    if (best_.graph) {
        counts.catoms = best_.graph->nodes.size();
        counts.links = best_.graph->links.size();
    } else if (best_.cells) {
        counts.catoms = best_.cells->size() + best_.placed.size();
    }
    return counts;
}

Result<Reduced> Reducer::run() {
    const Result<Counts> before = count();
    if (!before) return tl::unexpected<Error>(before.error());
    for (const auto step : {&Reducer::simplify_randomness, &Reducer::shrink_sizes, &Reducer::make_lists})
        if (const Result<void> done = (this->*step)(); !done) return tl::unexpected<Error>(done.error());
    for (bool more = true; more && !trials_.over();) {
        more = false;
        for (const auto pass : {&Reducer::reduce_events, &Reducer::reduce_catoms, &Reducer::reduce_links, &Reducer::reduce_facts}) {
            const Result<bool> fewer = (this->*pass)();
            if (!fewer) return tl::unexpected<Error>(fewer.error());
            more = more || *fewer;
        }
        if (const Result<void> done = simplify_randomness(); !done) return tl::unexpected<Error>(done.error());
    }
    if (const Result<void> done = reduce_ticks(); !done) return tl::unexpected<Error>(done.error());
    Reduced out{.world = best_, .became = {}, .least = !trials_.over()};
    const Counts after = counts_now();
    const bool listed = best_.graph || best_.cells;
    const auto line = [&](const char* name, std::size_t was, std::size_t is) {
        if (was > 0 || is > 0) out.became.push_back(fmt::format("{}: {} to {}", name, grouped(was), grouped(is)));
    };
    if (listed) line(best_.graph ? "nodes" : "catoms", before->catoms, after.catoms);
    if (best_.graph) line("links", before->links, after.links);
    if (best_.events || before->events == 0) line("events", before->events, after.events);
    line("faults at random", before->faults, after.faults);
    line("given facts", before->facts, after.facts);
    if (best_.ticks >= 0) line("ticks", static_cast<std::size_t>(failure_.ticks), static_cast<std::size_t>(best_.ticks));
    out.became.insert(out.became.end(), simplified_.begin(), simplified_.end());
    return out;
}

}  // namespace

Result<Reduced> reduce(const toml::table& keys, std::uint64_t seed, const Failure& failure, bool makes_nodes, Trials& trials) {
    return Reducer(keys, seed, failure, makes_nodes, trials).run();
}

}  // namespace meld::driver
