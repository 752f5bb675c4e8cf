// Cases in graphs.
#include <algorithm>
#include <optional>
#include <utility>

#include "case.h"

namespace meld::retraction {

namespace {

using Pair = std::pair<std::uint64_t, std::uint64_t>;

class Maker {
  public:
    Maker(std::uint64_t seed, const std::vector<Given>& given, std::size_t max_degree)
        : random_(seed ^ 0x67726170), given_(given), max_degree_(max_degree) {
        case_.seed = seed;
        case_.graph = true;
    }

    Case make() {
        // Several pieces now and then, also single nodes.
        for (std::int64_t pieces = below(random_, 4) == 0 ? 2 + below(random_, 3) : 1; pieces > 0; --pieces) add_piece();
        number();
        Mirror mirror(case_, given_);
        for (std::int64_t bursts = 1 + below(random_, 4); bursts > 0; --bursts) add_burst(mirror);
        return std::move(case_);
    }

  private:
    std::int64_t draw(std::int64_t least, std::int64_t most) { return least + below(random_, most - least + 1); }

    void link(std::int64_t a, std::int64_t b) {
        const Pair ends = std::minmax(static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b));
        if (a == b || degree_[ends.first] >= max_degree_ || degree_[ends.second] >= max_degree_) return;
        if (!case_.links.insert(ends).second) return;
        ++degree_[ends.first];
        ++degree_[ends.second];
    }

