#include "runtime/driver/setup/memory_need.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "runtime/base/process/available_memory.h"
#include "runtime/base/radix_sort.h"
#include "runtime/engine/eval/agenda.h"
#include "runtime/engine/eval/requests.h"
#include "runtime/engine/tuple/columns.h"
#include "runtime/engine/tuple/program_actions.h"
#include "runtime/results/facts/facts_file.h"
#include "runtime/sim/core/setup/expected_share.h"
#include "runtime/sim/core/setup/setup.h"
#include "runtime/sim/network/routes.h"
#include "runtime/sim/network/versions.h"
#include "runtime/world/ensemble/ensemble.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::driver {

namespace {

constexpr double kMiB = 1 << 20;

// Measured as in docs/lab/memory.md, "Memory": the growth of the peak with the number of catoms.
//
// Code that is not in memory yet when the need is computed, threads, and what the allocator keeps.
constexpr double kLater = 0.5 * kMiB;
constexpr double kLaterOfBodies = 0.9 * kMiB;
// The HDF5 library; of a recording also what it keeps of its columns, and its caches of chunks.
constexpr double kHdf5 = 4 * kMiB;
constexpr double kRecording = 6.7 * kMiB;
constexpr double kChunkCaches = 6.5 * kMiB;
constexpr double kChunkCachesCatom = 33;
// The catoms of a block of a checkpoint, which grows by doubling.
constexpr double kCheckpointBlock = 1 << 16;
constexpr double kGrown = 1.5;
// The id of a catom that does not follow from its index; dirty bits that some catom has in most runs.
constexpr double kId = 8;
constexpr double kUsualBits = 3;
// A group that remembers a loss, while the array of these grows, and its slot in a table.
constexpr double kTombstone = 112;
// A list, string or set of some words; and where the rules of a block of catoms make them, as localization.meld needs it.
constexpr double kList = 64;
constexpr double kScratchCatom = 64 << 10;
constexpr double kScratchBlock = 256;
// A body that touches nothing, with its places in the ensemble and in the grid, links, and the copy of its state.
constexpr double kBody = 289;
// Two bodies that touch: their contact, its impulses, and the place in the list of candidates.
constexpr double kContact = 52;
// A body that is connected, as those of a cube are, more than its contacts take; and what its wishes take in the tick of the connection.
constexpr double kHeld = 90;
constexpr double kAsks = 500;
// A body of a cube that is all connected, if somebody wants its loads: its share of the lattice and of the loads.
constexpr double kLoads = 9000;
// A joint with its rows, and its blocks in the system of its assembly.
constexpr double kJoint = 5000;
// On several processes: what a body leaves behind where it was placed or packed, for memory that is freed stays with the process (see
// runtime/comm/transport/mpi.cpp); and what its contacts leave.
constexpr double kHandedOver = 90;
constexpr double kHandedOverContact = 35;
// How far the surfaces of bodies may be apart to be candidates, in diameters.
constexpr double kNear = 0.05;
// So many catoms may all know of each other, as those that route to each other do.
constexpr double kFewCatoms = 100;
// In a heap a ball touches six others: three contacts a body.
constexpr double kContactsInHeap = 3;

std::size_t whole(double number) { return static_cast<std::size_t>(std::ceil(number)); }

// The most neighbours within the range that a body has when they lie as densely as spheres can.
int ports_in_range(const world::World& world, const sim::ExpectedShare& share) {
    const double reach = 2 * world.links->range + 1;
    return static_cast<int>(std::min({share.catoms, 0.74 * reach * reach * reach, 1e6})) + 1;
}

// What a process takes of the whole world or of its share of it. Upper bounds are those of kMemoryAssumed.
class Counting {
  public:
    Counting(const world::World& world, const ModuleInfo& module, const sim::ExpectedShare& share, int processes)
        : processes_(processes),
          world_(world),
          module_(module),
          share_(share),
          here_(share.catoms + share.ghosts),
          ports_(world.is_graph()  ? static_cast<int>(graph::degrees(*world.graph).mean) + 1
                 : world.links     ? ports_in_range(world, share)
                 : world.is_free() ? kMaxPorts
                                   : world::Lattice(world.lattice).ports()) {}

