// What a world says: lattice, bodies, target, facts, events, motion, network, record, limits. Read by runtime/world/file/world_file.h.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/world/description/failures.h"
#include "runtime/world/description/network.h"
#include "runtime/world/description/physics_options.h"
#include "runtime/world/graph/graph.h"
#include "runtime/world/lattice/lattice.h"
#include "runtime/world/shapes/robots.h"
#include "runtime/world/shapes/shape.h"

namespace meld::world {

class MoveTable;

// One fact given by the world: predicate, literal arguments after the catom, and the catoms that get it.
struct GivenFact {
    std::string predicate;
    std::vector<std::string> arguments;  // Meld literals as text: "12", "0.5", "true", "@3", "[1, 2]".
    Region where;
    std::string place;  // "world.toml:12:5", for errors found later.
};

// Events during the run, at the start of a tick: what fails, in this order, then facts that are taken back and given.
struct Event {
    std::int64_t tick = 0;   // The first time; from 1.
    std::int64_t every = 0;  // Ticks between two repetitions, if there are several.
    std::int64_t times = 1;
    std::vector<GivenFact> give = {}, take = {};
    std::vector<CatomChoice> kill = {}, hang = {}, restart = {};
    std::vector<LinkChoice> cut = {}, heal = {}, join = {};
    std::vector<Jam> jam = {};
    std::optional<Vec3> gravity = {};  // From the motion of this tick on, m/s^2.
    bool strikes_catoms() const { return !kill.empty() || !hang.empty() || !restart.empty(); }
    bool strikes_links() const { return !cut.empty() || !heal.empty() || !join.empty(); }
    bool happens_in(std::int64_t now) const {
        return now == tick || (every > 0 && now > tick && (now - tick) % every == 0 && (now - tick) / every < times);
    }
    std::int64_t last() const { return tick + (times - 1) * every; }
    // Its last time up to now, or 0.
    std::int64_t latest(std::int64_t now) const;
};

// Catoms that run another program than the others. Later ones override earlier ones.
struct ProgramRegion {
    Region where;
    std::uint32_t number = 0;  // Of the program: World::programs[number - 1].
    std::string place;
};

// [motion] kind = "amoebot".
struct AmoebotOptions {
    // Which amoebots are activated in a tick: all of them; one, drawn by the seed; some that are too far apart to notice each other, drawn
    // by the seed; the same so that each is activated once in a round.
    enum class Activation { All, One, Random, Fair } activation = Activation::All;
    // Whether each has a compass and a chirality of its own, drawn by the seed.
    bool own_compass = false, own_chirality = false;
};

// [links] range = 3: nodes of a graph, or bodies, are neighbours if their centres are at this distance or less. Lengths are in diameters.
struct RangeOptions {
    double range = 0;
    // Standard deviations of what catoms sense: of distances, and of the angles of bearings, in radians.
    double distance_noise = 0, bearing_noise_rad = 0;
    // sight = true: nothing may be between two neighbours. Of points: how thick those in between are, and what else is in the way.
    bool sight = false;
    double thickness = 1;
    std::vector<ObstacleOptions> obstacles = {};
};

struct MotionOptions {
    std::string kind = "none";    // "none", "lattice", "amoebot", "bodies", "points", or a name that a SimModule registered.
    int capacity = 1;             // Units of resource a catom can hold besides itself.
    bool keep_connected = false;  // Refuse moves of articulation points.
    // [motion] moves = "pivoting", and [[motion.move]]: how catoms on a lattice can move. Null: as each action says.
    std::shared_ptr<const MoveTable> moves;
    AmoebotOptions amoebots;
    // [motion] kind = "points": the longest way of a node in a tick, in diameters.
    double speed = std::numeric_limits<double>::infinity();
};

struct RecordOptions {
    int every = 1;
    std::vector<std::string> predicates;
};

struct Limits {
    // Nothing: what memory holds, or a few where rules may make facts without end (fact_limits()).
    std::optional<std::uint64_t> max_facts_per_catom = {};
    std::optional<std::uint64_t> max_derivations_per_tick = {};  // By one catom.
    std::uint64_t max_ticks = 10'000'000;
    std::uint64_t max_list = 1'000'000;  // Elements of a list, bytes of a string.
    std::uint64_t memory_bytes = 0;      // 0: all the memory that the machine has.
};

struct World {
    std::string path;
    LatticeKind lattice = LatticeKind::Cubic;
    // Whose numbers ports have; null: the lattice's own.
    const PortNumbers* ports = nullptr;
    // lattice = "graph": nodes and links instead of cells. Then `lattice` means nothing, and `body`, `cells` and `placed` are empty.
    std::shared_ptr<const graph::Graph> graph;
    std::string generator;              // If the graph is generated: "ring(1000)".
    std::optional<RangeOptions> links;  // If links follow from the places of nodes or bodies.
    double radius = 0.5;  // Metres; used only by recordings and physics. A diameter is twice this, even if catoms have several sizes.
    Shape body;           // Union of all [[body]] shapes.
    // Cells listed by [[body]] cells = "file.csv" or cells = [[x,y,z], ...]: each once, sorted by Lattice::key. They may also lie in
    // `body`. See sort_cells.
    std::vector<Cell> cells;
    // Additional catoms at listed positions, in the order listed; only if catoms move freely.
    std::vector<PlacedCatom> placed;
    // Which of these are parts of robots; null: the world describes none.
    std::shared_ptr<const Robots> robots;
    std::optional<Shape> target;
    // [target] cells = N: only N cells of the target are to be filled; cells = "mass": as many as there is mass, which is the number of
    // catoms times (1 + held). Target (target.h) chooses them.
    std::optional<std::uint64_t> target_cells;
    bool target_is_mass = false;
    // [target] fit = "mass": the shape is scaled until it contains exactly as many cells as there is mass.
    bool target_fits_mass = false;
    int held = 0;  // Units of resource each catom starts with.
    std::vector<ProgramRegion> program_regions;
    std::vector<std::string> programs;  // The files of these programs, each once.
    std::vector<GivenFact> facts;
    std::vector<Event> events;
    std::vector<Faults> faults;
    std::uint32_t longest_jam = 0;           // The most ticks by which jams, one after the other, make a message late.
    std::map<std::string, std::string> set;  // Values for the program's constants, as Meld literals.
    MotionOptions motion;
    PhysicsOptions physics;  // If motion.kind is "bodies".
    NetworkOptions network;
    ClockOptions clock;
    RecordOptions record;
    Limits limits;
    std::map<std::string, std::string> components;  // [components] interface = "implementation"
    std::uint64_t seed = 1;
    double tick_seconds = 1e-3;  // The duration of a tick, for the delays of a program.
    // The text of the file, and a hash of it and of the files it names, by which processes check that they have the same world.
    std::string text;
    std::uint64_t source_hash = 0;
    std::vector<std::string> files;  // The paths of these, in the order in which the hash takes them.
    // Neighbours are known by a table of links, not by geometry; programs are compiled for it.
    bool by_links = false;
    // What is doubtful about files that it names, as sentences without a full stop.
    std::vector<std::string> warnings;
    // A hash of each section and key at the top, whatever its layout and comments, and under "files" of the files that it names.
    std::map<std::string, std::uint64_t> parts;

