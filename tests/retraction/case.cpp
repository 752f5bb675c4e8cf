#include "case.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "runtime/world/description/world.h"

namespace meld::retraction {

namespace {

using world::LatticeKind;

std::vector<Cell> box(Cell first, Cell size) {
    std::vector<Cell> cells;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) cells.push_back(first + Cell{x, y, z});
    return cells;
}

// The space of a case lies across the corner of bricks at the origin, so that several processes own some of it.
std::vector<Cell> choose_space(Random& random, LatticeKind lattice) {
    const bool flat = lattice == LatticeKind::Square || lattice == LatticeKind::Hex;
    const auto size = [&](int least, int most) { return static_cast<std::int32_t>(least + below(random, most - least + 1)); };
    const bool line = below(random, 6) == 0;
    const Cell extent = line   ? Cell{size(4, 30), size(1, 2), 1}
                        : flat ? Cell{size(2, 8), size(2, 7), 1}
                               : Cell{size(2, 5), size(2, 4), size(2, 4)};
    const Cell first{-static_cast<std::int32_t>(below(random, extent.x)), -static_cast<std::int32_t>(below(random, extent.y)),
                     -static_cast<std::int32_t>(below(random, extent.z))};
    return box(flat ? Cell{first.x, first.y, 0} : first, extent);
}

// All of the space, its rim, or a random part.
std::vector<Cell> choose_cells(Random& random, const std::vector<Cell>& space) {
    const std::int64_t form = below(random, 6);
    if (form == 0) return space;
    std::vector<Cell> cells;
    const Cell first = space.front(), last = space.back();
    const std::int64_t chance = 40 + below(random, 55);
    for (const Cell& c : space) {
        const int ends = (c.x == first.x || c.x == last.x) + (c.y == first.y || c.y == last.y);
        if (form == 1 ? ends > 0 && c.z == first.z : below(random, 100) < chance) cells.push_back(c);
    }
    if (cells.empty()) cells.push_back(first);
    return cells;
}

template <class Container>
auto pick(Random& random, const Container& from) {
    return *std::next(from.begin(), below(random, static_cast<std::int64_t>(from.size())));
}

Change give_to(Random& random, const std::vector<Given>& given, std::size_t which, Cell cell) {
    Change c{.kind = Change::Kind::Give, .cell = cell, .given = which};
    for (const auto& [least, most] : given[which].arguments) c.arguments.push_back(least + below(random, most - least + 1));
    return c;
}

std::optional<Change> take_some(Random& random, const Mirror& mirror) {
    std::vector<Change> all;
    for (std::size_t g = 0; g < mirror.given.size(); ++g) {
        const auto facts = mirror.facts.find(mirror.given[g].predicate);
        if (mirror.given[g].linear || facts == mirror.facts.end()) continue;
        for (const auto& [cell, id] : mirror.at)
            for (auto row = facts->second.lower_bound(Row{static_cast<std::int64_t>(id)});
                 row != facts->second.end() && (*row)[0] == static_cast<std::int64_t>(id); ++row)
                all.push_back({.kind = Change::Kind::Take, .cell = cell, .given = g, .arguments = Row(row->begin() + 1, row->end())});
    }
    if (all.empty()) return std::nullopt;
    return pick(random, all);
}

std::optional<Change> choose_change(Random& random, const Mirror& mirror, const std::vector<Cell>& space) {
    std::vector<Cell> empty;
    for (const Cell& c : space)
        if (!mirror.at.contains(c)) empty.push_back(c);
    const std::int64_t kind = below(random, 100);
    if (kind < 30) return take_some(random, mirror);
    if (mirror.at.empty() || kind >= 80)
        return empty.empty() ? std::nullopt : std::optional(Change{.kind = Change::Kind::Add, .cell = pick(random, empty)});
    const Cell cell = pick(random, mirror.at).first;
    if (kind < 50)
        return give_to(random, mirror.given, static_cast<std::size_t>(below(random, static_cast<std::int64_t>(mirror.given.size()))), cell);
    if (kind < 68) return Change{.kind = Change::Kind::Remove, .cell = cell};
    if (empty.empty()) return std::nullopt;
    return Change{.kind = Change::Kind::Move, .cell = cell, .to = pick(random, empty)};
}

std::string print(Cell c) { return fmt::format("({}, {}, {})", c.x, c.y, c.z); }

}  // namespace

