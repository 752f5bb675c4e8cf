// What goes with a catom to another process: all of it to the process that will own it, what it exports to one that only sees it.
//
// Who goes where is for the motion to say: on a lattice the owner of the cell owns the catom, and bodies go with their blocks of space.
// Either way the process that owns the catom packs it once for each receiver, and a receiver adds it and unpacks it. Code modules
// take the state that they keep for each catom along themselves (runtime/sim/core/code_modules.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// A catom as it is sent.
struct Migrant {
    std::uint64_t id = 0;
    std::vector<std::byte> facts = {};

    void write(ByteWriter& out) const;
    static Migrant read(ByteReader& in);
    // Of a migrant as bytes, at least.
    static constexpr std::size_t kLeastBytes = sizeof(std::uint64_t) + sizeof(std::uint32_t);
};

// For a process where it will have the state `there`: everything if it is owned there, what it exports if it is a ghost.
Migrant pack_migrant(const Subdomain& subdomain, Catom catom, CatomState there);

// Adds it on an empty cell, as one of this process if the cell is, and as a ghost otherwise; for that it was packed. A catom of this
// process is evaluated at its new place.
Catom add_migrant(Subdomain& subdomain, const Migrant& migrant, Cell cell);
// The same where catoms stand anywhere and `owner` says whose it is. Its links are still to be made.
Catom add_migrant_freely(Subdomain& subdomain, const Migrant& migrant, const world::Vec3& position, int owner);
// Adds a catom that has just been made, so that there is nothing to unpack.
Catom add_newborn(Subdomain& subdomain, std::uint64_t id, Cell cell);

}  // namespace meld::sim
