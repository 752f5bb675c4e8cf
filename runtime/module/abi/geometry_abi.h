// Where catoms are and who is next to whom, as plain arrays that a compiled module and the runtime share. Included by emitted code, so it
// uses no standard library.
//
// Neighbours are found in one of two ways. In the lattice form they follow from geometry: from the cell of a catom and the catoms of the
// bricks around it. In the links form, for graphs and for networks that take time, they are listed in a table, which a catom may have any
// number of entries in. A module is compiled in one of the forms (ModuleInfo::by_links); the runtime asks each_link() and its like, which
// know both.
#pragma once

namespace meld {

using i8 = __INT8_TYPE__;
using i16 = __INT16_TYPE__;
using i32 = __INT32_TYPE__;
using i64 = __INT64_TYPE__;
using u8 = __UINT8_TYPE__;
using u16 = __UINT16_TYPE__;
using u32 = __UINT32_TYPE__;
using u64 = __UINT64_TYPE__;

// A brick is 512 cells; a site is brick slot * 512 + the cell's number in its brick.
inline constexpr u32 kBrickCells = 512;
inline constexpr u32 kBrickCellBits = 9;
inline constexpr u32 kBrickNeighbours = 27;
// The index of a brick itself among its 27 neighbours (offset 0, 0, 0).
inline constexpr u32 kBrickCentre = 13;
inline constexpr i32 kMaxPorts = 12;

enum CatomState : u8 {
    kCatomFree = 0,     // An index that is not in use.
    kCatomOwned = 1,    // Lives on this process.
    kCatomGhost = 2,    // Lives on another process; its exported columns are mirrored here.
    kCatomMailbox = 3,  // No catom, but what has arrived over a link: exported columns as its reader knows them.
};

struct Geometry {
    i32 ports = 0;                          // Directions in which a catom can have a neighbour.
    i32 opposite[kMaxPorts] = {};           // The port at which the neighbour sees the catom.
    const u16* step = nullptr;              // [port * 512 + cell]: neighbouring brick (0..26) << 9 | cell there.
    const i32* cell_catom = nullptr;        // [site]: the catom there, or -1.
    const u32* brick_neighbours = nullptr;  // [slot * 27 + n]: slot; slot 0 is a brick that is always empty.
    const u64* brick_target = nullptr;      // [slot * 8 + cell / 64]: one bit per cell, set if the cell is in the target shape.
    const i32* brick_origin = nullptr;      // [slot * 3]: coordinates of the brick's first cell.
    i32 cell_bits[3] = {3, 3, 3};           // How a cell's number splits: x in the lowest bits, then y, then z.
    const u32* catom_site = nullptr;        // [catom]; of a mailbox the catom that is read there.
    const u64* catom_id = nullptr;          // [catom - ids_implied]: the id, for those for which it does not follow; ask id_of().
    const u8* catom_state = nullptr;        // [catom]: CatomState
    u32 catoms = 0;                         // Indices in use, owned, ghost and free.
    u32 ids_implied = 0;                    // Lower indices have consecutive ids,
    u64 first_id = 0;                       // from this one on.
    // [site + port]: the port at which the neighbour sees the site, if it depends on the link and not only on the port; else null.
    const u8* link_back = nullptr;

    // The links form; all null in the lattice form. A catom's entries are link_first[catom] + port, for ports below link_ports[catom].
    const u32* link_first = nullptr;  // [catom]
    const u32* link_ports = nullptr;  // [catom]
    const i32* link_catom = nullptr;  // [entry]: the neighbour, or -1.
    const i32* link_read = nullptr;   // [entry]: where its exports are read: the neighbour itself, or a mailbox; or -1.
    // [entry]: the port at which the neighbour sees the catom. In the second, and the first is null, where a port needs more than 16 bits.
    const u16* link_there = nullptr;
    const u32* link_there_wide = nullptr;
    u32 most_ports = 0;  // No catom has more.