    MemoryPart ensemble() const {
        const std::size_t room = sim::Setup::room_for_bricks(whole(share_.with_catoms));
        const auto bytes = [&](double bricks) {
            return static_cast<double>(world::Ensemble::bytes_for(whole(here_), whole(bricks), room));
        };
        const bool moves = world_.motion.kind != "none";
        // Ids of ghosts are stored, and of all catoms after one has come from elsewhere.
        const double ids = kId * share_.ghosts, all_ids = kId * (moves ? here_ : 2 * share_.ghosts);
        // Catoms that move make bricks where they come.
        return {"catoms and cells", {ids + bytes(share_.bricks), all_ids + bytes((moves || !share_.exact ? 2 : 1) * share_.bricks)}};
    }

    // What is made of the graph, which each process has already: the process and catom of each node, and the table of links with the catoms
    // at their ends. With several processes, METIS divides the graph before that; what it takes depends on how well the graph can be made
    // smaller, and some of it stays with the process. And the routes of facts to nodes that no link need lead to.
    MemoryPart nodes() const {
        const double nodes = static_cast<double>(world_.graph->nodes()), ends = static_cast<double>(world_.graph->to.size());
        const double known = std::min(nodes, here_);
        const double tables = kNode * nodes + kNodeHere * known + kEndHere * ends * known / std::max(1.0, nodes);
        const bool divides = processes_ > 1;
        const double owners = module_.finds_ways ? sim::Routes::bytes_for(nodes) : 0;
        const double distances =
            module_.finds_ways && world_.network.reach != world::Reach::Any ? sim::Routes::most_distances_bytes(nodes) : 0;
        return {"nodes and links",
                {owners + (divides ? std::max(kDividedWell * ends, tables) : tables),
                 owners + distances + (kNode + kNodeHere) * nodes + kEndHere * ends + (divides ? kDividedBadly * ends : 0)}};
    }

    // Somebody senses what connections carry, or they can break.
    bool wants_loads() const {
        const auto breaks = [](const auto& limits) { return limits.breaking_force || limits.breaking_torque; };
        const std::optional<u32> sensed = tuple::find_sensed(module_, "load", 4);
        return breaks(world_.physics) || std::ranges::any_of(world_.physics.groups, breaks) || (sensed && module_.predicates[*sensed].read);
    }

    // Of a region, or by a program, about as many as it may have catoms. Several processes begin with all joints and their bodies, and
    // each may keep them.
    double joints() const {
        const double catoms = here_ * processes_;
        double joints = 0;
        for (const world::JointOptions& joint : world_.physics.joints) joints += joint.between ? 1 : catoms;
        if (!world_.physics.joint_kinds.empty() && tuple::ProgramActions(module_).uses(ActionKind::Attach)) joints += catoms;
        const double ghosts = processes_ > 1 ? 2 * (kBody + kHandedOver) : 0;
        return (kJoint + ghosts) * std::min(joints, processes_ * lattice_contacts() + 2 * catoms);
    }

    MemoryPart bodies() const {
        const bool touch = world_.physics.spacing < 1 + kNear;
        // Of a block as it is placed, less those at its surface.
        const double at_start = touch ? lattice_contacts() : 0, most = std::max(at_start, kContactsInHeap * here_);
        const double each = (kBody + (processes_ > 1 ? kHandedOver : 0)) * here_;
        const double contact = kContact + (processes_ > 1 ? kHandedOverContact : 0);
        // Whom a program connects is not known; at most all at once.
        const bool asks = tuple::ProgramActions(module_).uses(ActionKind::Connect);
        const bool holds =
            std::ranges::any_of(world_.physics.groups, [](const world::CatomGroup& g) { return g.connected.value_or(false); }) ||
            (world_.robots && world_.robots->connects());
        const double loads = wants_loads() ? kLoads : 0;
        const double held = holds ? (kHeld + loads) * here_ : 0, asked = asks ? (kHeld + kAsks + loads) * here_ : 0;
        return {"bodies and contacts", {each + contact * at_start + held, each + contact * most + held + asked + joints()}};
    }

