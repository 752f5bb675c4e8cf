// The catoms that one process knows, in bricks: the cell of each catom, and the catom on each cell.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "runtime/base/process/parallel_for.h"
#include "runtime/base/raw_array.h"
#include "runtime/module/abi/geometry_abi.h"
#include "runtime/world/ensemble/brick_table.h"
#include "runtime/world/ensemble/catom_ids.h"
#include "runtime/world/ensemble/links.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::world {

using Slot = std::uint32_t;

class Target;

class Ensemble {
  public:
    // in_target returns whether a cell is in the target shape; called once per cell of a brick when the brick is made.
    Ensemble(const Lattice& lattice, std::function<bool(Cell)> in_target);
    // The same from a world's target, which skips bricks that the target does not reach. The target must outlive this object.
    Ensemble(const Lattice& lattice, const Target& target);

    const Lattice& lattice() const { return lattice_; }
    // The arrays a module reads. Pointers change when catoms or bricks are added: fetch again after any change.
    Geometry geometry() const;

    // From now on links are listed in a table too, which modules in the links form read. Must be empty when called. `apart`: as in Links.
    void keep_links(bool apart);
    bool keeps_links() const { return links_.has_value(); }
    Links& links() { return *links_; }
    const Links& links() const { return *links_; }
    // Calls visit(Catom) for the neighbours of a catom, in the order of its ports. Some may be ghosts.
    template <class Visit>
    void each_neighbour(Catom catom, const Visit& visit) const {
        if (links_) return links_->each(catom, [&](Port, Catom other) { visit(other); });
        if (free_links_) return each_link(catom, [&](int, Catom other) { visit(other); });
        const Cell here = cell(catom);
        for (int port = 0; port < lattice_.ports(); ++port)
            if (const std::optional<Catom> other = at(lattice_.neighbour(here, port))) visit(*other);
    }

    // The slot of a brick, made empty if it does not exist. Cost: a hash lookup, cached for repeated bricks.
    Slot slot(Cell brick);
    std::optional<Slot> find_slot(Cell brick) const;
    Cell brick(Slot slot) const;
    std::size_t brick_count() const;  // Without the empty slot 0.
    BrickKey brick_key(Slot slot) const { return key_[slot]; }
    // Makes all 26 neighbours of a brick present, so that every cell a catom there can reach has a slot. At the edge of the world, where
    // there are fewer, the others stay slot 0.
    void surround(Slot slot);

    // Adds a catom on an empty cell and returns its index: the lowest free one, otherwise a new one at the end.
    Catom add(std::uint64_t id, Cell cell, CatomState state);
    // Adds catoms with consecutive ids on consecutive cells of a brick, which must be empty, and returns the index of the first; those of
    // the others follow. Only if has_no_gaps().
    Catom add_run(std::uint64_t first_id, Slot slot, std::uint32_t first_number, std::uint32_t count, CatomState state);
    // Sets the bits, which are clear, of the cells of a brick with catoms. Called by all workers.
    using FillCells = std::function<void(Cell brick, std::span<std::uint64_t, 8> cells)>;
    // Makes these bricks, the first of all, with so many catoms each: indices and ids in their order, in a brick ascending by cell. The
    // result does not depend on the workers. Cost: 1 to 2 ns a catom on one thread, and some 0.5 us a brick.
    void add_bricks(std::span<const std::pair<BrickKey, std::uint32_t>> bricks, std::uint64_t first_id, const FillCells& fill,
                    CatomState state, Workers& workers);
    // No catom has been removed whose index is free now.
    bool has_no_gaps() const { return free_.empty(); }
    // Whether nobody stands on these consecutive cells of a brick.
    bool empty(Slot slot, std::uint32_t first_number, std::uint32_t count) const;
    void remove(Catom catom);
    // Moves a catom to an empty cell.
    void move(Catom catom, Cell to);
    void set_state(Catom catom, CatomState state);
    // An index that is no catom, but has the id of one and is read in its place (Links::read_at).
    Catom add_mailbox(Catom of);
    // One that is not read any more is read in the place of another.
    void use_mailbox(Catom mailbox, Catom of);
    // What that will write to is asked for ahead.
    void ask_ahead_mailbox(Catom mailbox) const {
        ids_.ask_ahead(mailbox);
        ask_for(&site_[mailbox]);
    }

