#include "runtime/sim/bodies/divided_bodies.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/packets.h"

namespace meld::sim {

namespace {

// The curve passes through as many blocks as a lattice has bricks; blocks beyond share the owners of the last.
constexpr std::int32_t kFarthest = (world::kCellLimit >> 3) - 1;

// Space is divided again if the work of a process exceeds kMaxLoad times the mean and that helps. Blocks are not split, so a small ensemble
// cannot be divided evenly, and a division that is still uneven must be better by this factor to be worth the migration.
constexpr double kMaxLoad = 1.25, kWorthMoving = 0.9;

// The greatest of these as a multiple of their mean.
double load_of(const std::vector<std::uint64_t>& work) {
    const std::uint64_t sum = std::accumulate(work.begin(), work.end(), std::uint64_t{0});
    const auto greatest = static_cast<double>(*std::max_element(work.begin(), work.end()));
    return sum == 0 ? 1 : greatest * static_cast<double>(work.size()) / static_cast<double>(sum);
}

// The messages of a subdomain as packets.
std::vector<comm::Packet> packets_of(physics::Subdomain::Messages messages) {
    std::vector<comm::Packet> packets;
    for (auto& [to, bytes] : messages)
        if (!bytes.empty()) packets.push_back({to, bytes.take()});
    return packets;
}

// The bitwise or over all processes.
std::uint8_t join_bits(Subdomain& subdomain, std::uint8_t bits) {
    ByteWriter mine;
    mine.write(bits);
    std::uint8_t all = 0;
    for (const std::byte theirs : subdomain.comm.allgather(mine.view())) all |= std::to_integer<std::uint8_t>(theirs);
    return all;
}

}  // namespace

std::vector<std::vector<std::byte>> gather_bytes(Subdomain& subdomain, ByteWriter& mine) {
    if (!subdomain.alone()) return subdomain.comm.allgather_any(mine.view());
    std::vector<std::vector<std::byte>> all;
    all.push_back(mine.take());
    return all;
}

std::vector<physics::ConnectionPair> gather_pairs(Subdomain& subdomain, const std::vector<physics::ConnectionPair>& ours) {
    ByteWriter mine;
    for (const auto& [one, other] : ours) mine.write(one), mine.write(other);
    std::vector<physics::ConnectionPair> all;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "pairs of bodies"); !in.done();) {
            const auto one = in.read<physics::BodyId>();
            all.emplace_back(one, in.read<physics::BodyId>());
        }
    std::ranges::sort(all);
    const auto twice = std::ranges::unique(all);
    all.erase(twice.begin(), twice.end());
    return all;
}

std::vector<comm::Packet> exchange_bytes(Subdomain& subdomain, std::vector<ByteWriter>& by_process) {
    return subdomain.comm.exchange(comm::take_packets(by_process));
}

Result<void> agree_on_error(Subdomain& subdomain, const Result<void>& mine) {
    if (subdomain.alone()) return mine;
    ByteWriter bytes;
    if (!mine) {
        bytes.write_string(mine.error().problem);
        bytes.write_string(mine.error().suggestion);
        bytes.write(mine.error().code);
    }
    for (const auto& theirs : gather_bytes(subdomain, bytes)) {
        if (theirs.empty()) continue;
        ByteReader in(theirs, "the error of a process");
        Error error;
        error.problem = in.read_string();
        error.suggestion = in.read_string();
        error.code = in.read<ExitCode>();
        return tl::unexpected<Error>(error);
    }
    return {};
}

// Blocks are ordered by the curve of a lattice's bricks, however the catoms were placed.
world::BrickKey place_on_curve(physics::BlockCoordinates block) {
    static const world::Lattice curve(world::LatticeKind::Cubic);
    const auto within = [](std::int32_t x) { return std::clamp(x, -kFarthest, kFarthest); };
    return curve.brick_key({within(block.x), within(block.y), within(block.z)});
}

DividedBodies::DividedBodies(Subdomain& subdomain, physics::Scene& scene) {
    subdomain_ = std::make_unique<physics::Subdomain>(
        scene, [this](physics::BlockCoordinates block) { return owner(block); }, subdomain.comm.process(), subdomain.comm.processes());
    partition_.emplace(weigh_all(subdomain), subdomain.comm.processes());
}

