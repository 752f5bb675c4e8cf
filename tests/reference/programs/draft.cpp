#include "tests/reference/programs/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>

#include "runtime/base/error.h"
#include "runtime/world/description/world.h"

namespace meld::reference {

using retraction::Change;
using world::Cell;

namespace {

std::string joined(const std::vector<std::string>& parts) {
    std::string text;
    for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
    return text;
}

constexpr const char* kNames[] = {"give", "take", "remove", "add", "move", "cut", "heal", "join", "hang", "restart"};
// By Reach.
constexpr std::string_view kReach[] = {"", "// Facts go to nodes that are known by value.",
                                       "// Facts go over links to nodes that are known by value."};
// Lines of a trial after the program begin so.
constexpr std::string_view kMark = "//: ";

std::string print(Cell c) { return fmt::format("{},{},{}", c.x, c.y, c.z); }

}  // namespace

std::string print(const DraftRule& rule) {
    const std::string head = rule.heads.empty() ? "1" : joined(rule.heads), body = joined(rule.body);
    if (rule.body.empty()) return head + ".";
    if (!rule.select.empty()) return "[" + rule.select + " | " + body + "] -o " + head + ".";
    return rule.linear ? body + " -o " + head + "." : head + " :- " + body + ".";
}

Reach reach_of(const std::string& text) {
    for (const Reach reach : {Reach::OneHop, Reach::Routes})
        if (text.starts_with(kReach[static_cast<int>(reach)])) return reach;
    return Reach::None;
}

std::string print(const Draft& draft) {
    if (!draft.text.empty()) return draft.text;
    std::string text = draft.reach != Reach::None ? std::string(kReach[static_cast<int>(draft.reach)]) + "\n" : "";
    for (const Declaration& d : draft.declarations) text += d.text + "\n";
    text += "\n";
    for (const DraftRule& rule : draft.rules) text += print(rule) + "\n";
    return text;
}

std::string print(const Trial& trial) {
    std::string text = print(trial.draft) + "\n";
    const auto line = [&](const std::string& what) { text += std::string(kMark) + what + "\n"; };
    line(fmt::format("seed {}", trial.world.seed));
    line(fmt::format("lattice {}", trial.world.graph ? "graph" : world::Lattice(trial.world.lattice).name()));
    for (const retraction::Given& g : trial.draft.given)
        line(fmt::format("given {} {} {}", g.predicate, g.arguments.size(), g.linear ? "linear" : "persistent"));
    for (const Cell& cell : trial.world.cells) line("catom " + print(cell));
    for (const auto& [a, b] : trial.world.links) line(fmt::format("link {} {}", a, b));
    for (const auto& burst : trial.world.bursts) {
        line("burst");
        for (const Change& c : burst) {
            std::string what = fmt::format("{} {} {}", c.tick, kNames[static_cast<int>(c.kind)], print(c.cell));
            if (c.has_other_cell()) what += " " + print(c.to);
            if (c.kind <= Change::Kind::Take) what += fmt::format(" {}", c.given);
            for (const std::int64_t a : c.arguments) what += fmt::format(" {}", a);
            line(what);
        }
    }
    return text;
}

namespace {

bool parse_cell(std::istream& in, Cell& cell) {
    char comma = 0;
    return static_cast<bool>(in >> cell.x >> comma >> cell.y >> comma >> cell.z);
}

bool parse_change(const std::string& line, Change& c) {
    std::istringstream in(line);
    std::string kind;
    if (!(in >> c.tick >> kind) || !parse_cell(in, c.cell)) return false;
    std::size_t index = 0;
    while (index < std::size(kNames) && kind != kNames[index]) ++index;
    if (index == std::size(kNames)) return false;
    c.kind = static_cast<Change::Kind>(index);
    if (c.has_other_cell()) return parse_cell(in, c.to);
    if (c.kind <= Change::Kind::Take && !(in >> c.given)) return false;
    for (std::int64_t a = 0; in >> a;) c.arguments.push_back(a);
    return true;
}

bool parse_line(const std::string& line, Trial& trial) {
    std::istringstream in(line);
    std::string word;
    in >> word;
    if (word == "seed") return static_cast<bool>(in >> trial.world.seed);
    if (word == "lattice") {
        in >> word;
        trial.world.graph = word == "graph";
        if (trial.world.graph) return true;
        const auto kind = world::Lattice::kind_named(word);
        if (kind) trial.world.lattice = *kind;
        return kind.has_value();
    }
    if (word == "given") {
        std::size_t arguments = 0;
        std::string name;
        if (!(in >> name >> arguments >> word)) return false;
        trial.draft.given.push_back(
            {.predicate = name, .arguments = std::vector<std::pair<std::int64_t, std::int64_t>>(arguments), .linear = word == "linear"});
        return true;
    }
    if (word == "catom") return parse_cell(in, trial.world.cells.emplace_back());
    if (word == "link") {
        std::pair<std::uint64_t, std::uint64_t> ends;
        return in >> ends.first >> ends.second && ends.first < ends.second && trial.world.links.insert(ends).second;
    }
    if (word == "burst") {
        trial.world.bursts.emplace_back();
        return true;
    }
    if (trial.world.bursts.empty()) return false;
    return parse_change(line, trial.world.bursts.back().emplace_back());
}

}  // namespace

Result<Trial> parse_trial(const std::string& text) {
    Trial trial;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with(kMark))
            trial.draft.text += line + "\n";
        else if (!parse_line(line.substr(kMark.size()), trial))
            return fail("this line says nothing that happens: " + line);
    }
    trial.draft.reach = reach_of(trial.draft.text);
    if (trial.draft.reach != Reach::None && !trial.world.graph) return fail("facts go to nodes, and the world is no graph");
    if (trial.world.cells.empty() || trial.world.bursts.empty()) return fail("no catoms, or no burst of changes");
    if (trial.world.graph)
        std::ranges::sort(trial.world.cells);
    else
        world::sort_cells(trial.world.cells, world::Lattice(trial.world.lattice));
    for (const auto& [a, b] : trial.world.links)
        if (!std::ranges::binary_search(trial.world.cells, retraction::node(a)) ||
            !std::ranges::binary_search(trial.world.cells, retraction::node(b)))
            return fail(fmt::format("a link of a catom that is not there: {} {}", a, b));
    return trial;
}

}  // namespace meld::reference