    // ---- amoebots: catoms of one or two cells (amoebot_ensemble.cpp)
    // Catoms have a head and a tail from now on, both on cell() at first, and ports of a compass of their own: 0 to 5 at the head, 6 to 11
    // at the tail of one with two cells. Links are listed in the table, one for each pair of catoms that touch: where they do so at several
    // ports, at the lowest of the catom with the smaller id. Must be empty when called, on the hex lattice; keep_links() comes first.
    void set_amoebots(std::function<std::uint8_t(std::uint64_t id)> compass_of);
    bool has_amoebots() const { return compass_of_ != nullptr; }
    // The cell of the tail; of a catom with one cell its only one.
    Cell tail(Catom catom) const { return has_amoebots() ? cell_at_site(tail_[catom]) : cell(catom); }
    bool expanded(Catom catom) const { return has_amoebots() && (compass_[catom] & kTwoCells) != 0; }
    // The catom occupies these two cells, or this one if they are the same. Others do not; what it occupied is empty if it is none of
    // these.
    void reshape(Catom catom, Cell head, Cell tail);
    // By catom, the class of the cell of its head: its coordinates modulo kApart, as y * kApart + x; kNoClass if there is no such catom.
    static constexpr std::int32_t kApart = 6;
    static constexpr std::uint8_t kNoClass = 0xff;
    std::span<const std::uint8_t> head_classes() const { return class_; }
    // The lookups below cost a few loads, where at() and key() look for a brick. The bricks around the catom must be present.
    enum class End { Head, Tail };
    std::uint32_t site_beside(Catom catom, End end, int direction) const {
        return site_towards(end == End::Head ? site_[catom] : tail_[catom], direction);
    }
    bool full_at(std::uint32_t site) const { return cell_catom_[site] != kNobody; }
    CellKey key_at(std::uint32_t site) const { return key_[site >> kBrickCellBits] << kBrickCellBits | (site & (kBrickCells - 1)); }
    // Calls visit(Catom) for whoever is beside the catom, once for each pair of cells that touch; the catom itself too if it has two.
    template <class Visit>
    void each_beside(Catom catom, const Visit& visit) const {
        const int cells = tail_[catom] != site_[catom] ? 2 : 1;
        for (int place = 0; place < cells * kDirections; ++place) {
            const std::uint32_t from = place < kDirections ? site_[catom] : tail_[catom];
            if (const std::int32_t there = cell_catom_[site_towards(from, place % kDirections)]; there != kNobody)
                visit(static_cast<Catom>(there));
        }
    }
    // surround() for the bricks of both cells.
    void surround_amoebot(Catom catom);

    // ---- catoms at arbitrary positions (free_ensemble.cpp)
    // They have no cells; their neighbours are the catoms they are linked with, over ports that are only numbers. The arrays of geometry()
    // are laid out so that modules find links as they find neighbours on a lattice. Must be empty when called. Ports::Any: links are in the
    // table alone, as those of a graph; keep_links() comes first.
    enum class Ports { Twelve, Any };
    void set_free(std::function<bool(const Vec3&)> in_target, Ports ports = Ports::Twelve);
    bool is_free() const { return free_links_; }
    // The same for nodes of a graph, whose links are in the table alone: any number of ports. keep_links() comes first.
    void set_graph();
    bool is_graph() const { return graph_; }
    void reserve_nodes(std::size_t catoms, std::size_t ports);
    // Makes room for this many, so that arrays need not grow.
    void reserve_free(std::size_t catoms);
    Catom add_at(std::uint64_t id, const Vec3& position, CatomState state);
    // Returns whether it has entered or left the target.
    bool place(Catom catom, const Vec3& position);
    // Links two catoms over a port of each that has no link, or removes the link at a port, on both sides.
    void link(Catom a, int port_of_a, Catom b, int port_of_b);
    void unlink(Catom catom, int port);
    std::optional<Catom> linked(Catom catom, int port) const;
    bool has_any_ports() const { return any_ports_; }
    // Calls visit(port, neighbour) for the links of a catom, in the order of its ports.
    template <class Visit>
    void each_link(Catom catom, const Visit& visit) const {
        if (any_ports_) return links_->each(catom, [&](Port port, Catom other) { visit(static_cast<int>(port), other); });
        for (int port = 0; port < kMaxPorts; ++port)
            if (const std::optional<Catom> other = linked(catom, port)) visit(port, *other);
    }
    // The port at the other end of a link.
    int port_there(Catom catom, int port) const {
        if (any_ports_) return static_cast<int>(links_->port_there(catom, static_cast<Port>(port)));
        return link_back_[site_[catom] + static_cast<std::uint32_t>(port)];
    }
    // The lowest port without a link, or none.
    std::optional<int> vacant_port(Catom catom) const;
    std::optional<int> port_towards(Catom catom, Catom other) const;

    std::optional<Catom> at(Cell cell) const;
    // Like Lattice::key, without the walk along the curve for bricks that are present.
    CellKey key(Cell cell) const;
    // Of the cell on which a catom stands.
    CellKey key_of(Catom catom) const { return key_at(site_[catom]); }
    Cell cell(Catom catom) const;
    std::uint64_t id(Catom catom) const { return ids_.of(catom); }
    CatomState state(Catom catom) const { return static_cast<CatomState>(state_[catom]); }
    bool target(Cell cell) const;  // False also if no brick is present.
    Vec3 position(Catom catom) const { return free_links_ ? positions_[catom] : lattice_.position(cell(catom)); }

