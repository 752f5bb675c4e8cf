#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <utility>

#include "runtime/driver/shrink/list_world.h"

namespace meld::driver {

namespace {

constexpr std::int64_t kMostRepeated = 1'000;
// Draws of random numbers, some tens of nanoseconds each.
constexpr double kMostDraws = 2e8;

constexpr std::array<std::string_view, 3> kCatoms = {"kill", "hang", "restart"};
constexpr std::array<std::string_view, 2> kLinks = {"cut", "heal"};
constexpr std::array<std::string_view, 2> kFacts = {"take", "give"};

template <class List>
bool is_in(const List& list, std::string_view key) {
    return std::ranges::find(list, key) != list.end();
}

toml::array item_of(const toml::node& node) {
    toml::array item;
    item.push_back(node);
    return item;
}

// Each item of an array, or what is none.
void each_item(const toml::node& node, const std::function<void(const toml::node&)>& visit) {
    if (const toml::array* array = node.as_array())
        for (const toml::node& item : *array) visit(item);
    else
        visit(node);
}

// Links are arrays themselves.
void each_link(const toml::node& node, const std::function<void(const toml::node&)>& visit) {
    each_item(node, [&](const toml::node& item) {
        const toml::array* array = item.as_array();
        if (array != nullptr && !array->empty() && array->get(0)->is_array())
            each_link(item, visit);
        else
            visit(item);
    });
}

// How one target is written.
class Names {
  public:
    Names(const StartCatoms& start, bool still) : start_(start), by_cell_(still && !start.in_graph() && !start.all().empty()) {}

    std::string region(std::size_t catom) const {
        return by_cell_ ? region_of({start_.all()[catom].cell}) : fmt::format("id == {}", start_.all()[catom].id);
    }
    toml::array catom(std::uint64_t id) const {
        const StartCatoms::One* one = by_cell_ ? start_.find(id) : nullptr;
        return one != nullptr ? toml::array{region_of({one->cell})} : toml::array{static_cast<std::int64_t>(id)};
    }
    toml::array link(std::uint64_t a, std::uint64_t b) const {
        const StartCatoms::One *one = by_cell_ ? start_.find(a) : nullptr, *other = by_cell_ ? start_.find(b) : nullptr;
        if (one == nullptr || other == nullptr) return item_of(toml::array{static_cast<std::int64_t>(a), static_cast<std::int64_t>(b)});
        return toml::array{toml::table{{"between", toml::array{region_of({one->cell}), region_of({other->cell})}}}};
    }

  private:
    const StartCatoms& start_;
    bool by_cell_;
};

std::uint64_t id_in(const toml::node& node) { return static_cast<std::uint64_t>(node.value_or(std::int64_t{0})); }

class Listing {
  public:
    Listing(const StartCatoms& start, bool still) : names_(start, still) {}

    // The items of an event of the file, as it was read.
    void add(const toml::table& table, const world::Event& event, std::size_t source);
    const std::vector<Happening>& all() const { return all_; }

