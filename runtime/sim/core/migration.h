// The migration of a catom: all its data go to the process that will own it, and what it exports to a process that only has a ghost.
//
// The motion decides which catom migrates: on a lattice the owner of the cell owns the catom, and bodies go with their blocks of space. In
// both cases the process that owns the catom packs it once for each receiver, and a receiver adds it and unpacks it. Code modules migrate
// the state that they keep for each catom themselves (runtime/sim/core/code_modules.h).
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
    // The least number of bytes of a migrant.
    static constexpr std::size_t kLeastBytes = sizeof(std::uint64_t) + sizeof(std::uint32_t);
};

// Packs the catom for a process where it will have the state `there`: everything if it is owned there, its exports if it is a ghost.
Migrant pack_migrant(const Subdomain& subdomain, Catom catom, CatomState there);

// Adds it on an empty cell, as a catom of this process if the cell is, and as a ghost otherwise; it must have been packed for that. A catom
// of this process is evaluated at its new position.
Catom add_migrant(Subdomain& subdomain, const Migrant& migrant, Cell cell);
// The same for catoms at arbitrary positions, where `owner` gives the owner. Its links are still to be made.
Catom add_migrant_freely(Subdomain& subdomain, const Migrant& migrant, const world::Vec3& position, int owner);
// Adds a catom that has just been created, so there is nothing to unpack.
Catom add_newborn(Subdomain& subdomain, std::uint64_t id, Cell cell);

}  // namespace meld::sim