DividedBodies::DividedBodies(Subdomain& subdomain, physics::Scene& scene, const partition::Partition& partition) : partition_(partition) {
    subdomain_ = std::make_unique<physics::Subdomain>(
        scene, [this](physics::BlockCoordinates block) { return owner(block); }, subdomain.comm.process(), subdomain.comm.processes());
}

Result<void> DividedBodies::load_ghosts(Subdomain& subdomain, physics::Scene& scene, const std::vector<physics::SavedHome>& ours) {
    std::vector<ByteWriter> out(static_cast<std::size_t>(subdomain.comm.processes()));
    for (const physics::SavedHome& home : ours)
        for (const int holder : subdomain_->holders(physics::unpack(home.home)))
            physics::SavedHome{home.home, home.bodies, {}}.write(out[static_cast<std::size_t>(holder)]);
    Result<void> fine;
    for (const comm::Packet& packet : exchange_bytes(subdomain, out))
        for (ByteReader in(packet.bytes, "homes of a snapshot"); fine && !in.done();)
            fine = scene.load_home(physics::SavedHome::read(in), physics::Holds::Ghosts);
    return fine;
}

Result<void> DividedBodies::load_joined(Subdomain& subdomain, std::span<const physics::ConnectionPair> also) {
    // All processes have read the joints and composites of all.
    if (!subdomain_->has_joined()) return {};
    using Joined = physics::Subdomain::JoinedBody;
    ByteWriter mine;
    for (const Joined& body : subdomain_->joined_bodies(also)) mine.write(body);
    std::vector<Joined> all;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "bodies that hang together"); !in.done();) all.push_back(in.read<Joined>());
    subdomain_->learn_joined(all, also);
    Result<void> fine;
    for (const comm::Packet& packet : subdomain.comm.exchange(packets_of(subdomain_->pack_joined())))
        if (fine) fine = subdomain_->unpack_joined(packet.bytes);
    return fine;
}

int DividedBodies::owner(physics::BlockCoordinates block) const {
    const auto [at, made] = owners_.try_emplace(physics::pack(block), 0);
    if (made) at->second = partition_->owner(place_on_curve(block));
    MELD_ENSURE(at->second >= 0, "block {} {} {}", block.x, block.y, block.z);
    return at->second;
}

DividedBodies::Weights DividedBodies::weigh_all(Subdomain& subdomain) const {
    std::map<world::BrickKey, std::uint32_t> mine, all;
    for (const auto& [block, weight] : subdomain_->weights()) mine[place_on_curve(block)] += weight;
    ByteWriter bytes;
    for (const auto& [key, weight] : mine) {
        bytes.write(key);
        bytes.write(weight);
    }
    for (const auto& from : gather_bytes(subdomain, bytes))
        for (ByteReader in(from, "weights of blocks"); !in.done();) {
            const auto key = in.read<world::BrickKey>();
            all[key] += in.read<std::uint32_t>();
        }
    return {all.begin(), all.end()};
}

void DividedBodies::balance(Subdomain& subdomain) {
    const auto processes = static_cast<std::size_t>(subdomain.comm.processes());
    // The work of each process after bodies have migrated.
    std::vector<std::uint64_t> mine(processes), all(processes);
    for (const auto& [block, weight] : subdomain_->weights()) mine[static_cast<std::size_t>(owner(block))] += weight;
    ByteWriter bytes;
    for (std::size_t p = 0; p < processes; ++p) {
        if (mine[p] == 0) continue;
        bytes.write(p);
        bytes.write(mine[p]);
    }
    for (const auto& from : gather_bytes(subdomain, bytes))
        for (ByteReader in(from, "work of processes"); !in.done();) {
            const auto p = in.read<std::size_t>();
            MELD_CHECK(p < processes, "work of process {} of {}", p, processes);
            all[p] += in.read<std::uint64_t>();
        }
    double load = load_of(all);
    if (load > kMaxLoad) {
        const Weights weights = weigh_all(subdomain);
        partition::Partition better(weights, subdomain.comm.processes());
        std::fill(all.begin(), all.end(), 0);
        for (const auto& [key, weight] : weights) all[static_cast<std::size_t>(better.owner(key))] += weight;
        if (const double load_there = load_of(all); load_there <= kMaxLoad || load_there < kWorthMoving * load) {
            partition_ = std::move(better);
            owners_.clear();
            load = load_there;
            ++divisions_;
        }
    }
    greatest_load_ = std::max(greatest_load_, load);
}