    // Whether catoms are bodies at arbitrary positions whose neighbours are the catoms they touch; otherwise they are on cells.
    bool is_free() const { return motion.kind == "bodies"; }
    // Whether catoms occupy one or two cells.
    bool has_amoebots() const { return motion.kind == "amoebot"; }
    // Whether catoms are the nodes of a graph, whose neighbours are those that they have a link with.
    bool is_graph() const { return graph != nullptr; }
    // Whether nodes move, and their links with them: then those of `graph` are only the first ones.
    bool has_moving_nodes() const { return is_graph() && motion.kind == "points"; }
    // The cells, with ports as the program numbers them. Where ports do not matter, Lattice(lattice) is the same.
    Lattice cells_and_ports() const { return Lattice(lattice, ports); }
    std::string_view ports_name() const { return ports != nullptr ? ports->name : kLatticePorts; }
    // "graph", or the name of the lattice.
    std::string_view lattice_name() const { return is_graph() ? "graph" : Lattice(lattice).name(); }
    // Whether what catoms read of their neighbours lies apart from these, as what has arrived: where messages take time, or catoms pause.
    bool apart() const { return !network.ideal() || !clock.synchronous() || longest_jam > 0; }
    // The most ticks from a change at a catom until a neighbour has acted on it; where the clock gives turns, until it has work.
    std::uint32_t latency() const { return network.bound() + clock.most - 1 + longest_jam; }
    // Whether events or faults are still to come.
    bool expects_after(std::int64_t tick) const;
};

// Files that a world names, by path.
using WorldFiles = std::map<std::string, std::string>;

// Sorts cells into the order of World::cells.
void sort_cells(std::vector<Cell>& cells, const Lattice& lattice);

}  // namespace meld::world