Mirror::Mirror(const Case& c, const std::vector<Given>& the_given) : given(the_given), graph(c.graph) {
    for (const Cell& cell : c.cells) at[cell] = c.graph ? static_cast<std::uint64_t>(cell.x) : next_id++;
    for (const auto& [a, b] : c.links) {
        rows_[a].push_back(b);
        rows_[b].push_back(a);
    }
    for (auto& [id, row] : rows_) {
        std::sort(row.begin(), row.end());
        for (std::size_t i = 0; i < row.size(); ++i) ports[id][static_cast<int>(i)] = row[i];
    }
}

void Mirror::become(const Mirror& other) {
    at = other.at;
    next_id = other.next_id;
    facts = other.facts;
    missing = other.missing;
    hung = other.hung;
    ports = other.ports;
}

bool Mirror::linked(std::uint64_t a, std::uint64_t b) const {
    const auto mine = ports.find(a);
    return mine != ports.end() && std::any_of(mine->second.begin(), mine->second.end(), [&](const auto& p) { return p.second == b; });
}

// A link of the graph has the port of its place in the row; others get the first one behind the row.
int Mirror::port_for(std::uint64_t from, std::uint64_t to) const {
    static const std::vector<std::uint64_t> none;
    static const std::map<int, std::uint64_t> nowhere;
    const auto known = rows_.find(from);
    const std::vector<std::uint64_t>& row = known == rows_.end() ? none : known->second;
    const auto own = std::lower_bound(row.begin(), row.end(), to);
    if (own != row.end() && *own == to) return static_cast<int>(own - row.begin());
    const auto linked = ports.find(from);
    const auto& taken = linked == ports.end() ? nowhere : linked->second;
    int port = static_cast<int>(row.size());
    while (taken.contains(port)) ++port;
    return port;
}

bool Mirror::link(std::uint64_t a, std::uint64_t b) {
    if (a == b || linked(a, b)) return false;
    const int here = port_for(a, b), there = port_for(b, a);
    ports[a][here] = b;
    ports[b][there] = a;
    return true;
}

void Mirror::forget(std::uint64_t id) {
    const Row from{static_cast<std::int64_t>(id)}, to{static_cast<std::int64_t>(id + 1)};
    for (auto& [name, rows] : facts) rows.erase(rows.lower_bound(from), rows.lower_bound(to));
}

void Mirror::forget_links(std::uint64_t id) {
    std::erase_if(missing, [&](const auto& link) { return link.first == id || link.second == id; });
    ports.erase(id);
    for (auto& [other, its] : ports) std::erase_if(its, [&](const auto& port) { return port.second == id; });
}

void Mirror::restart(std::uint64_t id) {
    forget(id);
    hung.erase(id);
}

std::vector<std::uint64_t> Mirror::wake(std::int64_t now) {
    std::vector<std::uint64_t> awake;
    for (const auto& [id, until] : hung)
        if (until <= now) awake.push_back(id);
    for (const std::uint64_t id : awake) restart(id);
    return awake;
}

