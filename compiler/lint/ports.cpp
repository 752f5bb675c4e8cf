// Programs that were written for another robot and name its sides by its own numbers: `const bottom = 0` of Blinky Blocks. They compile and
// run, with other results, so all that a program calls its ports is compared with the tables of all robots.
#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>

#include "compiler/lint/lint.h"
#include "runtime/module/abi/port_numbers.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;

namespace {

constexpr std::string_view kDirections[] = {"bottom", "down",  "top",  "up",    "north", "south", "east",
                                            "west",   "right", "left", "front", "back",  "side"};

// The directions that a word is made of, as "northeast"; none if there is more in it, as in "topology".
std::vector<std::string_view> directions_of(std::string_view word) {
    std::vector<std::string_view> out;
    while (!word.empty()) {
        const auto* const found = std::ranges::find_if(kDirections, [&](std::string_view d) { return word.starts_with(d); });
        if (found == std::end(kDirections)) return {};
        out.push_back(*found);
        word.remove_prefix(found->size());
    }
    return out;
}

// Those that a name mentions: "noBottomNeighbor", "top-right", "NORTH_EAST", "bottom8".
std::vector<std::string_view> directions_in(std::string_view name) {
    std::vector<std::string_view> out;
    std::string word;
    const auto end_word = [&] {
        for (const std::string_view direction : directions_of(word)) out.push_back(direction);
        word.clear();
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto c = static_cast<unsigned char>(name[i]);
        const bool hump = std::isupper(c) != 0 && i > 0 && std::islower(static_cast<unsigned char>(name[i - 1])) != 0;
        if (hump || std::isalpha(c) == 0) end_word();
        if (std::isalpha(c) != 0) word += static_cast<char>(std::tolower(c));
    }
    end_word();
    return out;
}

// Whether one of these words, "top-right up-right", has all of the directions.
bool says(std::string_view words, const std::vector<std::string_view>& directions) {
    while (!words.empty()) {
        const std::string_view word = words.substr(0, words.find(' '));
        const std::vector<std::string_view> in_it = directions_in(word);
        if (std::ranges::all_of(directions, [&](std::string_view d) { return std::ranges::find(in_it, d) != in_it.end(); })) return true;
        words.remove_prefix(std::min(words.size(), word.size() + 1));
    }
    return false;
}

// What a program calls a port.
struct Named {
    std::int64_t port = 0;
    std::string name;
    std::vector<std::string_view> directions;
    Span span;

    bool fits(const PortNumbers& numbers) const {
        return port >= 0 && port < numbers.count && says(numbers.sides[static_cast<std::size_t>(port)].words, directions);
    }
};

class Ports {
  public:
    Ports(const Program& program, const Place& place) : program_(program), place_(place) {
        for (const Rule& rule : program_.rules) read(rule);
    }

    void warn(diagnostics::Reporter& report) const {
        // The name of a predicate says little of a port by itself: the lower of two may be called the bottom.
        if (constants_.empty() && different(predicates_) < 2) return;
        if (std::ranges::any_of(lattices(), [&](const PortNumbers* own) { return fits(*own); })) return;
        std::vector<const PortNumbers*> robots;
        for (const PortNumbers& robot : robot_port_numbers())
            if (fits(robot)) robots.push_back(&robot);
        if (robots.empty()) return;
        const PortNumbers& own = *lattice_of(*robots.front());
        const std::vector<Named> all = named();
        const Named& first = *std::ranges::find_if(all, [&](const Named& n) { return !n.fits(own); });
        std::vector<std::string> names;
        for (const PortNumbers* robot : robots) names.emplace_back(robot->robot);
        auto& d = report.add(Kind::OtherPorts, first.span,
                             fmt::format("`{}` is port {}, as on {}, and on the {} lattice {}", first.name, first.port, one_of(names),
                                         own.lattice, side(own, first.port)));
        std::vector<std::string> cures;
        for (const PortNumbers* robot : robots) {
            const std::string lattice = robot->lattice == own.lattice ? "" : fmt::format("lattice = \"{}\" and ", robot->lattice);
            cures.push_back(fmt::format("{}ports = \"{}\" ({})", lattice, robot->name, robot->table()));
        }
        d.help = fmt::format("write {} in the world, or run it with --ports {}; here ports are {}", one_of(cures), robots.front()->name,
                             own.table());
    }