    std::size_t index_count() const { return site_.size(); }
    std::size_t owned_count() const { return owned_count_; }
    std::size_t ghost_count() const { return ghost_count_; }
    // The catom with this id, if this process knows it. Cost: a comparison if ids follow indices, otherwise one hash lookup; the map is
    // made on first use, so the first call must not run in parallel with others.
    std::optional<Catom> find(std::uint64_t id) const;
    void reserve(std::size_t catoms, std::size_t bricks);
    std::size_t bytes() const;
    // What so many catoms and bricks on a lattice will take, for arrays that had room for `room` bricks at first.
    static std::size_t bytes_for(std::size_t catoms, std::size_t bricks, std::size_t room);

  private:
    // Sets the 512 target bits of a brick, which are clear.
    using FillTarget = std::function<void(Cell brick, std::span<std::uint64_t, 8> bits)>;
    Ensemble(const Lattice& lattice, FillTarget fill_target, std::size_t sentinels);

    Catom take_index(std::uint64_t id, std::uint32_t site, CatomState state);
    void add_free(Geometry& g) const;
    void cut(Catom catom);
    void free_index(Catom index);
    Slot make_slot(Cell brick);
    std::uint32_t site(Cell cell);  // Makes the brick if necessary.
    // Of add_bricks(): the bricks' slots with their neighbours; the catoms of one brick, whose first is given.
    void add_slots(std::span<const std::pair<BrickKey, std::uint32_t>> bricks, Workers& workers);
    void fill_brick(Slot slot, Catom first, std::uint32_t count, const FillCells& fill, CatomState state);
    void count(std::uint8_t state, std::size_t by);
    bool is_catom(Catom index) const { return state_[index] == kCatomOwned || state_[index] == kCatomGhost; }
    // In the table of links, where there is one: a catom has come to its cell, or leaves it. Catoms after it and before `placed_until` have
    // come too, and are linked in their turn.
    void link_around(Catom catom, Catom placed_until = 0);
    // Tails and compasses for catoms below this index that have none: one cell.
    void add_tails(Catom end);
    void set_amoebot(Catom catom);
    // What follows from its cells: its class, and whether there are two.
    void set_form(Catom catom);
    // The site of a cell that is probably in the brick of another site.
    std::uint32_t site_near(Cell cell, std::uint32_t near);
    void link_amoebot(Catom catom, Catom placed_until);
    void unlink_around(Catom catom);
    // Of the bricks that are present; site 0 is in none.
    std::uint32_t site_towards(std::uint32_t site, int port) const {
        const std::uint32_t entry = lattice_.step_table()[static_cast<std::size_t>(port) * kBrickCells + (site & (kBrickCells - 1))];
        return neighbours_[std::size_t{site >> kBrickCellBits} * kBrickNeighbours + (entry >> kBrickCellBits)] << kBrickCellBits |
               (entry & (kBrickCells - 1));
    }
    Cell cell_at_site(std::uint32_t site) const;

    Lattice lattice_;
    FillTarget fill_target_;

    // By slot: 27 neighbours, 512 cells, 8 words of target bits, 3 coordinates of the first cell.
    RawArray<std::uint32_t> neighbours_;
    RawArray<std::int32_t> cell_catom_;
    RawArray<std::uint64_t> target_;
    std::vector<std::int32_t> origin_;
    std::vector<BrickKey> key_;
    BrickTable slots_;
    // The last brick that was looked up.
    std::uint64_t last_key_ = 0;
    Slot last_slot_ = 0;

    // By catom. A free index has state kCatomFree and site 0.
    CatomIds ids_;
    RawArray<std::uint32_t> site_;
    RawArray<std::uint8_t> state_;
    // A heap with the lowest free index on top.
    std::vector<Catom> free_;
    std::size_t owned_count_ = 0, ghost_count_ = 0;

    // For amoebots, by catom: the site of the tail, the compass as Geometry has it, and the class of the head.
    std::function<std::uint8_t(std::uint64_t)> compass_of_;
    RawArray<std::uint32_t> tail_;
    RawArray<std::uint8_t> compass_, class_;

    // For catoms at arbitrary positions: by site and port, the port at the other end of the link.
    bool free_links_ = false, graph_ = false, any_ports_ = false;
    std::function<bool(const Vec3&)> in_target_;
    std::vector<Vec3> positions_;
    std::vector<std::uint8_t> link_back_;

    std::optional<Links> links_;
};

}  // namespace meld::world
