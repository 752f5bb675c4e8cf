// Everything one part holds during a run: its catoms, columns, agenda, and what it says to other parts.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/abi/module_abi.h"
#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/parallel_for.h"
#include "runtime/comm/communicator.h"
#include "runtime/eval/evaluator.h"
#include "runtime/partition/partition.h"
#include "runtime/tuple/columns.h"
#include "runtime/tuple/values.h"
#include "runtime/world/ensemble.h"
#include "runtime/world/target.h"
#include "runtime/world/world_file.h"

namespace meld::sim {

using world::Catom;
using world::Cell;
using world::CellKey;

// What every part tells every other at the end of a tick, summed up.
struct Totals {
    eval::Statistics tick;  // Of this tick.
    std::uint64_t catoms = 0;
    std::uint64_t bytes = 0;
    std::uint64_t actions = 0;
    std::uint64_t births_wanted = 0;  // `create` actions among them.
    std::uint64_t teleports = 0;      // `moveTo` actions among them.
    std::uint64_t sent_bytes = 0;     // Between parts.
    bool awake = false;               // Something is left to do: an agenda, a message, an action.
    bool waiting = false;             // Only timers are left.
    bool stop = false;                // Somebody outside asked for the end.
    bool finished = false;            // A catom did, with `stop-program`.
    std::uint32_t greatest_rank = 0;
    eval::Failure failure;
};

// The cell whose centre is nearest to a place that is given in diameters.
Cell nearest_cell(const world::Vec3& position);

class PartState {
  public:
    PartState(const ModuleInfo& module, const world::World& world, const world::Target& target, comm::Communicator& comm, int threads);
    ~PartState();

    // ---- set-up (setup.cpp)
    // Places the catoms of this part and its ghosts, gives them their ids and the world's facts. Every part calls it.
    Result<void> populate();

    // ---- the tick (tick.cpp)
    void begin_tick();
    // What the world's events give and take in this tick; after catoms have moved.
    void happen();
    // Evaluates, commits, exchanges, and agrees with the other parts on what happened.
    const Totals& end_tick();
    // On every part, after a tick that failed: the time is that of the last tick again, and all know whether some are half-way.
    void end_early();

    // ---- for central modules
    // Facts given from outside: the catom and, where neighbours read them, its readers are marked.
    bool give(u32 predicate, Catom catom, const Value* arguments);
    void give_all(u32 predicate, Catom catom, std::vector<const Value*>& facts);
    bool take(u32 predicate, Catom catom, const Value* arguments);
    void mark(Catom catom, u64 bits) { evaluator.agenda().mark(catom, bits); }
    // The same from all workers at once.
    void mark_shared(Catom catom, u64 bits) {
        if (workers.threads() > 1)
            evaluator.agenda().mark_shared(catom, bits);
        else
            mark(catom, bits);
    }
    // Catoms come and go; links around the cell are marked. Arrays may move.
    Catom add_catom(std::uint64_t id, Cell cell, CatomState state);
    void remove_catom(Catom catom);
    // Within this part; the catom keeps its index.
    void move_catom(Catom catom, Cell to);
    // Marks the catoms next to a cell, or to a catom.
    void mark_around(Cell cell, u64 bits);
    void mark_neighbours(Catom catom, u64 bits);
    // The actions of the last tick for this predicate.
    std::vector<eval::Action>& actions() { return evaluator.actions(); }
    // The same where catoms move freely. A ghost has an owner, and goes when nothing of this part touches it any more.
    Catom add_freely(std::uint64_t id, const world::Vec3& position, CatomState state, int owner);
    void remove_freely(Catom catom);
    // The part whose catom this is.
    int owner_of(Catom catom) const;
    // Brings Part's pointers up to date after any of the above.
    void refresh();

    // All of a catom, to follow it to another part.
    void pack_catom(Catom catom, ByteWriter& out) const;
    void unpack_catom(Catom catom, ByteReader& in);

    bool alone() const { return comm.parts() == 1; }
    bool owned(Catom catom) const { return ensemble.state(catom) == kCatomOwned; }
    std::size_t bytes() const;

