#include "runtime/world/file/event_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/world/file/given_facts.h"

namespace meld::world {
namespace {

// Beyond any run, and far from an overflow.
constexpr std::uint64_t kMaxTicks = 1'000'000'000;
// Quarantines last as long for each rank.
constexpr std::uint64_t kMaxLatency_ticks = 10'000;
// They are looked at one by one, once.
constexpr std::size_t kMaxJams = 100'000;

// What works without a table of links.
constexpr std::array<std::string_view, 8> kOfEvents = {"tick", "time", "every", "times", "give", "take", "kill", "gravity"};
constexpr std::array<std::string_view, 4> kOfFaults = {"kill", "where", "from", "until"};

constexpr std::string_view kNoHealing = "points that move are linked again when one of them moves within the range";

class Events {
  public:
    Events(TomlReader& reader, World& world) : reader_(reader), world_(world) {}

    void read(const toml::table& table);
    // `least`: they may make messages so late, however short they are.
    void measure_jams(std::int64_t least);

  private:
    // Calls read(node) for the items of an array, or for what is none.
    template <class Read>
    static void each(const toml::node& node, const Read& read) {
        if (const toml::array* const array = node.as_array())
            for (const toml::node& item : *array) read(item);
        else
            read(node);
    }
    void when(const Section& section, const toml::table& table, Event& event);
    void read_catoms(std::string_view key, const toml::node& node, std::vector<CatomChoice>& all);
    void read_links(std::string_view key, const toml::node& node, std::vector<LinkChoice>& all);
    std::optional<LinkChoice> read_pair(const toml::array& array);
    bool read_between(const Section& section, LinkChoice& one);
    void read_joins(const toml::node& node, std::vector<LinkChoice>& all);
    void read_jam(const toml::node& node, std::vector<Jam>& all);
    void refuse_for_bodies(std::string_view key, const toml::node& node);
    void read_gravity(const Section& section, Event& event);

