#include "runtime/driver/shrink/ddmin.h"

#include <algorithm>
#include <numeric>

namespace meld::driver {

namespace {

// The list without one of so many parts of about the same size.
Kept without(const Kept& kept, std::size_t part, std::size_t parts) {
    const std::size_t begin = kept.size() * part / parts, end = kept.size() * (part + 1) / parts;
    Kept rest(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(begin));
    rest.insert(rest.end(), kept.begin() + static_cast<std::ptrdiff_t>(end), kept.end());
    return rest;
}

}  // namespace

Result<Kept> ddmin(std::size_t items, const TryFirst& try_first) {
    Kept kept(items);
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    if (items == 0) return kept;
    const auto nothing = try_first(1, [](std::size_t) { return Kept(); });
    if (!nothing) return tl::unexpected<Error>(nothing.error());
    if (*nothing) return Kept();
    // The part that comes next, counted from the end.
    std::size_t parts = 2, next = 0;
    while (kept.size() > 1) {
        parts = std::min(parts, kept.size());
        const auto part_of = [&](std::size_t i) { return parts - 1 - (next + i) % parts; };
        const auto found = try_first(parts, [&](std::size_t i) { return without(kept, part_of(i), parts); });
        if (!found) return tl::unexpected<Error>(found.error());
        if (*found) {
            kept = without(kept, part_of(**found), parts);
            next = (next + **found) % parts;
            parts = std::max<std::size_t>(parts - 1, 2);
            next %= parts;
        } else if (parts == kept.size()) {
            break;
        } else {
            parts *= 2;
            next = 0;
        }
    }
    return kept;
}

}  // namespace meld::driver