    // Links of new nodes among each other.
    void add_piece() {
        const std::int64_t first = nodes_, form = below(random_, 10);
        const auto of = [&](std::int64_t n) { return nodes_ += n, n; };
        switch (form) {
            case 0: {  // A ring; two nodes are a line.
                const std::int64_t n = of(draw(1, 20));
                for (std::int64_t i = 0; i < n; ++i) link(first + i, first + (i + 1) % n);
                return;
            }
            case 1: {  // A star, with more links than a word has bits once in a while.
                const std::int64_t n = of(below(random_, 6) == 0 ? draw(33, 70) : draw(3, 20));
                for (std::int64_t i = 1; i < n; ++i) link(first, first + i);
                return;
            }
            case 2: {  // All with all.
                const std::int64_t n = of(draw(2, 9));
                for (std::int64_t i = 0; i < n; ++i)
                    for (std::int64_t j = 0; j < i; ++j) link(first + i, first + j);
                return;
            }
            case 3: {
                const std::int64_t n = of(draw(3, 30)), children = draw(1, 4);
                for (std::int64_t i = 1; i < n; ++i) link(first + i, first + (i - 1) / children);
                return;
            }
            case 4:
            case 5: {  // Those that have links get more.
                const std::int64_t n = of(draw(4, 30)), each = draw(1, 3);
                std::vector<std::int64_t> ends{first};
                for (std::int64_t i = 1; i < n; ++i)
                    for (std::int64_t k = 0; k < each; ++k) {
                        const std::int64_t to = ends[static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(ends.size())))];
                        link(first + i, to);
                        ends.insert(ends.end(), {to, first + i});
                    }
                return;
            }
            default: {  // Any pairs, so that some nodes are by themselves.
                const std::int64_t n = of(draw(2, 30));
                for (std::int64_t left = draw(0, n + n / 2); left > 0; --left) link(first + below(random_, n), first + below(random_, n));
            }
        }
    }

    // Nodes are numbered from 0, or some numbers are missing; which is which does not follow from the form.
    void number() {
        std::vector<std::uint64_t> ids;
        const bool gaps = below(random_, 3) == 0;
        for (std::uint64_t next = 0; std::cmp_less(ids.size(), nodes_);
             next += gaps ? 1 + static_cast<std::uint64_t>(below(random_, 4)) : 1)
            ids.push_back(next);
        for (const std::uint64_t id : ids) case_.cells.push_back(node(id));
        if (below(random_, 2) == 0) std::shuffle(ids.begin(), ids.end(), random_);
        std::set<Pair> links;
        for (const auto& [a, b] : case_.links) links.insert(std::minmax(ids[a], ids[b]));
        case_.links = std::move(links);
    }

    Cell any(const Mirror& mirror) {
        return std::next(mirror.at.begin(), below(random_, static_cast<std::int64_t>(mirror.at.size())))->first;
    }

    Change give(std::size_t which, Cell to) {
        Change c{.kind = Change::Kind::Give, .cell = to, .given = which};
        for (const auto& [least, most] : given_[which].arguments) c.arguments.push_back(draw(least, most));
        return c;
    }

    std::optional<Change> take(const Mirror& mirror) {
        std::vector<Change> all;
        for (std::size_t g = 0; g < given_.size(); ++g) {
            const auto facts = mirror.facts.find(given_[g].predicate);
            if (given_[g].linear || facts == mirror.facts.end()) continue;
            for (const Row& row : facts->second)
                all.push_back({.kind = Change::Kind::Take,
                               .cell = node(static_cast<std::uint64_t>(row[0])),
                               .given = g,
                               .arguments = Row(row.begin() + 1, row.end())});
        }
        if (all.empty()) return std::nullopt;
        return all[static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(all.size())))];
    }

    std::optional<Change> change_link(const Mirror& mirror, Change::Kind kind) {
        std::vector<Pair> all;
        if (kind == Change::Kind::Heal) {
            all.assign(mirror.missing.begin(), mirror.missing.end());
        } else if (kind == Change::Kind::Cut) {
            for (const auto& [a, ports] : mirror.ports)
                for (const auto& [port, b] : ports)
                    if (a < b) all.emplace_back(a, b);
        } else {
            const std::uint64_t a = mirror.at.at(any(mirror)), b = mirror.at.at(any(mirror));
            const auto full = [&](std::uint64_t id) {
                const auto its = mirror.ports.find(id);
                // Also with all that may be healed, and in a port behind those.
                return its != mirror.ports.end() && !its->second.empty() &&
                       (its->second.size() + mirror.missing.size() >= max_degree_ ||
                        std::cmp_greater_equal(its->second.rbegin()->first + 1, max_degree_));
            };
            if (a != b && !full(a) && !full(b)) all.emplace_back(a, b);
        }
        if (all.empty()) return std::nullopt;
        const auto [a, b] = all[static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(all.size())))];
        return Change{.kind = kind, .cell = node(a), .to = node(b)};
    }

    std::optional<Change> choose(const Mirror& mirror) {
        if (mirror.at.empty()) return std::nullopt;
        const std::int64_t kind = below(random_, 100);
        if (kind < 22) return take(mirror);
        if (kind < 42) return give(static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(given_.size()))), any(mirror));
        if (kind < 50) return Change{.kind = Change::Kind::Remove, .cell = any(mirror)};
        if (kind < 68) return change_link(mirror, Change::Kind::Cut);
        if (kind < 82) return change_link(mirror, Change::Kind::Heal);
        return change_link(mirror, Change::Kind::Join);
    }

    void add_burst(Mirror& mirror) {
        std::vector<Change>& burst = case_.bursts.emplace_back();
        if (case_.bursts.size() == 1)
            for (const Cell& cell : case_.cells)
                for (std::size_t g = 0; g < given_.size(); ++g)
                    if (below(random_, 1000) < given_[g].per_mille) burst.push_back(give(g, cell));
        for (const Change& change : burst) mirror.apply(change);
        const std::int64_t span = 1 + below(random_, 30);
        std::vector<int> ticks(static_cast<std::size_t>(1 + below(random_, below(random_, 5) == 0 ? 60 : 14)));
        for (int& tick : ticks) tick = static_cast<int>(below(random_, span));
        std::sort(ticks.begin(), ticks.end());
        for (const int tick : ticks) {
            std::optional<Change> change = choose(mirror);
            if (!change || !mirror.apply(*change)) continue;
            change->tick = tick;
            burst.push_back(*change);
        }
    }

    Random random_;
    const std::vector<Given>& given_;
    const std::size_t max_degree_;
    Case case_;
    std::int64_t nodes_ = 0;
    std::map<std::uint64_t, std::size_t> degree_;
};

}  // namespace

Case make_graph_case(std::uint64_t seed, const std::vector<Given>& given, std::size_t max_degree) {
    return Maker(seed, given, max_degree).make();
}

}  // namespace meld::retraction
