// Sets a subdomain up from a snapshot instead of from the world. Every process reads what all have written and takes the catoms that
// are its own now, and ghosts of those next to them.
#pragma once

#include <functional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "runtime/sim/state/free_places.h"
#include "runtime/sim/state/saver.h"

namespace meld::sim {

class Loader {
  public:
    // The subdomain is new.
    Loader(Subdomain& subdomain, const Shares& shares) : subdomain_(subdomain), shares_(shares) {}

    // Catoms, what they hold, the tick, and what modules keep, which are resumed when the catoms are there. Returns what the run had
    // counted. Every process calls it. Errors: a share cannot be read or says what cannot be. Cost: the numbers and places of all
    // catoms are read twice on each process, at arbitrary positions three times, and the chunks that have something for it once.
    Result<Block> run(const Modules& modules, CodeModules& codes);
    // Only the catoms, where they are and the facts that they hold, for somebody who looks at them and does not go on. Where catoms at
    // arbitrary positions are is for `place` to find in what the motion, the first of all modules, has saved for those of a chunk.
    using Place = std::function<Result<void>(Subdomain&, std::span<const tuple::SavedCatom>, ByteReader&)>;
    Result<void> facts(const Place& place);

  private:
    struct Places {
        std::vector<std::uint64_t> ids;
        std::vector<Cell> cells;
    };
    // Where the catoms of one chunk are here; empty if none is.
    using Found = std::vector<tuple::SavedCatom>;

    Result<Places> places(std::size_t share, std::size_t chunk) const;
    // Calls visit(share, chunk) for each, until one fails.
    template <class Visit>
    Result<void> each_chunk(const Visit& visit) const {
        for (std::size_t share = 0; share < shares_.count(); ++share)
            for (std::size_t chunk = 0; chunk < shares_.chunks(share); ++chunk)
                if (Result<void> done = visit(share, chunk); !done) return done;
        return {};
    }
    // Catoms by brick or home.
    using CountOf = std::unordered_map<world::BrickKey, std::uint32_t>;
    Result<void> count_bricks(CountOf& count_of) const;
    Result<void> divide();
    Result<void> add_catoms();
    Result<Found> add(const Places& all);
    // Calls rest(catoms, reader) for what modules keep for the catoms of each chunk.
    using Rest = std::function<Result<void>(std::span<const tuple::SavedCatom>, ByteReader&)>;
    Result<void> load_catoms(const Rest& rest);
    // Catoms at arbitrary positions (free_loader.cpp).
    Result<FreePlaces> free_places(std::size_t share, std::size_t chunk) const;
    Result<void> count_homes(CountOf& count_of) const;
    Result<void> add_freely();
    Result<void> add_own(const FreePlaces& all, Found& found, std::unordered_set<std::uint64_t>& beside);
    Result<void> add_ghosts(const FreePlaces& all, Found& found, const std::unordered_set<std::uint64_t>& beside);
    Result<void> link(Catom catom, std::span<const FreePlaces::Link> links);
    Result<void> load_rest(const Modules& modules, CodeModules& codes, Block& counters);

    Subdomain& subdomain_;
    const Shares& shares_;
    std::vector<std::vector<Found>> found_;  // By share and chunk.
};

}  // namespace meld::sim