    // Amoebots, which occupy one or two cells and have compasses of their own; null elsewhere.
    const u32* catom_tail = nullptr;  // [catom]: the site of the second cell; that of the first if there is one cell.
    // [catom]: the lattice's direction of port 0, plus kLeftHanded if ports run clockwise, plus kTwoCells if there are two cells.
    const u8* catom_compass = nullptr;
};

// Directions of the triangular lattice, which amoebots live on. Ports below are at an amoebot's head, the others at its tail.
inline constexpr i32 kDirections = 6;
inline constexpr u8 kLeftHanded = 8, kTwoCells = 16;

// From a direction as a compass has it to the lattice's, and back.
inline i32 lattice_direction(u8 compass, i32 direction) {
    const i32 first = compass & 7;
    return (compass & kLeftHanded) != 0 ? (first + kDirections - direction) % kDirections : (first + direction) % kDirections;
}
inline i32 own_direction(u8 compass, i32 of_lattice) {
    const i32 first = compass & 7;
    return (compass & kLeftHanded) != 0 ? (first + kDirections - of_lattice) % kDirections
                                        : (of_lattice + kDirections - first) % kDirections;
}

// The global id of a catom, the same on every process.
inline u64 id_of(const Geometry& g, u32 catom) { return catom < g.ids_implied ? g.first_id + catom : g.catom_id[catom - g.ids_implied]; }

// The site next to a site, over a port; it may lie in slot 0.
inline u32 site_towards(const Geometry& g, u32 site, i32 port) {
    const u32 entry = g.step[static_cast<u32>(port) * kBrickCells + (site & (kBrickCells - 1))];
    const u32 slot = g.brick_neighbours[(site >> kBrickCellBits) * kBrickNeighbours + (entry >> kBrickCellBits)];
    return (slot << kBrickCellBits) | (entry & (kBrickCells - 1));
}

// The catom next to a site over a port, or -1.
inline i32 catom_towards(const Geometry& g, u32 site, i32 port) { return g.cell_catom[site_towards(g, site, port)]; }

// ---- links, in either form
// How many ports a catom has; there need not be a neighbour at each.
inline i32 ports_of(const Geometry& g, u32 catom) { return g.link_first != nullptr ? static_cast<i32>(g.link_ports[catom]) : g.ports; }
// The neighbour of a catom at a port, or -1.
inline i32 neighbour_at(const Geometry& g, u32 catom, i32 port) {
    if (g.link_first != nullptr) return g.link_catom[g.link_first[catom] + static_cast<u32>(port)];
    return catom_towards(g, g.catom_site[catom], port);
}
// The port at which the neighbour of a catom at a port sees it.
inline i32 port_there(const Geometry& g, u32 catom, i32 port) {
    if (g.link_first != nullptr) {
        const u32 entry = g.link_first[catom] + static_cast<u32>(port);
        return g.link_there != nullptr ? i32{g.link_there[entry]} : static_cast<i32>(g.link_there_wide[entry]);
    }
    return g.link_back != nullptr ? g.link_back[g.catom_site[catom] + static_cast<u32>(port)] : g.opposite[port];
}
// Calls visit(port, neighbour) for each link of a catom, in the order of its ports.
template <class Visit>
inline void each_link(const Geometry& g, u32 catom, const Visit& visit) {
    if (g.link_first != nullptr) {
        const i32* const row = g.link_catom + g.link_first[catom];
        const i32 ports = static_cast<i32>(g.link_ports[catom]);
        for (i32 port = 0; port < ports; ++port)
            if (row[port] >= 0) visit(port, static_cast<u32>(row[port]));
        return;
    }
    const u32 site = g.catom_site[catom];
    for (i32 port = 0; port < g.ports; ++port)
        if (const i32 other = catom_towards(g, site, port); other >= 0) visit(port, static_cast<u32>(other));
}

// ---- places around a catom, occupied or not
// Asked of neighbours too, so it is read from the least memory.
inline bool is_expanded(const Geometry& g, u32 catom) { return g.catom_compass != nullptr && (g.catom_compass[catom] & kTwoCells) != 0; }
// How many ports have a place behind them.
inline i32 places_of(const Geometry& g, u32 catom) { return is_expanded(g, catom) ? 2 * kDirections : g.ports; }
// The port with this number, if it is one of so many, or -1.
inline i32 port_among(i64 number, i32 ports) { return number >= 0 && number < ports ? static_cast<i32>(number) : -1; }
// The site behind a port; of an expanded amoebot this may be its own other cell.
inline u32 site_beside(const Geometry& g, u32 catom, i32 port) {
    if (g.catom_tail == nullptr) return site_towards(g, g.catom_site[catom], port);
    const bool head = port < kDirections;
    return site_towards(g, head ? g.catom_site[catom] : g.catom_tail[catom],
                        lattice_direction(g.catom_compass[catom], head ? port : port - kDirections));
}
// The direction from the tail of an expanded amoebot to its head, as its compass has it.
inline i32 head_direction(const Geometry& g, u32 catom) {
    i32 direction = 0;
    while (site_beside(g, catom, kDirections + direction) != g.catom_site[catom]) ++direction;
    return direction;
}
// The port at which the amoebot behind a port sees the catom.
inline i32 port_back(const Geometry& g, u32 catom, i32 port, u32 other) {
    const i32 direction = lattice_direction(g.catom_compass[catom], port % kDirections);
    const i32 back = own_direction(g.catom_compass[other], g.opposite[direction]);
    return site_beside(g, catom, port) == g.catom_site[other] ? back : kDirections + back;
}

inline bool in_target(const Geometry& g, u32 site) { return (g.brick_target[site >> 6] >> (site & 63)) & 1; }

// Coordinate 0, 1 or 2 of the cell of a site.
inline i32 cell_coordinate(const Geometry& g, u32 site, i32 axis) {
    const u32 cell = site & (kBrickCells - 1);
    i32 shift = 0;
    for (i32 a = 0; a < axis; ++a) shift += g.cell_bits[a];
    const u32 mask = (1u << g.cell_bits[axis]) - 1;
    return g.brick_origin[(site >> kBrickCellBits) * 3 + static_cast<u32>(axis)] + static_cast<i32>((cell >> shift) & mask);
}

}  // namespace meld
