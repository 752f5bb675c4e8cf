#include "runtime/world/file/moves_section.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/lattice/move_table.h"

namespace meld::world {
namespace {

// One [[motion.move]].
class MoveReader {
  public:
    MoveReader(TomlReader& reader, const toml::table& table, LatticeKind lattice)
        : reader_(reader),
          section_(reader, table, "[[motion.move]]", {"by", "full", "empty", "one_empty", "symmetries"}),
          lattice_(lattice) {}

    std::optional<ListedMove> read() {
        ListedMove listed;
        if (!section_.has("by")) {
            reader_.wrong(section_.source(), "a [[motion.move]] does not say where it leads", "add by = [1, 0], in cells");
            return std::nullopt;
        }
        listed.move.by = read_offset(*section_.find("by"), "by", MoveTable::kMaxBy);
        if (listed.move.by == Cell{} && !reader_.error()) section_.wrong("by", "a move by no cell is none", "write by = [1, 0]");
        listed.move.full = read_cells("full");
        listed.move.empty = read_cells("empty");
        read_pairs(listed.move);
        std::string symmetries = "all";
        section_.read_choice("symmetries", symmetries, {"all", "rotations", "none"});
        listed.symmetries = symmetries == "all" ? Symmetries::All : symmetries == "rotations" ? Symmetries::Rotations : Symmetries::None;
        if (!reader_.error()) check(listed);
        return reader_.error() ? std::nullopt : std::optional(std::move(listed));
    }

  private:
    bool flat() const { return Lattice(lattice_).flat(); }
    std::string_view form() const { return flat() ? "[x, y]" : "[x, y, z]"; }

    Cell read_offset(const toml::node& node, std::string_view key, std::int32_t farthest) {
        const std::string what = fmt::format("[[motion.move]] {}", key);
        const auto wrong = [&](std::string_view problem, std::string cure = {}) {
            reader_.wrong(node.source(), fmt::format("{} {}", what, problem), std::move(cure));
            return Cell{};
        };
        if (!node.is_array()) return wrong(type_mismatch(node, fmt::format("a cell {} as the mover sees it", form())));
        const toml::array& numbers = *node.as_array();
        if (numbers.size() != 3 && !(flat() && numbers.size() == 2))
            return wrong(fmt::format("has {} coordinates", numbers.size()), fmt::format("write {}", form()));
        Cell cell;
        std::int32_t* const axes[] = {&cell.x, &cell.y, &cell.z};
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const toml::node& number = *numbers.get(i);
            if (!number.is_integer()) return wrong("has a coordinate that is no whole number");
            const std::int64_t value = **number.as_integer();
            // The least number of all has no opposite.
            const auto away = value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
            if (away > static_cast<std::uint64_t>(farthest))
                return wrong(fmt::format("is {} cells away", away),
                             fmt::format("moves lead at most {} cells far in each coordinate, and depend on cells at most {} away",
                                         MoveTable::kMaxBy, MoveTable::kMaxAway));
            *axes[i] = static_cast<std::int32_t>(value);
        }
        if (flat() && cell.z != 0) return wrong("leaves the plane of a flat lattice", "write [x, y]");
        return cell;
    }
    Cell read_neighbour(const toml::node& node, std::string_view key) {
        const Cell cell = read_offset(node, key, MoveTable::kMaxAway);
        if (cell == Cell{} && !reader_.error())
            reader_.wrong(node.source(), fmt::format("[[motion.move]] {} has the mover's own cell", key), "take it out");
        return cell;
    }
    // full = [[0, -1], [1, -1]]
    std::vector<Cell> read_cells(std::string_view key) {
        std::vector<Cell> cells;
        const toml::node* node = section_.find(key);
        if (!node) return cells;
        if (!node->is_array()) {
            section_.wrong(key,
                           fmt::format("[[motion.move]] {} {}", key, type_mismatch(*node, fmt::format("an array of cells [{}]", form()))));
            return cells;
        }
        for (const toml::node& item : *node->as_array()) cells.push_back(read_neighbour(item, key));
        return cells;
    }
    // one_empty = [[[1, 0], [-1, 0]]]
    void read_pairs(Move& move) {
        const toml::node* node = section_.find("one_empty");
        if (!node) return;
        const auto wrong = [&](const toml::node& at) {
            reader_.wrong(at.source(), fmt::format("[[motion.move]] one_empty {}", type_mismatch(at, "an array of pairs of cells")),
                          flat() ? "write one_empty = [[[1, 0], [-1, 0]]]" : "write one_empty = [[[1, 0, 0], [-1, 0, 0]]]");
        };
        if (!node->is_array()) return wrong(*node);
        for (const toml::node& item : *node->as_array()) {
            if (!item.is_array()) return wrong(item);
            const toml::array& pair = *item.as_array();
            if (pair.size() != 2)
                return reader_.wrong(item.source(), fmt::format("[[motion.move]] one_empty has {} cells that are no pair", pair.size()),
                                     "write two cells in brackets of their own");
            const Cell one = read_neighbour(*pair.get(0), "one_empty"), other = read_neighbour(*pair.get(1), "one_empty");
            move.one_empty.emplace_back(one, other);
        }
    }
    // What no cell can be, and what is too far away once it is turned.
    void check(const ListedMove& listed) {
        const auto shown = [&](Cell c) { return flat() ? fmt::format("[{}, {}]", c.x, c.y) : fmt::format("[{}, {}, {}]", c.x, c.y, c.z); };
        for (const Cell cell : listed.move.full)
            if (cell == listed.move.by || std::ranges::count(listed.move.empty, cell) > 0)
                return section_.wrong(
                    "full", fmt::format("the cell {} would have to be both full and empty", shown(cell)),
                    cell == listed.move.by ? "the mover goes there, so it is empty: take it out" : "take one of the two out");
        const auto is_full = [&](Cell cell) { return std::ranges::count(listed.move.full, cell) > 0; };
        for (const auto& [one, other] : listed.move.one_empty)
            if (is_full(one) && is_full(other))
                return section_.wrong(
                    "one_empty",
                    fmt::format("one of the cells {} and {} would have to be empty, and full has both of them", shown(one), shown(other)),
                    "take one of the two out of full");
        const MoveTable all(lattice_, "", {&listed, 1});
        if (all.longest() > MoveTable::kMaxBy || all.reach() > MoveTable::kMaxAway)
            section_.wrong("by", "rotated or reflected, the move or a cell that it depends on is too far away",
                           fmt::format("moves lead at most {} cells far in each coordinate, and depend on cells at most {} away; with "
                                       "symmetries = \"none\" each direction is a [[motion.move]] of its own",
                                       MoveTable::kMaxBy, MoveTable::kMaxAway));
    }