    // Where neighbours are listed: the table of links, which a graph has counted. Where messages take time also where each link is read,
    // and at most a mailbox for each link and direction, with what its reader knows of the neighbour; and on their way at most all that
    // every catom exports, once.
    MemoryPart links() const {
        const double ends =
            world_.is_graph() || world_.links ? ports_ * share_.catoms : 2 * lattice_contacts() * share_.catoms / std::max(1.0, here_);
        const double table = world_.is_graph() ? 0 : kLinkRow * here_ + kLinkEnd * ends;
        if (!world_.apart()) return {"links", exactly(table)};
        double exported = 0, under_way = 0;
        for (u32 c = 0; c < module_.column_count; ++c) {
            if (!module_.columns[c].exported) continue;
            exported += 1;
            under_way += kParcel + (module_.columns[c].rows ? static_cast<double>(module_.columns[c].row_bytes) * rows_of(c)
                                                            : module_.columns[c].stride);
        }
        const double read = table + (kLinkRead + (sim::Versions::suit(module_, world_) ? kLastArrival : 0)) * ends;
        const double known = ends * (kMailbox + static_cast<double>(tuple::Columns::bytes_for(module_, 1)));
        return {"links and messages on their way", {read, read + known + share_.catoms * under_way + ends * kUnderWay * exported}};
    }

    MemoryPart records() const {
        return {"facts, at most one of a predicate or one a link",
                exactly(static_cast<double>(tuple::Columns::bytes_for(module_, whole(here_))))};
    }

    MemoryPart rows() const {
        double most = 0;
        for (u32 c = 0; c < module_.column_count; ++c) {
            if (!module_.columns[c].rows) continue;
            // Blocks that have become too small stay in the pool.
            most += 2 * static_cast<double>(tuple::Columns::row_bytes_for(module_.columns[c], whole(rows_of(c))));
        }
        return {"facts of which there may be several", {0, most * here_}};
    }

    MemoryPart lists(int threads) const {
        double most = 0;
        for (u32 c = 0; c < module_.column_count; ++c)
            most += kList * module_.columns[c].list_count * (module_.columns[c].rows ? rows_of(c) : 1);
        return {"lists, strings and sets",
                {0, most * here_ + (most > 0 ? kScratchCatom * std::min(share_.catoms, kScratchBlock * threads) : 0)}};
    }

    // What evaluation sets aside until the end of the tick: of each catom that it is awake, at most all that neighbours read of it, and
    // what it sends to each neighbour.
    MemoryPart tick() const {
        // Two agendas, of this tick and of the next, and the groups of one.
        const auto agenda = [](double bits) {
            return 2 * static_cast<double>(eval::Agenda::bytes_for(eval::Agenda::kGroup, whole(bits))) / eval::Agenda::kGroup;
        };
        const double groups = sizeof(u32) / double{eval::Agenda::kGroup};
        const double awake = groups + agenda(kUsualBits), at_most = groups + agenda(kUsualBits + 2 * module_.column_count);
        double changes = 0, sent = 0;
        for (u32 c = 0; c < module_.column_count; ++c) {
            const ColumnInfo& column = module_.columns[c];
            if (column.exported) changes += kPlace + (column.rows ? static_cast<double>(column.row_bytes) * rows_of(c) : column.stride);
        }
        for (u32 p = 0; p < module_.predicate_count; ++p) {
            const PredicateInfo& info = module_.predicates[p];
            const double arguments = info.arity * double{sizeof(Value)};
            if (info.kind == PredicateKind::Linear && !info.auxiliary && info.column != kNone16)
                sent = std::max(sent, message(info) * (few() && catoms_named(info) > 0 ? here_ : 1));
            // In the list of its thread and in that of all.
            if (info.kind == PredicateKind::Action && info.column != kNone16) changes += 2 * sizeof(eval::Action) + arguments;
            if (info.rank_offset != kNone32) changes += kTombstone;
        }
        return {"one tick", {awake * share_.catoms, (at_most + changes + sent * ports_) * share_.catoms}};
    }