    const ModuleInfo& module;
    const world::World& world;
    comm::Communicator& comm;
    world::Lattice lattice;
    world::Ensemble ensemble;
    Workers workers;
    tuple::Columns columns;
    eval::Evaluator evaluator;
    std::optional<partition::Partition> partition;
    std::optional<partition::Halo> halo;
    Part abi;
    std::vector<Value> parameters;
    Totals totals;
    std::uint64_t next_id = 0;
    // Where catoms move freely: what they were told of their places (empty if the program does not read them), and, until motion
    // has started, the cells they start in.
    std::vector<world::Vec3> sensed_positions;
    const bool reads_places;
    world::Vec3 sensed_position(Catom catom) const { return sensed_positions.empty() ? ensemble.position(catom) : sensed_positions[catom]; }
    // A catom's diameter in those of the world; empty where all have the world's.
    std::function<double(Catom)> diameter_of;
    std::vector<std::int32_t> owners;  // Of catoms that move freely, by index; empty where there is one part.
    std::vector<Cell> start_cells;
    // The last tick that went well to its end.
    std::int64_t last_tick = 0;
    // A tick that fails has changed facts, or the links that they stand on: they are no longer those of the last tick.
    bool half_way = false;
    // Something moves by itself, so the run goes on though no program has anything to do.
    bool moving = false;
    // Seconds of wall clock that the ticks have taken.
    double evaluation_s = 0, exchange_s = 0;
    std::size_t motion_bytes = 0;  // Held by what moves it.
    // Set from a signal handler or a module: the run is to end at this tick boundary.
    bool stop_requested = false;

  private:
    // tick.cpp
    // A linear or given fact that has come for a catom of this part in this tick.
    struct Arrival {
        Catom to;
        u16 predicate;
        const Value* arguments;
    };
    // Gives them all, many for one catom at once; they are seen in the next tick.
    void deliver(std::vector<Arrival>& arrivals);
    // Changed: the other side has the column as it was before this tick, and rows may be sent alone.
    enum class Pushed { Changed, Whole };
    void note_export(int thread, Catom catom, u16 column, Pushed what);
    // Calls visit(part) once for each other part that reads what this catom exports.
    template <class Visit>
    void listeners(Catom catom, const Visit& visit) const;
    // How parts name a catom to each other: by its cell, or where there are none by its number.
    void write_name(ByteWriter& out, Catom catom) const;
    Catom read_name(ByteReader& in, int sender) const;
    void write_export(ByteWriter& out, Catom catom, u16 column, Pushed what) const;
    void exchange();
    // What a packet says; the facts in it are added to the arrivals, their arguments and lists to the other two.
    void receive(const comm::Packet& packet, std::vector<Arrival>& arrivals, std::deque<std::vector<Value>>& arguments,
                 tuple::Arena& lists);
    void agree();

    // setup.cpp
    enum class Given { Check, Give, Take };
    // Gives the fact to the catoms of its region, or takes it from them; Check only says what is wrong with it.
    // `matched` counts the catoms on this part; under Check it says whether there are any.
    Result<void> change_given(const world::GivenFact& fact, Given how, u64* matched = nullptr);
    // For regions: where catoms move freely, the cell in which it starts, later that whose centre would be nearest.
    Cell cell_in_regions(Catom catom) const;
    void populate_cells(const std::vector<std::pair<world::BrickKey, std::uint32_t>>& counts);
    void populate_freely(const std::vector<std::pair<world::BrickKey, std::uint32_t>>& counts);
    Result<void> given_facts();
    void warn_of_nobody(const std::vector<const world::GivenFact*>& facts, std::vector<u64> matched);
    void warn_of_missing_catoms();
    Result<void> set_parameters();
    Result<void> check_length(const std::string& what);

    struct Export {
        Catom catom;
        u16 column;
        Pushed what;
    };
    // [thread][destination]
    std::vector<std::vector<std::vector<Export>>> outgoing_;
    std::vector<ByteWriter> packets_;  // [destination]
    // What arrives in a tick, and its order; kept so that a tick allocates nothing.
    struct Delivery {
        std::vector<Arrival> arrivals;
        std::vector<Keyed> order, spare;
        std::vector<Arrival> sorted;
        std::vector<const Value*> together;
        std::vector<u8> rows;
    };
    Delivery delivery_;
    std::uint64_t sent_bytes_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace meld::sim
