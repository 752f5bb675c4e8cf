// Sets a subdomain up from a snapshot instead of from the world. Every process reads what all have written and takes the catoms that
// are its own now, and ghosts of those next to them.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/sim/state/cell_places.h"
#include "runtime/sim/state/failed.h"
#include "runtime/sim/state/free_places.h"
#include "runtime/sim/state/placed_chunk.h"
#include "runtime/sim/state/saver.h"
#include "runtime/sim/state/take_over.h"

namespace meld::sim {

// What a run makes of a snapshot.
enum class Loads {
    GoesOn,       // The same run, as if it had never stopped.
    BranchesOff,  // Another run with all that the one of the snapshot has; what happens later may differ, and so may what looks on.
    LooksAgain,   // The same in a world with another target, which all catoms sense in the next tick.
    Anew,         // The same of a program that has changed: what rules derive is derived anew.
};

class Loader {
  public:
    // The subdomain is new.
    Loader(Subdomain& subdomain, const Shares& shares, Loads how = Loads::GoesOn) : subdomain_(subdomain), shares_(shares), how_(how) {}

    // Catoms, what they hold, the tick, and what modules keep, which are resumed when the catoms are there. Returns what the run had
    // counted. Every process calls it. Errors: a share cannot be read or says what cannot be. Cost: the numbers and places of all
    // catoms are read twice on each process, at arbitrary positions five times, and the chunks that have something for it once.
    Result<Block> run(const Modules& modules, CodeModules& codes);
    // Only the catoms, where they are and the facts that they hold, for somebody who looks at them and does not go on. Where catoms at
    // arbitrary positions are is for `place` to find in what the motion, the first of all modules, has saved for those of a chunk.
    using Place = std::function<Result<void>(Subdomain&, std::span<const tuple::SavedCatom>, ByteReader&)>;
    Result<void> facts(const Place& place);
    // After run() with Loads::Anew.
    const TakenOver& taken_over() const { return taken_over_; }

  private:
    Result<CellPlaces> places(std::size_t share, std::size_t chunk);
    // Calls visit(share, chunk) for each, until one fails.
    template <class Visit>
    Result<void> each_chunk(const Visit& visit) {
        for (std::size_t share = 0; share < shares_.count(); ++share)
            for (std::size_t chunk = 0; chunk < shares_.chunks(share); ++chunk)
                if (Result<void> done = visit(share, chunk); !done) return done;
        return {};
    }
    // Catoms by brick or home.
    using CountOf = std::unordered_map<world::BrickKey, std::uint32_t>;
    Result<void> count_bricks(CountOf& count_of);
    Result<void> divide();
    Result<void> add_catoms();
    Result<void> add_cells();
    // Calls rest(catoms, reader) for what modules keep for the catoms of each chunk.
    using Rest = std::function<Result<void>(std::span<const tuple::SavedCatom>, ByteReader&)>;
    Result<void> load_catoms(const Rest& rest);
    // Catoms at arbitrary positions (free_loader.cpp).
    struct Free;
    // Calls visit(chunk, places), chunks counted over all shares.
    template <class Visit>
    Result<void> each_places(const Visit& visit);
    Result<void> count_homes(CountOf& count_of);
    // Nodes of a graph (graph_loader.cpp).
    Result<FreePlaces> nodes(std::size_t share, std::size_t chunk);
    Result<void> add_nodes();
    Result<void> add_freely();
    Result<void> add_own(Free& free);
    Result<void> add_ghosts(Free& free);
    Result<void> link(const FreePlaces& all, std::span<const tuple::SavedCatom> here);
    // What a share says first at its end: how facts are stored, who kept something, and what has failed.
    struct Head {
        Block schema;
        std::vector<std::string> modules;
        Block failed;
    };
    static Head read_head(ByteReader& in);
    Result<void> prepare(const Modules& modules);
    Result<void> read_failed();
    Result<void> load_rest(CodeModules& codes, Block& counters);
    void load_totals(const Totals& saved);

    Subdomain& subdomain_;
    const Shares& shares_;
    Loads how_;
    Block room_;                                   // For blocks that are read.
    std::size_t mine_ = 0;                         // How many catoms are this process's.
    std::uint64_t bodies_ = 0;                     // Catoms at arbitrary positions, of all processes.
    std::vector<std::vector<PlacedChunk>> found_;  // By share and chunk.
    // By chunk of all shares. They are read several times; where there is no other process, all are here anyway, and read once.
    std::vector<FreePlaces> free_places_;
    std::vector<SimModule*> kept_by_;  // By the modules of the snapshot; none: nobody here reads that.
    Failed failed_;
    std::optional<TakeOver> take_over_;
    TakenOver taken_over_;
};

}  // namespace meld::sim
