#include "runtime/sim/core/refusals.h"

#include <cstddef>
#include <iterator>

#include "runtime/base/assert.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

namespace {

struct Words {
    Refusal why;
    std::string_view name, text;
};
constexpr Words kWords[] = {
    {Refusal::NotInThisWorld, "not_in_this_world", "nothing in this world carries it out"},
    {Refusal::NotOnThisLattice, "not_on_this_lattice", "this lattice has no such move"},
    {Refusal::NoSuchPort, "no_such_port", "the catom had no such port"},
    {Refusal::NotAtRightAngles, "not_at_right_angles", "its two ports were not at right angles"},
    {Refusal::Outside, "outside", "the cell was none of the lattice"},
    {Refusal::NotANeighbour, "not_a_neighbour", "the other catom was no neighbour"},
    {Refusal::IsExpanded, "is_expanded", "the amoebot occupied two cells already"},
    {Refusal::IsContracted, "is_contracted", "the amoebot occupied one cell only"},
    {Refusal::NoSuchEnd, "no_such_end", "it named neither \"head\" nor \"tail\""},
    {Refusal::OtherExpanded, "other_expanded", "the neighbour occupied two cells already"},
    {Refusal::OtherContracted, "other_contracted", "the neighbour occupied one cell only"},
    {Refusal::NoUnit, "no_unit", "the catom held no unit"},
    {Refusal::HoldsUnits, "holds_units", "the catom held units"},
    {Refusal::NoRoom, "no_room", "the other catom had no room for the units"},
    {Refusal::Occupied, "occupied", "a cell that had to be empty was not"},
    {Refusal::NoSupport, "no_support", "a cell that had to be occupied was empty"},
    {Refusal::NoPath, "no_path", "no path led to a cell beside the other catom"},
    {Refusal::NoMoves, "no_moves", "the world names no moves"},
    {Refusal::NotAllowed, "not_allowed", "the moves of the world do not allow it"},
    {Refusal::Disconnects, "disconnects", "the neighbours would not have stayed connected"},
    {Refusal::Repeated, "repeated", "the catom had asked for it before in that tick"},
    {Refusal::Conflict, "conflict", "another request had priority"},
    {Refusal::NoSuchFeature, "no_such_feature", "the catom had no such feature"},
    {Refusal::NotConnected, "not_connected", "the two catoms were not connected"},
    {Refusal::NotJoined, "not_joined", "the two catoms had no joint, or none with a motor"},
    {Refusal::NotTouching, "not_touching", "the other catom did not touch it"},
    {Refusal::NoSuchKind, "no_such_kind", "the world has no such kind of joints"},
    {Refusal::NoSuchCatom, "no_such_catom", "there was no such other catom"},
    {Refusal::AlreadyJoined, "already_joined", "the two catoms had a joint already"},
    {Refusal::BothFixed, "both_fixed", "both catoms were fixed"},
    {Refusal::TooFar, "too_far", "the other catom was too far away"},
    {Refusal::TooManyJoints, "too_many_joints", "one of the two had as many joints as it can have"},
};
constexpr std::size_t kRefusals = std::size(kWords);

constexpr bool in_order() {
    for (std::size_t i = 0; i < kRefusals; ++i)
        if (static_cast<std::size_t>(kWords[i].why) != i) return false;
    return true;
}
static_assert(in_order(), "a reason is found by its number");

const Words& words_of(Refusal why) {
    const auto index = static_cast<std::size_t>(why);
    MELD_EXPECT(index < kRefusals, "reason {}", index);
    return kWords[index];
}

}  // namespace

std::string_view name_of(Refusal why) { return words_of(why).name; }
std::string_view text_of(Refusal why) { return words_of(why).text; }

std::vector<Refused> Refusals::of_all(comm::Communicator& comm) const {
    std::vector<Refused> mine;
    for (const auto& [key, count] : counts_) mine.push_back({key.first, key.second, count});
    if (comm.processes() == 1) return mine;
    ByteWriter bytes;
    write(mine, bytes);
    Refusals sum;
    for (const auto& theirs : comm.allgather_any(bytes.view())) {
        ByteReader in(theirs, "the refused actions of a process");
        for (const Refused& each : read_refused(in)) sum.add(each.action, each.why, each.count);
    }
    mine.clear();
    for (const auto& [key, count] : sum.counts_) mine.push_back({key.first, key.second, count});
    return mine;
}

void write(const std::vector<Refused>& all, ByteWriter& out) {
    out.write_count(all.size());
    for (const Refused& each : all) {
        out.write(each.action);
        out.write(each.why);
        out.write(each.count);
    }
}

std::vector<Refused> read_refused(ByteReader& in) {
    constexpr std::size_t size_bytes = sizeof(ActionKind) + sizeof(Refusal) + sizeof(std::uint64_t);
    std::vector<Refused> all(in.read_count(size_bytes));
    for (Refused& each : all) {
        each.action = in.read<ActionKind>();
        each.why = in.read<Refusal>();
        each.count = in.read<std::uint64_t>();
    }
    return all;
}

bool known(const Refused& refused) {
    return static_cast<std::size_t>(refused.action) <= known_actions().size() && static_cast<std::size_t>(refused.why) < kRefusals;
}

void refuse_those_of_other_worlds(Subdomain& subdomain, ActionInfo::Performer here) {
    using Performer = ActionInfo::Performer;
    if (subdomain.totals.actions == 0) return;
    for (const eval::Action& action : subdomain.actions()) {
        const ActionKind kind = subdomain.kind_of(action);
        const Performer whose = info(kind).performer;
        const bool moves =
            whose == Performer::Lattice || whose == Performer::Amoebots || whose == Performer::Bodies || whose == Performer::Points;
        if (moves && whose != here) subdomain.refuse(kind, Refusal::NotInThisWorld);
    }
}

}  // namespace meld::sim