    TomlReader& reader_;
    World& world_;
    std::string first_jam_;  // Its place.
};

void Events::read_catoms(std::string_view key, const toml::node& node, std::vector<CatomChoice>& all) {
    CatomChoice one{.place = reader_.place(node.source())};
    const std::int64_t* const id = node.is_integer() ? &**node.as_integer() : nullptr;
    if (id != nullptr && *id >= 0)
        one.id = static_cast<std::uint64_t>(*id);
    else if (node.is_string())
        one.where = read_region(reader_, node);
    else if (id != nullptr)
        return reader_.wrong(node.source(), fmt::format("there is no catom @{}", *id), "catoms are numbered from 0");
    else
        return reader_.wrong(node.source(), fmt::format("{} {}", key, type_mismatch(node, "a region or the number of a catom")),
                             fmt::format("write {} = \"x > 10\"", key));
    all.push_back(std::move(one));
}

std::optional<LinkChoice> Events::read_pair(const toml::array& array) {
    const auto id = [&](std::size_t i) { return array.get(i)->value<std::int64_t>(); };
    if (array.size() != 2 || !array.is_homogeneous(toml::node_type::integer) || *id(0) < 0 || *id(1) < 0) {
        reader_.wrong(array.source(), "a link has the numbers of two catoms", "write [[3, 4]] for the link of @3 and @4");
        return std::nullopt;
    }
    if (*id(0) == *id(1)) {
        reader_.wrong(array.source(), fmt::format("@{} has no link with itself", *id(0)), "write the numbers of two catoms");
        return std::nullopt;
    }
    return LinkChoice{.pair = std::pair(static_cast<std::uint64_t>(*id(0)), static_cast<std::uint64_t>(*id(1))),
                      .place = reader_.place(array.source())};
}

// between = [REGION, REGION]; returns whether it is well.
bool Events::read_between(const Section& section, LinkChoice& one) {
    std::vector<std::string> regions;
    section.read("between", regions);
    if (regions.size() != 2) {
        section.wrong("between", "links lie between two regions", "write between = [\"x < 0\", \"x >= 0\"]");
        return false;
    }
    const toml::array& array = *section.find("between")->as_array();
    one.where = read_region(reader_, *array.get(0));
    one.other = read_region(reader_, *array.get(1));
    return true;
}

void Events::read_links(std::string_view key, const toml::node& node, std::vector<LinkChoice>& all) {
    each(node, [&](const toml::node& item) {
        LinkChoice one{.place = reader_.place(item.source())};
        if (item.is_string()) {
            one.where = read_region(reader_, item);
        } else if (item.is_table()) {
            const Section section(reader_, *item.as_table(), std::string(key), {"between"});
            if (!read_between(section, one)) return;
        } else if (item.is_array() && !item.as_array()->empty() && item.as_array()->get(0)->is_array()) {
            return read_links(key, item, all);
        } else if (item.is_array()) {
            const auto pair = read_pair(*item.as_array());
            if (!pair) return;
            one = *pair;
        } else {
            return reader_.wrong(item.source(), fmt::format("{} {}", key, type_mismatch(item, "a region or an array of links")),
                                 fmt::format("write {0} = \"id == 3\" for all links of @3, or {0} = [[3, 4]] for one", key));
        }
        all.push_back(std::move(one));
    });
}

void Events::read_joins(const toml::node& node, std::vector<LinkChoice>& all) {
    if (!world_.is_graph())
        return reader_.wrong(node.source(), "only nodes of a graph can be joined: on a lattice catoms have links with those they touch",
                             "write heal, or choose lattice = \"graph\"");
    if (!node.is_array() || node.as_array()->empty())
        return reader_.wrong(node.source(), "join " + type_mismatch(node, "an array of links"), "write join = [[3, 4]]");
    for (const toml::node& item : *node.as_array()) {
        if (!item.is_array()) return reader_.wrong(item.source(), "a link has the numbers of two catoms", "write join = [[3, 4]]");
        std::optional<LinkChoice> pair = read_pair(*item.as_array());
        if (!pair) return;
        for (const std::uint64_t id : {pair->pair->first, pair->pair->second})
            // Rules may make nodes with higher numbers.
            if (id < world_.graph->next_id() && !world_.graph->find(id))
                return reader_.wrong(item.source(), fmt::format("the graph has no node {}", id), "join two of its nodes");
        all.push_back(std::move(*pair));
    }
}

void Events::read_jam(const toml::node& node, std::vector<Jam>& all) {
    if (!node.is_table())
        return reader_.wrong(node.source(), "jam " + type_mismatch(node, "a table"), "write jam = { where = \"x > 10\", ticks = 20 }");
    const Section section(reader_, *node.as_table(), "jam", {"where", "between", "ticks"});
    std::uint64_t ticks = 0;
    section.read_count("ticks", ticks, 1, kMaxLatency_ticks);
    if (!section.has("ticks")) return section.wrong("ticks", "it does not say for how long", "add ticks = 20");
    if (section.has("where") && section.has("between"))
        return section.wrong("where", "a jam has where or between", "write two of them: jam = [{ ... }, { ... }]");
    std::vector<LinkChoice> links;
    if (const toml::node* where = section.find("where")) {
        read_links("where", *where, links);
    } else if (section.has("between")) {
        LinkChoice one{.place = reader_.place(node.source())};
        if (!read_between(section, one)) return;
        links.push_back(std::move(one));
    } else {
        links.push_back({.place = reader_.place(node.source())});
    }
    if (first_jam_.empty()) first_jam_ = reader_.place(node.source());
    for (LinkChoice& one : links) all.push_back({.links = std::move(one), .ticks = static_cast<std::int64_t>(ticks)});
}

void Events::when(const Section& section, const toml::table& table, Event& event) {
    if (section.has("tick") == section.has("time"))
        return reader_.wrong(table.source(),
                             section.has("tick") ? "an [[event]] has both tick and time" : "an [[event]] has neither tick nor time",
                             "write tick = 10");
    std::uint64_t tick = 1, every = 0, times = 1;
    section.read_count("tick", tick, 1, kMaxTicks);
    double seconds = world_.tick_seconds;
    section.read_seconds("time", seconds);
    // As for a delay in the language: the number of whole ticks that fit, but at least one.
    if (section.has("time"))
        tick = static_cast<std::uint64_t>(
            std::clamp(std::floor(seconds / world_.tick_seconds * (1 + 1e-12)), 1.0, static_cast<double>(kMaxTicks)));
    section.read_count("every", every, 1, kMaxTicks);
    section.read_count("times", times, 1, kMaxTicks);
    if (section.has("every") != section.has("times"))
        return reader_.wrong(table.source(), "an [[event]] that happens again has both every and times", "write every = 10 and times = 3");
    event.tick = static_cast<std::int64_t>(tick);
    event.every = static_cast<std::int64_t>(every);
    event.times = static_cast<std::int64_t>(times);
}

void Events::refuse_for_bodies(std::string_view key, const toml::node& node) {
    if (world_.is_free())
        reader_.wrong(node.source(), fmt::format("`{}` is for catoms on a lattice and nodes of a graph, and these are bodies", key),
                      "use kill, or take the bodies out");
}

void Events::read_gravity(const Section& section, Event& event) {
    if (!world_.is_free())
        return section.wrong("gravity", "only bodies feel gravity, and these catoms are none",
                             "take it out, or write [motion] kind = \"bodies\"");
    Vec3 gravity{};
    section.read("gravity", gravity);
    event.gravity = gravity;
}

void Events::read(const toml::table& table) {
    const Section section(
        reader_, table, "[[event]]",
        {"tick", "time", "every", "times", "give", "take", "kill", "hang", "restart", "cut", "heal", "join", "jam", "gravity"});
    Event event;
    when(section, table, event);
    for (const auto& [key, facts] : {std::pair("give", &event.give), std::pair("take", &event.take)}) {
        const toml::node* node = section.find(key);
        if (node != nullptr && !node->is_table())
            return reader_.wrong(node->source(), fmt::format("{} {}", key, type_mismatch(*node, "a table of facts")));
        if (node != nullptr) read_facts(reader_, *node->as_table(), *facts);
    }
    for (const auto& [key, catoms] : {std::pair("kill", &event.kill), std::pair("hang", &event.hang), std::pair("restart", &event.restart)})
        if (const toml::node* const node = section.find(key))
            each(*node, [&, name = std::string_view(key), out = catoms](const toml::node& item) { read_catoms(name, item, *out); });
    for (const auto& [key, links] : {std::pair("cut", &event.cut), std::pair("heal", &event.heal)})
        if (const toml::node* const node = section.find(key)) read_links(key, *node, *links);
    if (const toml::node* const node = section.find("join")) read_joins(*node, event.join);
    if (const toml::node* const node = section.find("jam")) each(*node, [&](const toml::node& item) { read_jam(item, event.jam); });
    if (const toml::node* const node = section.find("heal"); node != nullptr && world_.has_moving_nodes())
        return reader_.wrong(node->source(), kNoHealing, "take heal out");
    for (const char* key : {"hang", "restart", "cut", "heal", "jam"})
        if (const toml::node* const node = section.find(key)) refuse_for_bodies(key, *node);
    if (section.has("gravity")) read_gravity(section, event);
    if (event.give.empty() && event.take.empty() && !event.gravity && !event.strikes_catoms() && !event.strikes_links() &&
        event.jam.empty())
        return reader_.wrong(table.source(), "this [[event]] does nothing", "write give = { tap = \"id == 0\" }");
    world_.events.push_back(std::move(event));
}

void Events::measure_jams(std::int64_t least) {
    const auto refuse = [&](std::string_view problem) {
        reader_.wrong(
            Error{fmt::format("{}: {}", first_jam_.empty() ? "[network] longest_jam" : first_jam_, problem), "make them fewer or shorter"});
    };
    const std::optional<std::int64_t> measured = longest_jam(world_.events, world_.clock);
    if (!measured) return refuse(fmt::format("there are more than {} jams", kMaxJams));
    const auto longest = static_cast<std::uint64_t>(std::max(*measured, least));
    world_.longest_jam = 0;
    const auto most = longest + world_.latency();
    if (most > kMaxLatency_ticks)
        return refuse(fmt::format("a message may be under way for {} ticks, and the maximum is {}", most, kMaxLatency_ticks));
    world_.longest_jam = static_cast<std::uint32_t>(longest);
}

void read_one_of_faults(TomlReader& reader, const toml::table& table, World& world) {
    const Section section(reader, table, "[faults]", {"kill", "hang", "restart", "cut", "heal", "where", "from", "until"});
    Faults faults;
    for (const auto& [key, value] : {std::pair("kill", &faults.kill), std::pair("hang", &faults.hang),
                                     std::pair("restart", &faults.restart), std::pair("cut", &faults.cut), std::pair("heal", &faults.heal)})
        section.read_number(key, *value, 0, 1);
    faults.place = reader.place(table.source());
    if (const auto where = section.read_region("where")) {
        faults.where = *where;
        faults.place = reader.place(section.find("where")->source());
    }
    std::uint64_t from = 1, until = kMaxTicks;
    section.read_count("from", from, 1, kMaxTicks);
    section.read_count("until", until, 1, kMaxTicks);
    faults.from = static_cast<std::int64_t>(from);
    if (section.has("until"))
        faults.until = static_cast<std::int64_t>(until);
    else
        world.warnings.push_back(
            fmt::format("{}: [faults] has no `until`, so the run ends only with --ticks", reader.place(table.source())));
    if (until < from) return section.wrong("until", fmt::format("until is {}, and from is {}", until, from));
    if (!faults.strikes_catoms() && !faults.strikes_links())
        return reader.wrong(table.source(), "these [faults] do nothing", "write kill = 1e-4");
    if (world.is_free() && (faults.hang > 0 || faults.restart > 0 || faults.strikes_links()))
        return reader.wrong(table.source(), "bodies can only be killed", "leave only kill in [faults]");
    if (world.has_moving_nodes() && faults.heal > 0) return section.wrong("heal", kNoHealing, "take heal out");
    world.faults.push_back(std::move(faults));
}

// Calls read(table) for [name] or each [[name]].
template <class Read>
void each_table(TomlReader& reader, const toml::table& top, const char* name, const Read& read) {
    const toml::node* node = top.get(name);
    if (node == nullptr) return;
    if (node->is_table()) return read(*node->as_table());
    if (!node->is_array_of_tables())
        return reader.wrong(node->source(), fmt::format("{} {}", name, type_mismatch(*node, fmt::format("a table [[{}]]", name))));
    for (const toml::node& table : *node->as_array()) read(*table.as_table());
}

}  // namespace

std::optional<std::int64_t> longest_jam(std::span<const Event> events, const ClockOptions& clock) {
    std::vector<std::pair<std::int64_t, std::int64_t>> jams;
    for (const Event& event : events) {
        if (event.jam.empty()) continue;
        std::int64_t ticks = 0;
        for (const Jam& jam : event.jam) ticks = std::max(ticks, jam.ticks);
        if (jams.size() + static_cast<std::size_t>(event.times) > kMaxJams) return std::nullopt;
        for (std::int64_t i = 0; i < event.times; ++i) {
            const std::int64_t begin = event.tick + i * event.every;
            jams.emplace_back(begin, begin + ticks + clock.most - 1);
        }
    }
    std::ranges::sort(jams);
    std::int64_t begin = 0, end = 0, longest = 0;
    for (const auto& [from, to] : jams) {
        if (from > end) begin = from;
        end = std::max(end, to);
        longest = std::max(longest, end - begin);
    }
    return longest;
}

void read_events(TomlReader& reader, const toml::table& top, World& world) {
    Events events(reader, world);
    each_table(reader, top, "event", [&](const toml::table& table) { events.read(table); });
    if (!reader.error()) events.measure_jams(top["network"]["longest_jam"].value_or(std::int64_t{0}));
}

void read_faults(TomlReader& reader, const toml::table& top, World& world) {
    each_table(reader, top, "faults", [&](const toml::table& table) { read_one_of_faults(reader, table, world); });
}

bool needs_links(const toml::table& top) {
    const auto has_others = [](const toml::node& node, const auto& known) {
        const toml::table* const table = node.as_table();
        if (table == nullptr) return false;
        for (const auto& [key, value] : *table)
            if (std::ranges::find(known, key.str()) == known.end()) return true;
        return false;
    };
    const auto any = [&](const char* name, const auto& known) {
        const toml::node* const node = top.get(name);
        if (node == nullptr) return false;
        if (!node->is_array()) return has_others(*node, known);
        for (const toml::node& table : *node->as_array())
            if (has_others(table, known)) return true;
        return false;
    };
    return any("event", kOfEvents) || any("faults", kOfFaults);
}

}  // namespace meld::world
