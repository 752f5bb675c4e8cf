#include "runtime/world/ensemble/links.h"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/release_memory.h"

namespace meld::world {
// An empty table would have no address, by which the form is known.
Links::Links(bool apart) : apart_(apart) { reserve(1, 1); }

void Links::reserve(std::size_t catoms, std::size_t ports) {
    first_.reserve(catoms), ports_.reserve(catoms);
    catom_.reserve(ports);
    change_there([&](auto& there) { there.reserve(ports); });
    if (apart_) read_.reserve(ports);
    if (keeps_last_) last_.reserve(ports);
}

void Links::widen() {
    there_wide_.reserve(there_.capacity());
    there_wide_.assign(there_.begin(), there_.end());
    release_memory(there_);
}

void Links::room(Catom catom, Port ports) {
    if (catom >= first_.size()) {
        // Where one more does not fit, an eighth more does, since all are many.
        constexpr std::size_t kShare = 8;
        if (catom >= first_.capacity() && !first_.empty())
            for (auto* const each : {&first_, &ports_}) each->reserve(catom + catom / kShare + 64);
        first_.resize(catom + std::size_t{1}, static_cast<std::uint32_t>(catom_.size()));
        ports_.resize(catom + std::size_t{1}, 0);
    }
    const Port had = ports_[catom];
    if (had >= ports) return;
    const bool narrow = !wide();
    most_ = std::max(most_, ports);
    if (narrow && wide()) widen();
    const bool last = first_[catom] + std::size_t{had} == catom_.size();
    if (!last && left_behind_ > catom_.size() / 2) compact();
    const std::size_t from = first_[catom], to = last ? from : catom_.size();
    MELD_CHECK(to + ports <= std::numeric_limits<std::uint32_t>::max(), "{} entries of links", to + ports);
    if (catom_.empty() && catom == 0) even_ = ports;
    if (had > 0 || ports != even_ || to != std::size_t{catom} * even_) even_ = 0;
    catom_.resize(to + ports, kNobody);
    if (apart_) read_.resize(to + ports, kNobody);
    change_there([&](auto& there) { there.resize(to + ports, 0); });
    if (keeps_last_) last_.resize(to + ports, passed_);
    if (!last) {
        const auto carry = [&](auto& column, auto empty) {
            using Entry = std::remove_reference_t<decltype(column[0])>;
            for (Port port = 0; port < had; ++port) column[to + port] = std::exchange(column[from + port], static_cast<Entry>(empty));
        };
        carry(catom_, kNobody);
        change_there([&](auto& there) { carry(there, 0); });
        if (apart_) carry(read_, kNobody);
        if (keeps_last_) carry(last_, passed_);
        left_behind_ += had;
        first_[catom] = static_cast<std::uint32_t>(to);
    }
    ports_[catom] = ports;
}

// Writes the rows anew, one after the other.
void Links::compact() {
    const std::size_t kept = catom_.size() - left_behind_;
    const auto rewrite = [&](auto& column) {
        std::remove_reference_t<decltype(column)> made;
        made.reserve(kept);
        for (std::size_t c = 0; c < first_.size(); ++c) {
            const auto from = column.begin() + static_cast<std::ptrdiff_t>(first_[c]);
            made.insert(made.end(), from, from + static_cast<std::ptrdiff_t>(ports_[c]));
        }
        column = std::move(made);
    };
    rewrite(catom_);
    change_there(rewrite);
    if (apart_) rewrite(read_);
    if (keeps_last_) rewrite(last_);
    std::uint32_t next = 0;
    for (std::size_t c = 0; c < first_.size(); ++c) first_[c] = std::exchange(next, next + ports_[c]);
    left_behind_ = 0;
}

void Links::set(Catom catom, Port port, Catom other, Port there) {
    MELD_EXPECT(port < ports(catom) && catom_[entry(catom, port)] == kNobody, "catom {} port {} of {}", catom, port, ports(catom));
    const std::size_t here = entry(catom, port);
    ++version_;
    catom_[here] = static_cast<std::int32_t>(other);
    change_there([&](auto& column) { column[here] = static_cast<std::remove_reference_t<decltype(column[here])>>(there); });
    if (keeps_last_) last_[here] = passed_;
    if (!apart_) return;
    read_[here] = at_start_ ? static_cast<std::int32_t>(other) : kNobody;
    if (!at_start_) changes_.push_back({catom, port, other, kNobody, true});
}

void Links::unset(Catom catom, Port port) {
    const std::size_t here = entry(catom, port);
    ++version_;
    if (apart_) {
        const std::int32_t read = std::exchange(read_[here], kNobody);
        if (!at_start_) changes_.push_back({catom, port, static_cast<Catom>(catom_[here]), read, false});
    }
    catom_[here] = kNobody;
}

void Links::connect(Catom a, Port port_of_a, Catom b, Port port_of_b) {
    set(a, port_of_a, b, port_of_b);
    set(b, port_of_b, a, port_of_a);
}

void Links::disconnect(Catom catom, Port port) {
    const std::optional<Catom> other = at(catom, port);
    MELD_EXPECT(other.has_value(), "catom {} port {}", catom, port);
    const Port there = port_there(catom, port);
    unset(catom, port);
    unset(*other, there);
}

void Links::renew(Catom catom) {
    for (Port port = 0, end = ports(catom); port < end; ++port) {
        const std::optional<Catom> other = at(catom, port);
        if (!other) continue;
        const Port there = port_there(catom, port);
        disconnect(catom, port);
        connect(catom, port, *other, there);
    }
}

void Links::clear(Catom catom) {
    for (Port port = 0, end = ports(catom); port < end; ++port)
        if (at(catom, port)) disconnect(catom, port);
}

std::optional<Port> Links::vacant(Catom catom) const {
    for (Port port = 0, end = ports(catom); port < end; ++port)
        if (!at(catom, port)) return port;
    return std::nullopt;
}

std::optional<Port> Links::towards(Catom catom, Catom other) const {
    for (Port port = 0, end = ports(catom); port < end; ++port)
        if (at(catom, port) == other) return port;
    return std::nullopt;
}

std::vector<Links::Change> Links::take_changes() {
    at_start_ = false;
    return std::exchange(changes_, {});
}

void Links::begin_arrivals(std::int64_t now) {
    passed_ = static_cast<std::uint16_t>(now);
    std::ranges::fill(last_, passed_);
}

void Links::forget_arrivals(std::int64_t now) {
    passed_ = static_cast<std::uint16_t>(now);
    for (std::uint16_t& last : last_)
        if (static_cast<std::int16_t>(last - passed_) <= 0) last = passed_;
}

void Links::add_to(Geometry& g) const {
    g.link_first = first_.data();
    g.link_ports = ports_.data();
    g.link_catom = catom_.data();
    g.link_read = (apart_ ? read_ : catom_).data();
    g.link_there = wide() ? nullptr : there_.data();
    g.link_there_wide = wide() ? there_wide_.data() : nullptr;
    g.most_ports = most_;
}

std::size_t Links::bytes() const {
    const auto size = [](const auto& column) { return column.capacity() * sizeof(column[0]); };
    return size(first_) + size(ports_) + size(catom_) + size(read_) + size(there_) + size(there_wide_) + size(last_) + size(changes_);
}

}  // namespace meld::world