  private:
    static std::string one_of(const std::vector<std::string>& texts) {
        std::string out;
        for (const std::string& text : texts) out += (out.empty() ? "" : " or ") + text;
        return out;
    }
    static std::string side(const PortNumbers& own, std::int64_t port) {
        if (port < 0 || port >= own.count) return "there is none";
        const std::string_view words = own.sides[static_cast<std::size_t>(port)].words;
        return fmt::format("that is {}", words.substr(0, words.find(' ')));
    }
    static std::size_t different(const std::vector<Named>& named) {
        std::set<std::int64_t> ports;
        for (const Named& n : named) ports.insert(n.port);
        return ports.size();
    }

    std::vector<Named> named() const {
        std::vector<Named> all = constants_;
        all.insert(all.end(), predicates_.begin(), predicates_.end());
        return all;
    }
    bool fits(const PortNumbers& numbers) const {
        const auto fit = [&](const Named& n) { return n.fits(numbers); };
        return std::ranges::all_of(constants_, fit) && std::ranges::all_of(predicates_, fit);
    }
    // Those that the program may be for.
    std::vector<const PortNumbers*> lattices() const {
        std::vector<const PortNumbers*> out;
        for (const PortNumbers& own : lattice_port_numbers())
            if (place_.lattice.empty() || place_.lattice == own.lattice) out.push_back(&own);
        return out;
    }
    const PortNumbers* lattice_of(const PortNumbers& robot) const {
        const std::vector<const PortNumbers*> all = lattices();
        const auto same = std::ranges::find(all, robot.lattice, &PortNumbers::lattice);
        return same != all.end() ? *same : all.front();
    }

    void read(const Rule& rule) {
        std::vector<Named> literals;
        const auto each = [&](const Atom& atom, bool) { read(rule, atom, literals); };
        each_atom(rule.body, each);
        each_head(rule.heads, [&](const Head& h) {
            each_atom(h.body, each);
            if (h.kind == Head::Kind::Fact) each(h.atom, false);
        });
        each_head(rule.heads, [&](const Head& h) {
            if (h.kind != Head::Kind::Fact) return;
            const std::string& name = program_.predicates[h.atom.predicate].name;
            for (Named literal : literals) {
                literal.name = name;
                literal.directions = directions_in(name);
                if (!literal.directions.empty()) predicates_.push_back(std::move(literal));
            }
        });
    }

    // What a variable is equal to in the body, as in neighbor(A, B, P), P = 5.
    static const Term& value_of(const Rule& rule, const Term& term) {
        if (!term.is_variable()) return term;
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal || c.test.operands.size() != 2) continue;
            for (const std::size_t side : {std::size_t{0}, std::size_t{1}})
                if (c.test.operands[side].is_variable() && c.test.operands[side].variable == term.variable)
                    return c.test.operands[1 - side];
        }
        return term;
    }

    void read(const Rule& rule, const Atom& atom, std::vector<Named>& literals) {
        const Predicate& p = program_.predicates[atom.predicate];
        if (!p.prelude) return;
        for (std::size_t i = 0; i < atom.arguments.size(); ++i) {
            if (!is_port(p.arguments[i])) continue;
            const Term& term = value_of(rule, atom.arguments[i]);
            if (term.op == Op::Int) literals.push_back({term.integer, {}, {}, term.span});
            if (term.op != Op::Constant) continue;
            const Constant& constant = program_.constants[term.constant];
            std::vector<std::string_view> directions = directions_in(constant.name);
            if (constant.computed.valid()) continue;
            if (directions.empty())
                literals.push_back({constant.integer, {}, {}, term.span});
            else
                constants_.push_back({constant.integer, constant.name, std::move(directions), term.span});
        }
    }
    // By the names that stdlib/prelude.meld gives to arguments.
    static bool is_port(const Argument& argument) {
        return argument.type == Type::Int && (argument.name == "Port" || argument.name == "Pivot" || argument.name == "Towards");
    }

    const Program& program_;
    const Place& place_;
    std::vector<Named> constants_, predicates_;
};

}  // namespace

void warn_of_ports(const Program& program, const Place& place, diagnostics::Reporter& report) {
    if (place.ports.empty() && place.lattice != "graph") Ports(program, place).warn(report);
}

}  // namespace meld::lint
