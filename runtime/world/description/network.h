// What a world says of its network and its clock: how long a change takes over a link, what is lost, and when a catom acts. All draws are
// functions of the seed, the ids of the catoms and the tick, so they are the same on any number of processes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

// Of delays and pauses: quarantines last as long for each rank.
inline constexpr std::uint32_t kMostTicks = 10'000;

enum class NetworkKind { Ideal, Latency, Lossy, Raw };

// How a link behaves.
struct LinkTerms {
    // Ticks from a change to its arrival. Lossy: if nothing of it is lost.
    std::uint32_t least = 1, most = 1;
    double loss = 0;          // The probability that a message is lost.
    std::uint32_t retry = 1;  // Lossy: ticks until a message that was lost is sent again,
    std::uint32_t tries = 8;  // and how often it is sent at most, the first time included; then the link is down.
    double duplicate = 0;     // Raw: the probability that a message arrives twice.
    bool reorder = false;     // Raw: messages may overtake each other.

    // The most ticks that anything is under way.
    std::uint32_t bound() const { return most + (tries - 1) * retry; }
};

// How a linear fact reaches a node of a graph that is known only by its number: over a shortest route of links, or in one hop.
enum class Reach { Links, Any };

struct NetworkOptions {
    NetworkKind kind = NetworkKind::Ideal;
    std::optional<Reach> reach;  // Otherwise over links, and in one hop for programs that make nodes.
    LinkTerms terms;
    // Links of catoms in a region; the last region that contains either end counts.
    struct Part {
        Region where;
        LinkTerms terms;
        std::string place = {};
    };
    std::vector<Part> parts;
    // What single links are like, in one direction, whatever the parts say; by both ends.
    struct Single {
        std::uint64_t from = 0, to = 0;
        LinkTerms terms;
        std::uint64_t line = 0;  // In the file.
    };
    std::vector<Single> singles;
    std::string singles_path;  // The file.
    // Ticks from the end of a catom until its neighbours sense it.
    std::uint32_t detect = 0;
    bool ideal() const { return kind == NetworkKind::Ideal; }
    // Of all links.
    std::uint32_t bound() const;
    // Nothing: it says nothing of this link in particular. Cost: a binary search.
    std::optional<std::uint32_t> single(std::uint64_t from, std::uint64_t to) const;
};

// What happens to all that one catom sends to another in one tick, which travels together.
struct Fate {
    bool arrives = true;
    std::uint32_t ticks = 1;        // Until it arrives; if it does not, until the link is known to be down.
    std::uint32_t twice_after = 0;  // Raw: ticks until it arrives once more; 0: it does not.
};
// Cost: a draw of random numbers, for Lossy one for each loss.
Fate fate(NetworkKind kind, const LinkTerms& terms, std::uint64_t seed, std::uint64_t from, std::uint64_t to, std::int64_t tick);
// The same for several links of one catom with the same terms. Cost: half as much for each.
void fates(NetworkKind kind, const LinkTerms& terms, std::uint64_t seed, std::uint64_t from, std::span<const std::uint64_t> to,
           std::int64_t tick, std::span<Fate> out);

// The ticks alone, of a network that loses nothing (Latency).
void delays(const LinkTerms& terms, std::uint64_t seed, std::uint64_t from, std::span<const std::uint64_t> to, std::int64_t tick,
            std::span<std::uint32_t> out);

// Priority and Sequential give turns, by what waits (runtime/sim/network/turns.h); the others go by numbers and ticks alone.
enum class ClockKind { Synchronous, Random, Drift, Priority, Sequential };

struct ClockOptions {
    ClockKind kind = ClockKind::Synchronous;
    double rate = 1;         // Random: the probability that a catom acts in a tick.
    std::uint32_t most = 1;  // Random and Drift: no catom acts less often than every so many ticks.
    bool synchronous() const { return kind == ClockKind::Synchronous; }
    bool gives_turns() const { return kind == ClockKind::Priority || kind == ClockKind::Sequential; }

    // Whether a catom acts in a tick, where no turns are given: there it does whenever it has its turn. Cost: a draw of random numbers.
    bool acts(std::uint64_t seed, std::uint64_t id, std::int64_t tick) const;
    // The first tick from this one on in which it acts. Cost: a draw for each tick until then, and one.
    std::int64_t next(std::uint64_t seed, std::uint64_t id, std::int64_t tick) const;
};

}  // namespace meld::world