    TomlReader& reader_;
    const Section section_;
    const LatticeKind lattice_;
};

void read_named(const Section& motion, const World& world, std::vector<ListedMove>& listed, std::string& name) {
    motion.read("moves", name);
    listed = MoveTable::named(name, world.lattice);
    const std::vector<std::string_view> here = MoveTable::names(world.lattice), lattices = MoveTable::lattices(name);
    if (!listed.empty()) return;
    if (lattices.empty())
        return motion.wrong("moves", fmt::format("there are no moves '{}' on the {} lattice", name, world.lattice_name()),
                            did_you_mean(name, here));
    motion.wrong("moves",
                 fmt::format("the moves \"{}\" are for the {} lattice{}, and this world is {}", name, fmt::join(lattices, " and the "),
                             lattices.size() == 1 ? "" : "s", world.lattice_name()),
                 fmt::format("write moves = \"{}\"", fmt::join(here, "\" or \"")));
}

}  // namespace

void read_moves(TomlReader& reader, const Section& motion, World& world) {
    const char* const first = motion.has("moves") ? "moves" : "move";
    // Nodes of a graph do not move, which is said elsewhere.
    if (!motion.has(first) || world.is_graph()) return;
    if (world.motion.kind != "lattice")
        return motion.wrong(first,
                            fmt::format("{} says how catoms on a lattice move, and kind is \"{}\"",
                                        first == std::string_view("moves") ? "moves" : "[[motion.move]]", world.motion.kind),
                            "write kind = \"lattice\"");
    std::vector<ListedMove> listed;
    std::string name;
    if (motion.has("moves")) read_named(motion, world, listed, name);
    const toml::node* own = motion.find("move");
    const auto add = [&](const toml::table& table) {
        if (auto move = MoveReader(reader, table, world.lattice).read()) listed.push_back(std::move(*move));
    };
    if (own != nullptr && own->is_table()) {
        add(*own->as_table());
    } else if (own != nullptr && own->is_array_of_tables()) {
        for (const toml::node& table : *own->as_array()) add(*table.as_table());
    } else if (own != nullptr) {
        motion.wrong("move", fmt::format("[motion] move {}", type_mismatch(*own, "tables [[motion.move]]")),
                     motion.has("moves") ? "" : "Write tables [[motion.move]], or moves = \"sliding\"");
    }
    if (reader.error() || listed.empty()) return;
    const std::string named = name.empty() ? "" : fmt::format("the moves \"{}\"", name);
    const std::string shown = own == nullptr ? named : named.empty() ? "the moves of the world" : named + " and those of the world";
    world.motion.moves = std::make_shared<const MoveTable>(world.lattice, shown, listed);
}

}  // namespace meld::world