bool Mirror::apply(const Change& c) {
    const auto here = at.find(c.cell);
    if ((c.kind == Change::Kind::Add) == (here != at.end())) return false;
    switch (c.kind) {
        case Change::Kind::Add:
            at[c.cell] = next_id++;
            return true;
        case Change::Kind::Remove: {
            restart(here->second);
            forget_links(here->second);
            at.erase(here);
            return true;
        }
        case Change::Kind::Move: {
            if (at.contains(c.to)) return false;
            const std::uint64_t id = here->second;
            at.erase(here);
            at[c.to] = id;
            forget_links(id);
            return true;
        }
        case Change::Kind::Cut:
        case Change::Kind::Heal: {
            const auto there = at.find(c.to);
            if (there == at.end()) return false;
            const std::pair<std::uint64_t, std::uint64_t> ends = std::minmax(here->second, there->second);
            if (!graph) return c.kind == Change::Kind::Cut ? missing.insert(ends).second : missing.erase(ends) > 0;
            if (c.kind == Change::Kind::Heal) return missing.erase(ends) > 0 && link(ends.first, ends.second);
            if (!linked(ends.first, ends.second)) return false;
            // One that was joined does not come back by itself.
            if (std::ranges::binary_search(rows_[ends.first], ends.second)) missing.insert(ends);
            for (const auto& [one, other] : {ends, std::pair(ends.second, ends.first)})
                std::erase_if(ports[one], [&](const auto& port) { return port.second == other; });
            return true;
        }
        case Change::Kind::Join: {
            const auto there = at.find(c.to);
            if (there == at.end() || !link(here->second, there->second)) return false;
            missing.erase(std::minmax(here->second, there->second));
            return true;
        }
        case Change::Kind::Hang:
            return !hung.contains(here->second);
        case Change::Kind::Restart:
            restart(here->second);
            return true;
        case Change::Kind::Give:
        case Change::Kind::Take:
            break;
    }
    Row row{static_cast<std::int64_t>(here->second)};
    row.insert(row.end(), c.arguments.begin(), c.arguments.end());
    const Given& g = given[c.given];
    if (g.linear && g.becomes.empty()) return c.kind == Change::Kind::Give;
    std::set<Row>& rows = facts[g.linear ? g.becomes : g.predicate];
    return c.kind == Change::Kind::Give ? rows.insert(row).second : rows.erase(row) > 0;
}

namespace {

// What is given at first, and changes at random ticks, each of which makes sense.
void add_bursts(Random& random, Case& c, const std::vector<Given>& given, const std::vector<Cell>& space, std::int64_t bursts,
                const std::function<std::pair<std::int64_t, std::int64_t>()>& size) {
    Mirror mirror(c, given);
    for (std::int64_t b = 0; b < bursts; ++b) {
        std::vector<Change>& burst = c.bursts.emplace_back();
        if (b == 0)
            for (const Cell& cell : c.cells)
                for (std::size_t g = 0; g < given.size(); ++g)
                    if (below(random, 1000) < given[g].per_mille) burst.push_back(give_to(random, given, g, cell));
        for (const Change& change : burst) mirror.apply(change);
        const auto [changes, span] = size();
        std::vector<int> ticks;
        for (std::int64_t n = 0; n < changes; ++n) ticks.push_back(static_cast<int>(below(random, span)));
        std::sort(ticks.begin(), ticks.end());
        for (const int tick : ticks) {
            std::optional<Change> change = choose_change(random, mirror, space);
            if (!change || !mirror.apply(*change)) continue;
            change->tick = tick;
            burst.push_back(*change);
        }
    }
}

}  // namespace

Case make_case(std::uint64_t seed, const std::vector<Given>& given) {
    Random random(seed);
    Case c{.seed = seed, .lattice = static_cast<LatticeKind>(below(random, 4)), .cells = {}, .bursts = {}};
    const std::vector<Cell> space = choose_space(random, c.lattice);
    c.cells = choose_cells(random, space);
    world::sort_cells(c.cells, world::Lattice(c.lattice));
    const std::int64_t bursts = 1 + below(random, 4);
    add_bursts(random, c, given, space, bursts, [&] {
        // Mostly a few changes, now and then a storm.
        const std::int64_t changes = 1 + below(random, below(random, 5) == 0 ? 60 : 14);
        return std::pair(changes, 1 + below(random, 30));
    });
    return c;
}

namespace {

bool any_of_kind(const Case& c, Change::Kind least) {
    for (const std::vector<Change>& burst : c.bursts)
        for (const Change& change : burst)
            if (change.kind >= least) return true;
    return false;
}

}  // namespace

