#include "runtime/world/description/network.h"

#include <algorithm>
#include <array>
#include <utility>

#include "runtime/base/random.h"

namespace meld::world {
namespace {

// What draws are for, so that those of links and clocks differ.
enum Use : std::uint64_t { kOfLink = 0x6c696e6b, kOfClock = 0x636c6f636b };

double unit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

std::uint32_t between(std::uint64_t bits, std::uint32_t least, std::uint32_t most) {
    const std::uint64_t span = std::uint64_t{most} - least + 1;
    return least + static_cast<std::uint32_t>((bits >> 32) * span >> 32);
}

// Ids are far below 2^48, so the number of the draw does not meet them.
std::uint64_t of_draw(std::uint64_t from, std::uint64_t number) { return from | number << 48; }

// bits(number): those of a draw, from 0 on.
template <class Bits>
Fate fate_by(NetworkKind kind, const LinkTerms& terms, const Bits& bits) {
    std::uint64_t draws = 0;
    const auto draw = [&] { return bits(draws++); };
    const auto delay = [&] { return terms.least == terms.most ? terms.least : between(draw(), terms.least, terms.most); };
    Fate out;
    out.ticks = delay();
    switch (kind) {
        case NetworkKind::Ideal:
        case NetworkKind::Latency:
            return out;
        case NetworkKind::Lossy:
            for (std::uint32_t sent = 1; unit(draw()) < terms.loss; ++sent) {
                if (sent == terms.tries) {
                    out.arrives = false;
                    return out;
                }
                out.ticks += terms.retry;
            }
            return out;
        case NetworkKind::Raw:
            out.arrives = unit(draw()) >= terms.loss;
            if (out.arrives && unit(draw()) < terms.duplicate) out.twice_after = delay();
            return out;
    }
    return out;
}

}  // namespace

std::uint32_t NetworkOptions::bound() const {
    if (ideal()) return 1;
    const auto of = [this](const LinkTerms& t) { return kind == NetworkKind::Lossy ? t.bound() : t.most; };
    std::uint32_t most = of(terms);
    for (const Part& part : parts) most = std::max(most, of(part.terms));
    for (const Single& one : singles) most = std::max(most, of(one.terms));
    return most;
}

std::optional<std::uint32_t> NetworkOptions::single(std::uint64_t from, std::uint64_t to) const {
    if (singles.empty()) return std::nullopt;
    const auto ends = [](const Single& one) { return std::pair(one.from, one.to); };
    const auto at = std::ranges::lower_bound(singles, std::pair(from, to), {}, ends);
    if (at == singles.end() || ends(*at) != std::pair(from, to)) return std::nullopt;
    return static_cast<std::uint32_t>(at - singles.begin());
}

Fate fate(NetworkKind kind, const LinkTerms& terms, std::uint64_t seed, std::uint64_t from, std::uint64_t to, std::int64_t tick) {
    return fate_by(kind, terms, [&](std::uint64_t number) {
        return random_bits(seed ^ kOfLink, of_draw(from, number), to, static_cast<std::uint64_t>(tick));
    });
}

void fates(NetworkKind kind, const LinkTerms& terms, std::uint64_t seed, std::uint64_t from, std::span<const std::uint64_t> to,
           std::int64_t tick, std::span<Fate> out) {
    const auto now = static_cast<std::uint64_t>(tick);
    // What every link draws is drawn for all of them together.
    constexpr std::size_t kTogether = 16, kMostSure = 2;
    const bool delays = terms.least != terms.most, loses = kind == NetworkKind::Lossy || kind == NetworkKind::Raw;
    const std::size_t sure = std::size_t{delays} + std::size_t{loses};
    std::array<std::array<std::uint64_t, kTogether>, kMostSure> drawn;
    for (std::size_t first = 0; first < to.size(); first += kTogether) {
        const std::span<const std::uint64_t> some = to.subspan(first, std::min(kTogether, to.size() - first));
        for (std::size_t number = 0; number < sure; ++number)
            random_bits(seed ^ kOfLink, of_draw(from, number), some, now, {drawn[number].data(), some.size()});
        if (kind == NetworkKind::Latency) {
            for (std::size_t i = 0; i < some.size(); ++i)
                out[first + i] = {.ticks = delays ? between(drawn[0][i], terms.least, terms.most) : terms.least};
            continue;
        }
        for (std::size_t i = 0; i < some.size(); ++i)
            out[first + i] = fate_by(kind, terms, [&](std::uint64_t number) {
                return number < sure ? drawn[number][i] : random_bits(seed ^ kOfLink, of_draw(from, number), some[i], now);
            });
    }
}

void delays(const LinkTerms& terms, std::uint64_t seed, std::uint64_t from, std::span<const std::uint64_t> to, std::int64_t tick,
            std::span<std::uint32_t> out) {
    if (terms.least == terms.most) {
        std::ranges::fill(out.first(to.size()), terms.least);
        return;
    }
    constexpr std::size_t kTogether = 16;
    std::array<std::uint64_t, kTogether> drawn;
    for (std::size_t first = 0; first < to.size(); first += kTogether) {
        const std::span<const std::uint64_t> some = to.subspan(first, std::min(kTogether, to.size() - first));
        random_bits(seed ^ kOfLink, of_draw(from, 0), some, static_cast<std::uint64_t>(tick), {drawn.data(), some.size()});
        for (std::size_t i = 0; i < some.size(); ++i) out[first + i] = between(drawn[i], terms.least, terms.most);
    }
}

std::int64_t ClockOptions::next(std::uint64_t seed, std::uint64_t id, std::int64_t tick) const {
    if (synchronous() || gives_turns()) return tick;
    const std::uint64_t own = random_bits(seed ^ kOfClock, id, 0, 0);
    const std::uint64_t period = kind == ClockKind::Drift ? between(own, 1, most) : most;
    const auto now = static_cast<std::uint64_t>(tick);
    // When it acts at the latest.
    const std::uint64_t latest = now + (period - (now + (own & 0xffff)) % period) % period;
    std::uint64_t at = now;
    if (kind == ClockKind::Drift) at = latest;
    while (at < latest && unit(random_bits(seed ^ kOfClock, id, at, 1)) >= rate) ++at;
    return static_cast<std::int64_t>(at);
}

bool ClockOptions::acts(std::uint64_t seed, std::uint64_t id, std::int64_t tick) const {
    if (synchronous() || gives_turns()) return true;
    const auto now = static_cast<std::uint64_t>(tick);
    if (kind == ClockKind::Random && unit(random_bits(seed ^ kOfClock, id, now, 1)) < rate) return true;
    const std::uint64_t own = random_bits(seed ^ kOfClock, id, 0, 0);
    return (now + (own & 0xffff)) % (kind == ClockKind::Drift ? between(own, 1, most) : most) == 0;
}

}  // namespace meld::world