  private:
    static ByteRange exactly(double bytes) { return {bytes, bytes}; }

    double lattice_contacts() const {
        const double ports = world::Lattice(world_.lattice).ports();
        const bool flat = world::Lattice(world_.lattice).flat();
        return here_ * ports / 2 * (1 - 1 / std::pow(std::max(1.0, here_), flat ? 1.0 / 2 : 1.0 / 3));
    }

    // How many arguments of a predicate are catoms, besides the one that has the fact.
    static int catoms_named(const PredicateInfo& info) {
        return static_cast<int>(
            std::count_if(info.fields, info.fields + info.arity, [](const auto& f) { return f.type == ValueType::Node; }));
    }
    bool few() const { return here_ <= kFewCatoms; }

    // One for each neighbour if its facts may come from them or name them. Where there are few catoms, one for each that is named, which
    // each neighbour may name.
    double rows_of(u32 column) const {
        for (u32 p = 0; p < module_.predicate_count; ++p) {
            const PredicateInfo& info = module_.predicates[p];
            if (info.column != column) continue;
            const int named = catoms_named(info);
            if (named == 0) return info.kind == PredicateKind::Linear ? ports_ : 1;
            return !few() ? ports_ : named == 1 ? std::max<double>(ports_, here_) : ports_ * here_;
        }
        return 1;
    }

    // Of a graph: process and catom of a node; a node and an end of a link in the ensemble; and of METIS, measured, an end of a link in a
    // geometric graph and in a random one.
    static constexpr double kNode = 4 + 4, kNodeHere = 8 + 4 + 1 + 24 + 8, kEndHere = 6, kDividedWell = 14, kDividedBadly = 42;
    // Of the table of links: a catom, an end of a link, where it is read, and until when something is under way. A mailbox, with its index
    // among the catoms. What is on its way for all links that it takes, and its place in the queue of each.
    static constexpr double kLinkRow = 8, kLinkEnd = 6, kLinkRead = 4, kLastArrival = 2, kMailbox = 86, kParcel = 64, kUnderWay = 12;
    // A change that waits: catom, column, number of rows and where they are.
    static constexpr double kPlace = 24;
    // A linear fact as its sender writes it, and the receivers' rows of this delivery and the last one. Where a network delays it: in the
    // list of its sender, by receiver, and as it arrives; with the orders in which they are sorted.
    double message(const PredicateInfo& p) const {
        const double row = module_.columns[p.column].row_bytes;
        const double numbered = 3 * sizeof(eval::Message) + 2 * 2 * sizeof(u64) + 4 * sizeof(Keyed);
        return world_.apart() ? numbered + p.arity * double{sizeof(Value)}
                              : static_cast<double>(sent_bytes(module_.columns[p.column].row_bytes) + sizeof(u32)) + kSlack * 2 * row;
    }
    static constexpr double kSlack = 1.25;  // Room of a delivery for the next one.

