#include "compiler/lint/differences.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace meld::lint {

using namespace check;

std::optional<std::size_t> Differences::node(const std::string& name) {
    if (const auto found = nodes_.find(name); found != nodes_.end()) return found->second;
    const std::size_t count = bounds_.size();
    if (count == kMaxNodes) return std::nullopt;
    nodes_.emplace(name, count);
    for (std::vector<Entry>& row : bounds_) row.emplace_back();
    bounds_.emplace_back(count + 1);
    bounds_[count][count].known = true;
    return count;
}

std::optional<Differences::Reasons> Differences::refutes(const Bound& bound) const {
    const Entry& back = bounds_[bound.y][bound.x];
    if (!back.known || back.most + bound.most >= 0) return std::nullopt;
    return back.why;
}

std::optional<std::pair<std::int64_t, Differences::Reasons>> Differences::most(std::size_t x, std::size_t y) const {
    const Entry& e = bounds_[x][y];
    return e.known ? std::optional(std::pair(e.most, e.why)) : std::nullopt;
}

bool Differences::learn(const Bound& bound, const Reasons& why) {
    const Entry& known = bounds_[bound.x][bound.y];
    if (known.known && known.most <= bound.most) return false;
    // Bounds that end in x or begin in y do not change meanwhile: a path through the new bound twice would be a cycle.
    std::vector<Entry> to, from = bounds_[bound.y];
    for (const std::vector<Entry>& row : bounds_) to.push_back(row[bound.x]);
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
        if (!to[i].known) continue;
        for (std::size_t j = 0; j < bounds_.size(); ++j) {
            if (!from[j].known || i == j) continue;
            const std::int64_t most = to[i].most + bound.most + from[j].most;
            Entry& e = bounds_[i][j];
            // Cheap to check before the reasons are combined.
            if (e.known && most > e.most) continue;
            Reasons all = joined(joined(to[i].why, why), from[j].why);
            if (better(most, all.size(), e)) e = {.most = most, .why = std::move(all), .known = true};
        }
    }
    return true;
}

Differences::Reasons joined(Differences::Reasons a, const Differences::Reasons& b) {
    a.insert(a.end(), b.begin(), b.end());
    std::sort(a.begin(), a.end(), [](const Term* x, const Term* y) {
        return std::tuple(x->span.file, x->span.begin, x->span.end, x) < std::tuple(y->span.file, y->span.begin, y->span.end, y);
    });
    a.erase(std::unique(a.begin(), a.end()), a.end());
    return a;
}

}  // namespace meld::lint