  private:
    void put(const Happening& of, std::string_view key, toml::array item, const std::string& predicate = {});
    Names names_;
    std::vector<Happening> all_;
};

void Listing::put(const Happening& of, std::string_view key, toml::array item, const std::string& predicate) {
    Happening one = of;
    one.key = key;
    one.predicate = predicate;
    one.item = std::move(item);
    if (key == "join")
        if (const toml::array* pair = one.item.get(0)->as_array(); pair != nullptr && pair->size() == 2)
            one.joins = {id_in(*pair->get(0)), id_in(*pair->get(1))};
    all_.push_back(std::move(one));
}

void Listing::add(const toml::table& table, const world::Event& event, std::size_t source) {
    std::vector<Happening> times;
    if (event.times <= kMostRepeated)
        for (std::int64_t i = 0; i < event.times; ++i) times.push_back({.tick = event.tick + i * event.every, .source = source, .key = ""});
    else
        times.push_back({.tick = event.tick, .every = event.every, .times = event.times, .source = source, .key = ""});
    for (const Happening& of : times) {
        for (const std::string_view key : kCatoms)
            if (const toml::node* node = table.get(key))
                each_item(*node,
                          [&](const toml::node& item) { put(of, key, item.is_integer() ? names_.catom(id_in(item)) : item_of(item)); });
        for (const std::string_view key : kLinks)
            if (const toml::node* node = table.get(key))
                each_link(*node, [&](const toml::node& item) {
                    const toml::array* pair = item.as_array();
                    const bool is_pair = pair != nullptr && pair->size() == 2;
                    put(of, key, is_pair ? names_.link(id_in(*pair->get(0)), id_in(*pair->get(1))) : item_of(item));
                });
        for (const char* key : {"join", "jam"})
            if (const toml::node* node = table.get(key)) each_item(*node, [&](const toml::node& item) { put(of, key, item_of(item)); });
        for (const std::string_view key : kFacts) {
            const toml::table* facts = table[key].as_table();
            if (facts == nullptr) continue;
            for (const auto& [name, value] : *facts)
                each_item(value,
                          [&, predicate = std::string(name.str())](const toml::node& item) { put(of, key, item_of(item), predicate); });
        }
    }
}

// What the faults of a world strike, from a function of the seed, the numbers and the tick. Nothing: too much, or nobody knows beforehand.
std::optional<std::vector<Happening>> list_faults(const world::World& world, const StartCatoms& start, bool still, std::int64_t last_tick,
                                                  std::size_t source) {
    struct Way {
        const char* key;
        world::Fault fault;
        double world::Faults::* probability;
        bool links;
    };
    constexpr std::array kWays = {
        Way{"kill", world::Fault::Kill, &world::Faults::kill, false}, Way{"hang", world::Fault::Hang, &world::Faults::hang, false},
        Way{"restart", world::Fault::Restart, &world::Faults::restart, false}, Way{"cut", world::Fault::Cut, &world::Faults::cut, true},
        Way{"heal", world::Fault::Heal, &world::Faults::heal, true}};
    const Names names(start, still);
    std::vector<Happening> all;
    if (!still || start.all().empty()) return std::nullopt;
    for (std::size_t number = 0; number < world.faults.size(); ++number) {
        const world::Faults& faults = world.faults[number];
        const std::int64_t end = std::min(faults.until, last_tick);
        std::vector<bool> in(start.all().size());
        for (const std::size_t catom : start.in(faults.where)) in[catom] = true;
        const double draws = static_cast<double>(std::max<std::int64_t>(end - faults.from + 1, 0)) *
                             static_cast<double>(start.all().size() + start.links().size());
        if (draws > kMostDraws) return std::nullopt;
        for (std::int64_t tick = faults.from; tick <= end && all.size() <= kMostHappenings; ++tick)
            for (const Way& way : kWays) {
                if (faults.*way.probability <= 0) continue;
                const auto put = [&](toml::array item) {
                    all.push_back(
                        {.tick = tick, .source = source + static_cast<std::size_t>(tick), .key = way.key, .item = std::move(item)});
                };
                if (!way.links) {
                    for (std::size_t i = 0; i < start.all().size(); ++i)
                        if (in[i] && world::strikes(way.fault, faults.*way.probability, world.seed, number, start.all()[i].id, tick))
                            put(names.catom(start.all()[i].id));
                    continue;
                }
                for (const auto& [a, b] : start.links()) {
                    const std::uint64_t one = start.all()[a].id, other = start.all()[b].id;
                    if ((in[a] || in[b]) && world::strikes(way.fault, faults.*way.probability, world.seed, number, one, other, tick))
                        put(names.link(one, other));
                }
            }
    }
    if (all.size() > kMostHappenings) return std::nullopt;
    std::ranges::stable_sort(all, {}, &Happening::tick);
    return all;
}

// A region of catoms in one of the places where it may stand; nothing: it is none, or has a mistake.
std::optional<std::vector<std::size_t>> catoms_in(const StartCatoms& start, const std::string& region) {
    const Result<world::Region> parsed = world::Region::parse(region);
    if (!parsed) return std::nullopt;
    return start.in(*parsed);
}

// Whether it is split, into `out`.
bool split(const Happening& one, const StartCatoms& start, const Names& names, std::vector<Happening>& out) {
    const toml::node& item = *one.item.get(0);
    const toml::table* table = item.as_table();
    const auto put = [&](toml::array items) {
        out.push_back(one);
        out.back().item = std::move(items);
    };
    if (is_in(kCatoms, one.key)) {
        if (!item.is_string()) return false;
        const auto catoms = catoms_in(start, **item.as_string());
        if (!catoms) return false;
        for (const std::size_t catom : *catoms) put(names.catom(start.all()[catom].id));
        return true;
    }
    if (is_in(kFacts, one.key)) {
        const std::string region = item.is_string() ? **item.as_string() : table != nullptr ? (*table)["where"].value_or("all") : "";
        const auto catoms = catoms_in(start, region);
        if (!catoms) return false;
        for (const std::size_t catom : *catoms) {
            if (table == nullptr) {
                put(toml::array{names.region(catom)});
                continue;
            }
            toml::table fact = *table;
            fact.insert_or_assign("where", names.region(catom));
            put(item_of(fact));
        }
        return true;
    }
    const bool jam = one.key == "jam";
    if ((!jam && !is_in(kLinks, one.key)) || (jam && table == nullptr)) return false;
    const toml::array* between = table != nullptr ? (*table)["between"].as_array() : nullptr;
    std::vector<std::vector<std::size_t>> ends;
    if (between != nullptr) {
        for (const toml::node& region : *between) {
            const auto catoms = catoms_in(start, region.value_or(std::string()));
            if (!catoms) return false;
            ends.push_back(*catoms);
        }
    } else {
        const toml::node* where = table != nullptr ? table->get("where") : &item;
        if (where != nullptr && !where->is_string()) return false;
        const auto catoms = catoms_in(start, where == nullptr ? "all" : **where->as_string());
        if (!catoms) return false;
        ends.push_back(*catoms);
    }
    if (ends.empty() || ends.size() > 2) return false;
    const auto in = [&](std::size_t end, std::size_t catom) { return std::ranges::binary_search(ends[end], catom); };
    for (const auto& [a, b] : start.links()) {
        const bool meant = ends.size() == 1 ? in(0, a) || in(0, b) : (in(0, a) && in(1, b)) || (in(0, b) && in(1, a));
        if (!meant) continue;
        toml::array link = names.link(start.all()[a].id, start.all()[b].id);
        if (!jam) {
            put(std::move(link));
            continue;
        }
        toml::table one_jam{{"ticks", (*table)["ticks"].value_or(std::int64_t{1})}};
        if (const toml::table* regions = link.get(0)->as_table())
            one_jam.insert("between", *regions->get("between")->as_array());
        else
            one_jam.insert("where", link);
        put(item_of(one_jam));
    }
    return true;
}

}  // namespace

bool list_events(SmallWorld& small, const world::World& world, const StartCatoms& start, std::int64_t last_tick) {
    Listing listing(start, small.still);
    if (const toml::array* events = small.keys["event"].as_array())
        for (std::size_t i = 0; i < events->size() && i < world.events.size(); ++i)
            if (const toml::table* table = events->get(i)->as_table()) listing.add(*table, world.events[i], i);
    if (const toml::table* table = small.keys["event"].as_table(); table != nullptr && !world.events.empty())
        listing.add(*table, world.events[0], 0);
    std::vector<Happening> all = listing.all();
    const auto faults = list_faults(world, start, small.still, last_tick, world.events.size());
    if (faults) all.insert(all.end(), faults->begin(), faults->end());
    if (all.size() > kMostHappenings) return false;
    std::ranges::stable_sort(all, [](const Happening& a, const Happening& b) { return a.tick < b.tick; });
    small.events = std::move(all);
    small.keys.erase("event");
    if (faults) small.keys.erase("faults");
    return faults.has_value() || world.faults.empty();
}

bool split_regions(SmallWorld& small, const StartCatoms& start) {
    if (!small.events || !small.still || start.all().empty()) return false;
    const Names names(start, small.still);
    std::vector<Happening> all;
    bool any = false;
    for (const Happening& one : *small.events) {
        std::vector<Happening> parts;
        if (split(one, start, names, parts)) {
            any = any || parts.size() != 1;
            all.insert(all.end(), parts.begin(), parts.end());
        } else {
            all.push_back(one);
        }
        if (all.size() > kMostHappenings) return false;
    }
    if (any) small.events = std::move(all);
    return any;
}

}  // namespace meld::driver