Result<void> DividedBodies::recompose(Subdomain& subdomain) {
    ByteWriter held = subdomain_->members_held();
    Result<void> fine;
    for (const comm::Packet& packet : subdomain.comm.exchange(packets_of(subdomain_->pack_members(gather_bytes(subdomain, held)))))
        if (fine) fine = subdomain_->unpack_members(packet.bytes);
    if (auto agreed = agree_on_error(subdomain, fine); !agreed) return agreed;
    subdomain_->recompose(subdomain.workers);
    return {};
}

Result<bool> DividedBodies::redistribute(Subdomain& subdomain, double step_s, int substeps) {
    MELD_EXPECT(!subdomain.alone());
    constexpr std::uint8_t kRebuilds = 1, kRecomposes = 2;
    std::uint8_t wishes = subdomain_->recomposes() ? kRecomposes : 0;
    if (subdomain_->must_rebuild(step_s, substeps)) wishes |= kRebuilds;
    wishes = join_bits(subdomain, wishes);
    if (wishes == 0) return false;
    if ((wishes & kRecomposes) != 0)
        if (auto done = recompose(subdomain); !done) return tl::unexpected<Error>(done.error());
    ByteWriter mine;
    mine.write(subdomain_->velocities());
    physics::Velocities velocities;
    const std::vector<std::byte> of_all = subdomain.comm.allgather(mine.view());
    for (ByteReader theirs(of_all, "the velocities of processes"); !theirs.done();) velocities.add(theirs.read<physics::Velocities>());
    subdomain_->set_velocities(velocities, step_s, substeps);
    balance(subdomain);
    Result<void> fine;
    for (const comm::Packet& packet : subdomain.comm.exchange(packets_of(subdomain_->pack_bodies(subdomain.workers))))
        if (auto done = subdomain_->unpack_bodies(packet.bytes); !done && fine) fine = done;
    subdomain_->unpacked();
    if (auto agreed = agree_on_error(subdomain, fine); !agreed) return tl::unexpected<Error>(agreed.error());
    return true;
}

Result<physics::StepReport> DividedBodies::step(Subdomain& subdomain, double step_s, int substeps) {
    Result<void> fine;
    const std::vector<physics::Stage> stages = subdomain_->stages(step_s, substeps);
    for (std::size_t i = 0; i < stages.size(); ++i) {
        physics::Stage stage = stages[i];
        const int rounds = stage.has_rounds() ? subdomain_->rounds() : 1;
        for (stage.round = 0; stage.round < rounds; ++stage.round) {
            if (fine) fine = subdomain_->run(stage, subdomain.workers);
            if (!stage.must_exchange()) continue;
            // A process that has failed sends nothing more; the others are informed at the end.
            const std::vector<comm::Packet> received =
                subdomain.comm.exchange(fine ? packets_of(subdomain_->pack(stage)) : std::vector<comm::Packet>{});
            for (const comm::Packet& packet : received)
                if (fine) subdomain_->unpack(stage, packet.bytes);
        }
        if (!stage.must_agree()) continue;
        const std::uint8_t colours = join_bits(subdomain, fine ? subdomain_->bouncing_colours() : std::uint8_t{0});
        if (colours != 0 && subdomain_->shares_composites()) {
            ByteWriter blocks = fine ? subdomain_->bouncing_blocks() : ByteWriter();
            subdomain_->agree_on_bounces(gather_bytes(subdomain, blocks));
        }
        i += static_cast<std::size_t>(stage.left_out(colours));
    }
    if (auto agreed = agree_on_error(subdomain, fine); !agreed) return tl::unexpected<Error>(agreed.error());
    return subdomain_->finish();
}

void DividedBodies::complete(Subdomain& subdomain, std::vector<ExactSum>& normal_forces) const {
    for (const comm::Packet& packet : subdomain.comm.exchange(packets_of(subdomain_->pack_sums(normal_forces))))
        subdomain_->unpack_sums(normal_forces, packet.bytes);
}

}  // namespace meld::sim
