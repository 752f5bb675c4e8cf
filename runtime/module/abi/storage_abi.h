// The constants behind columns and dirty words: the planner lays storage out by them, modules and the runtime rely on them.
// Included by emitted code, so: no standard library.
#pragma once

#include "runtime/module/abi/geometry_abi.h"

namespace meld {

// Why a catom is evaluated: the low bits of its dirty word are the runtime's own. The bits above belong to the module: one for
// each column of the catom itself, one for each column that it reads at its neighbours.
enum DirtyBit : u64 {
    kDirtyBorn = 1,     // First evaluation.
    kDirtyLinks = 2,    // A neighbour came or went.
    kDirtyPlace = 4,    // The catom stands on another cell, or the target changed.
    kDirtyWake = 8,     // A quarantine has ended, or a tick has come at which a rule asked to be evaluated.
    kDirtyTick = 16,    // Evaluated in every tick.
    kDirtyBirths = 31,  // A new catom: all of the above.
    kDirtyGroups = 32,  // A quarantine of single groups has ended; the column's changes say of which.
    kFirstModuleBit = 64,
    // The highest bit, which is the runtime's too in programs of amoebots that are activated: it is its turn (PredicateInfo::by_turn).
    kDirtyTurn = u64{1} << 31,
};
// How many bits a dirty word has: the agenda stores them in 32 planes at most.
inline constexpr u32 kDirtyWordBits = 32;

// The rank of a fact that does not hold.
inline constexpr u32 kAbsent = 0xffffffff;

// No fact gets a higher one: a chain of so many derivations ends the run. Ints that grow with the rank of their facts are stored in few
// bytes because of it (compiler/plan/passes/narrow.cpp).
inline constexpr u32 kMaxRank = u32{1} << 30;

// Widths in columns.
inline constexpr u32 kRankBytes = 4;
inline constexpr u32 kPresenceBytes = 1;     // Of presence bits,
inline constexpr u32 kPresenceBits = 8;      // one for each of the predicates that share them.
inline constexpr u32 kPortMaskBytes = 4;     // The mask of the ports at which a PerLink fact holds.
inline constexpr u32 kWaitedPortsBytes = 4;  // The mask of ports that a candidate of an aggregate with `[<- link]` comes from.
inline constexpr u32 kRowsHeadBytes = 16;    // sizeof(RowsHead): what a column of rows takes for each catom.

static_assert(kMaxPorts <= 32, "masks of ports are 32 bits wide");

}  // namespace meld
