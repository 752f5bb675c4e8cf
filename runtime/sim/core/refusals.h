// The actions that were not carried out, counted by action and reason.
#pragma once

#include <cstdint>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/module/abi/actions.h"

namespace meld::sim {

class Subdomain;

// Why an action was not carried out, in the order of summaries; docs/motion.md has the table.
enum class Refusal : std::uint8_t {
    NotInThisWorld,
    NotOnThisLattice,
    NoSuchPort,
    NotAtRightAngles,
    Outside,
    NotANeighbour,
    IsExpanded,
    IsContracted,
    NoSuchEnd,
    OtherExpanded,
    OtherContracted,
    NoUnit,
    HoldsUnits,
    NoRoom,
    Occupied,
    NoSupport,
    NoPath,
    NoMoves,
    NotAllowed,
    Disconnects,
    Repeated,
    Conflict,
    NoSuchFeature,
    NotConnected,
    NotJoined,
    NotTouching,
    NoSuchKind,
    NoSuchCatom,
    AlreadyJoined,
    BothFixed,
    TooFar,
    TooManyJoints,
};
// A name that stays the same, for programs: "not_a_neighbour".
std::string_view name_of(Refusal why);
// For people: "the other catom was no neighbour".
std::string_view text_of(Refusal why);

struct Refused {
    ActionKind action = ActionKind::None;
    Refusal why = Refusal::Conflict;
    std::uint64_t count = 0;
};

class Refusals {
  public:
    void add(ActionKind action, Refusal why, std::uint64_t count = 1) { counts_[{action, why}] += count; }
    // Of all processes, by action and reason. Every process calls it.
    std::vector<Refused> of_all(comm::Communicator& comm) const;

  private:
    std::map<std::pair<ActionKind, Refusal>, std::uint64_t> counts_;
};

void write(const std::vector<Refused>& all, ByteWriter& out);
std::vector<Refused> read_refused(ByteReader& in);
// Whether there is such an action and such a reason; bytes from outside may say anything.
bool known(const Refused& refused);

// Refuses the actions of the last tick that only other worlds carry out: those on lattices, on bodies and on points, except this one's.
void refuse_those_of_other_worlds(Subdomain& subdomain, ActionInfo::Performer here);

}  // namespace meld::sim