bool has_failures(const Case& c) { return any_of_kind(c, Change::Kind::Cut); }
bool has_catom_failures(const Case& c) { return any_of_kind(c, Change::Kind::Hang); }

void add_failures(Case& c, const std::vector<Given>& given) {
    Random random(c.seed ^ 0xfa11);
    const world::Lattice lattice(c.lattice);
    Mirror mirror(c, given);
    for (std::vector<Change>& burst : c.bursts) {
        std::vector<Change> all;
        const int last = burst.empty() ? 0 : burst.back().tick;
        std::int64_t left = 1 + below(random, below(random, 4) == 0 ? 40 : 10);
        for (std::size_t next = 0; next < burst.size() || left > 0;) {
            const bool one = left > 0 && (next == burst.size() || below(random, static_cast<std::int64_t>(burst.size()) + 1) < left);
            if (!one) {
                if (mirror.apply(burst[next])) all.push_back(burst[next]);
                ++next;
                continue;
            }
            --left;
            if (mirror.at.empty()) continue;
            const int earliest = all.empty() ? 0 : all.back().tick, latest = next < burst.size() ? burst[next].tick : last + 12;
            Change change{.tick = earliest + static_cast<int>(below(random, std::max(1, latest - earliest + 1)))};
            // The links of a graph fail anyway.
            const std::int64_t kind = c.graph ? 75 + below(random, 25) : below(random, 100);
            change.cell = pick(random, mirror.at).first;
            change.kind = kind < 45   ? Change::Kind::Cut
                          : kind < 75 ? Change::Kind::Heal
                          : kind < 88 ? Change::Kind::Hang
                                      : Change::Kind::Restart;
            if (change.kind == Change::Kind::Heal && !mirror.missing.empty()) {
                const auto [a, b] = pick(random, mirror.missing);
                for (const auto& [cell, id] : mirror.at) {
                    if (id == a) change.cell = cell;
                    if (id == b) change.to = cell;
                }
            } else if (change.has_other_cell()) {
                change.to = lattice.neighbour(change.cell, static_cast<int>(below(random, lattice.ports())));
            } else if (change.kind == Change::Kind::Hang) {
                change.arguments.push_back(1 + below(random, 25));
            }
            if (!mirror.apply(change)) continue;
            if (change.kind == Change::Kind::Hang) mirror.hang(mirror.at.at(change.cell), 0);
            all.push_back(change);
        }
        burst = std::move(all);
        mirror.wake(0);
    }
}

Case make_large_case(std::uint64_t seed, const std::vector<Given>& given) {
    Random random(seed);
    Case c{.seed = seed, .lattice = LatticeKind::Square, .cells = {}, .bursts = {}};
    const std::vector<Cell> space = box({-24, -24, 0}, {48, 48, 1});
    for (const Cell& cell : space)
        if (below(random, 100) < 64) c.cells.push_back(cell);
    world::sort_cells(c.cells, world::Lattice(c.lattice));
    add_bursts(random, c, given, space, 3, [] { return std::pair<std::int64_t, std::int64_t>(150, 250); });
    return c;
}

std::string print(const Case& c, const std::vector<Given>& given) {
    std::string text = fmt::format("seed {}, lattice {}, {} catoms at", c.seed, world::Lattice(c.lattice).name(), c.cells.size());
    for (const Cell& cell : c.cells) text += " " + print(cell);
    constexpr const char* kNames[] = {"give", "take", "remove", "add", "move", "cut", "heal", "join", "hang", "restart"};
    for (std::size_t b = 0; b < c.bursts.size(); ++b) {
        text += fmt::format("\nburst {}", b);
        for (const Change& change : c.bursts[b]) {
            text += fmt::format("\n  tick {}: {} {}", change.tick, kNames[static_cast<int>(change.kind)], print(change.cell));
            if (change.has_other_cell()) text += " to " + print(change.to);
            if (change.kind > Change::Kind::Take) continue;
            text += " " + given[change.given].predicate;
            for (const std::int64_t a : change.arguments) text += fmt::format(" {}", a);
        }
    }
    return text + "\n";
}

}  // namespace meld::retraction