    int processes_;
    const world::World& world_;
    const ModuleInfo& module_;
    const sim::ExpectedShare& share_;
    double here_;
    int ports_;
};

// The arguments of a predicate as a recording or a file of facts has them.
double arguments_of(const ModuleInfo& module, std::string_view predicate) {
    double most = 0;
    for (u32 p = 0; p < module.predicate_count; ++p)
        if (module.predicates[p].name == predicate) most = std::max(most, double{1} + module.predicates[p].arity);
    return most;
}

// A step of a recording: its columns, and what the digest keeps. Of several processes the first one gets all catoms packed and sorts them.
MemoryPart recording(const world::World& world, const ModuleInfo& module, double catoms, int processes) {
    double packed = 40, columns = 39;  // See Recorder::pack(), Step and RunningDigest.
    for (const std::string& name : world.record.predicates) {
        packed += 8 * arguments_of(module, name);
        columns += 8 * arguments_of(module, name);
    }
    // Of a process that is alone, the list of those that have changed; of others, what stands where in the packed bytes.
    const double at_once = processes > 1 ? packed + 20 : 4;
    const double bytes = kRecording + std::min(kChunkCaches, kChunkCachesCatom * catoms) + catoms * (at_once + columns);
    // Facts of which a catom has several are there once more, each with the catom.
    return {"a step of the recording", {bytes, bytes + (world.record.predicates.empty() ? 0 : catoms * 2 * packed)}, true};
}

// The facts of one predicate at a time, with the order of catoms.
MemoryPart facts_file(const ModuleInfo& module, record::FactsForm form, double catoms) {
    const double library = form == record::FactsForm::Hdf5 ? kHdf5 : 0;
    double arguments = 0;
    for (u32 p = 0; p < module.predicate_count; ++p)
        if (!module.predicates[p].auxiliary && module.predicates[p].column != kNone16)
            arguments = std::max(arguments, double{1} + module.predicates[p].arity);
    const double order = 16, fact = 12 + 12 * arguments;
    return {"facts to be written", {library + catoms * order, library + catoms * (order + 2 * fact)}, true};
}

// Two frames that the first process keeps, once pages have asked for them: numbers, cells and values of catoms, and what is seen of these,
// which may be all; and the answer to a body while one is made.
MemoryPart kept_frames(double catoms, double own_catoms) {
    constexpr double kKept = 4 + 8 + 0.5, kKeptByOwner = 4 + 0.5, kSeen = 32, kAsked = 44;
    return {"frames of the viewer", {0, 2 * ((kKept + kSeen) * catoms + kKeptByOwner * own_catoms) + kAsked * own_catoms}};
}

// One block of catoms at a time is packed and written.
MemoryPart checkpoint(const ModuleInfo& module, double catoms) {
    const double in_block = std::min(catoms, kCheckpointBlock);
    const double bytes = kGrown * in_block * (28 + static_cast<double>(tuple::Columns::bytes_for(module, 1)));
    return {"a checkpoint", {bytes, bytes}, true};
}

}  // namespace

ByteRange MemoryNeed::made() const {
    ByteRange all, passing;
    for (const MemoryPart& part : parts) {
        ByteRange& sum = part.passing ? passing : all;
        sum.least = part.passing ? std::max(sum.least, part.bytes.least) : sum.least + part.bytes.least;
        sum.most = part.passing ? std::max(sum.most, part.bytes.most) : sum.most + part.bytes.most;
    }
    return {all.least + passing.least, all.most + passing.most};
}

ByteRange MemoryNeed::peak() const {
    const ByteRange all = made();
    return {std::max(start, base + all.least), std::max(start, base + all.most)};
}

MemoryNeed memory_need(const world::World& world, const ModuleInfo& module, const RunOptions& options, int processes,
                       const std::optional<sim::BrickCounts>& counts) {
    const sim::ExpectedShares shares = sim::expected_shares(world, module, processes, counts);
    const ResidentMemory now = resident_memory();
    MemoryNeed need{.catoms = shares.catoms,
                    .own_catoms = shares.largest.catoms,
                    .base = static_cast<double>(now.now) + kLater + (world.is_free() ? kLaterOfBodies : 0),
                    .start = static_cast<double>(now.peak)};
    const Counting counting(world, module, shares.largest, processes);
    need.parts = {world.is_graph()  ? counting.nodes()
                  : world.is_free() ? counting.bodies()
                                    : counting.ensemble(),
                  counting.records(), counting.rows(), counting.lists(options.threads), counting.tick()};
    if (module.by_links && (!world.is_free() || world.links)) need.parts.push_back(counting.links());
    if (!options.record.empty()) need.parts.push_back(recording(world, module, shares.catoms, processes));
    if (!options.facts_out.empty()) need.parts.push_back(facts_file(module, record::facts_form(options.facts_out), shares.catoms));
    if (options.debug && options.debug->view && options.debug->view->share.file.empty() && !world.is_free() && !world.is_graph())
        need.parts.push_back(kept_frames(shares.catoms, shares.largest.catoms));
    if (!options.checkpoint.empty()) need.parts.push_back(checkpoint(module, shares.largest.catoms));
    return need;
}

}  // namespace meld::driver
