// The bodies of a run in a snapshot. What catoms sense of them are facts, which are saved as such; positions follow from bodies but in the
// first tick, before anything has moved.
#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <unordered_set>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/sim/bodies/free_motion.h"
#include "runtime/sim/bodies/saved_places.h"
#include "runtime/sim/core/damaged_snapshot.h"

namespace meld::sim {

namespace {

// The bytes of several chunks are kept in one buffer.
constexpr std::size_t kKept_bytes = std::size_t{32} << 20;

bool same_bits(const world::Vec3& one, const world::Vec3& other) { return std::memcmp(&one, &other, sizeof one) == 0; }

// Positions of some catoms of a chunk, by their places in it.
using SomePositions = std::vector<std::pair<std::uint32_t, world::Vec3>>;

void save_some(const SomePositions& some, ByteWriter& out) {
    out.write_count(some.size());
    for (const auto& [at, position] : some) {
        out.write(at);
        out.write(position);
    }
}

void load_some(ByteReader& in, std::span<const tuple::SavedCatom> catoms, std::vector<std::pair<Catom, world::Vec3>>& to) {
    for (auto left = in.read_count(sizeof(std::uint32_t) + sizeof(world::Vec3)); left > 0; --left) {
        const auto at = in.read<std::uint32_t>();
        const auto position = in.read<world::Vec3>();
        if (at < catoms.size() && catoms[at].here()) to.emplace_back(catoms[at].catom, position);
    }
}

}  // namespace

Result<void> FreeMotion::resume(Subdomain& subdomain) {
    if (auto fine = check(subdomain); !fine) return fine;
    return look_up(subdomain);
}

void FreeMotion::save_catoms(const Subdomain& subdomain, std::span<const Catom> catoms, ByteWriter& out) const {
    const physics::Scene& scene = *physics_.scene;
    SomePositions positions, sensed;
    std::map<physics::Home, std::vector<physics::BodyId>> homes;
    for (std::uint32_t i = 0; i < catoms.size(); ++i) {
        const auto id = static_cast<physics::BodyId>(subdomain.ensemble.id(catoms[i]));
        homes[scene.home(id)].push_back(id);
        const world::Vec3 at = subdomain.ensemble.position(catoms[i]);
        if (!same_bits(at, to_diameters(world_, scene.state(id).position_m))) positions.emplace_back(i, at);
        if (subdomain.senses_positions() && !same_bits(at, subdomain.sensed_position(catoms[i])))
            sensed.emplace_back(i, subdomain.sensed_position(catoms[i]));
    }
    save_some(positions, out);
    save_some(sensed, out);
    for (const auto& [home, bodies] : homes) scene.save_home(home, bodies, out);
}

void FreeMotion::load_catoms(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in) {
    load_some(in, catoms, loading_.positions);
    load_some(in, catoms, loading_.sensed);
    // What points into a buffer stays where it is. Large ones are in huge pages.
    const bool small = loading_.bytes.empty();  // Perhaps all there is.
    if (small || loading_.bytes.back().capacity() - loading_.bytes.back().size() < in.left())
        loading_.bytes.emplace_back().reserve(std::max(in.left(), small ? 0 : kKept_bytes));
    physics::Buffer<std::byte>& kept = loading_.bytes.back();
    const auto keep = [&](std::span<const std::byte> bytes) {
        const std::size_t at = kept.size();
        kept.resize(at + bytes.size());
        if (!bytes.empty()) std::memcpy(kept.data() + at, bytes.data(), bytes.size());
        return std::span<const std::byte>(kept).subspan(at);
    };
    while (!in.done()) {
        const auto home = physics::SavedHome::read(in);
        if (subdomain.partition->owner(place_on_curve(physics::unpack(home.home))) != subdomain.comm.process()) continue;
        const auto bodies = keep(home.bodies), contacts = keep(home.contacts);
        loading_.homes.push_back({home.home, bodies, contacts});
    }
}

void FreeMotion::save_rest(const Subdomain&, ByteWriter& out) const {
    out.write(kinds_.radii);
    out.write_count(kinds_.surfaces.size());
    for (const Surface& surface : kinds_.surfaces) out.write(surface);
    if (!world_.physics.movers.empty()) {
        out.write_count(kinds_.moved.size());
        for (const MovedCatom& moved : kinds_.moved) out.write(moved);
    }
    ByteWriter scene;
    physics_.scene->save_rest(scene);
    out.write_block(scene.view());
    out.write_count(links_.waiting().size());
    for (const ContactLinks::Pair& pair : links_.waiting()) out.write(pair);
    out.write_count(fixed_touches_.size());
    for (const physics::TouchEvent& e : fixed_touches_) out.write(ContactLinks::Pair{e.touch.body, e.touch.other});
    connections_.save(out);
    lamps_.save(out);
    out.write(crossed_);
    out.write(lost_count_);
    out.write(broken_count_);
    out.write(broken_joints_);
}

Result<void> FreeMotion::load_rest(Subdomain& subdomain, ByteReader& in) {
    kinds_.radii = in.read<RadiusRange>();
    for (auto left = in.read_count(sizeof(Surface)); left > 0; --left) kinds_.surfaces.insert(in.read<Surface>());
    // The same from each process.
    if (!world_.physics.movers.empty()) {
        kinds_.moved.resize(in.read_count(sizeof(MovedCatom)));
        for (MovedCatom& moved : kinds_.moved) moved = in.read<MovedCatom>();
    }
    const auto scene = in.read_block();
    loading_.scenes.emplace_back(scene.begin(), scene.end());
    std::vector<ContactLinks::Pair> waiting(in.read_count(sizeof(ContactLinks::Pair)));
    for (ContactLinks::Pair& pair : waiting) pair = in.read<ContactLinks::Pair>();
    links_.change_hands(subdomain, waiting);
    // Before the first tick, every process knows all of them.
    fixed_touches_.clear();
    for (auto left = in.read_count(sizeof(ContactLinks::Pair)); left > 0; --left) {
        const auto pair = in.read<ContactLinks::Pair>();
        fixed_touches_.push_back({{pair.first, pair.second, false}, true});
    }
    connections_.load(in);
    lamps_.load(in);
    // Of the whole run, which process 0 remembers.
    const auto crossed = in.read<std::uint64_t>();
    if (subdomain.comm.process() == 0) crossed_ += crossed;
    lost_count_ = in.read<std::uint64_t>();
    broken_count_ = in.read<std::uint64_t>();
    broken_joints_ = in.read<std::uint64_t>();
    return {};
}

Result<void> FreeMotion::resumed(Subdomain& subdomain) {
    if (auto done = agree_on_error(subdomain, load_scene(subdomain)); !done) return done;
    // Before the first tick no body is in a block yet, and none is a ghost.
    const bool begun = subdomain.tick() > 0;
    if (divided_ && begun)
        if (auto done = agree_on_error(subdomain, divided_->load_ghosts(subdomain, *physics_.scene, loading_.homes)); !done) return done;
    if (divided_)
        if (auto done = agree_on_error(subdomain, divided_->load_joined(subdomain, connections_.lasting())); !done) return done;
    Result<void> placed = physics_.scene->loaded(subdomain.workers);
    if (placed && divided_) divided_->loaded();
    if (placed && !connections_.fits(subdomain, *physics_.scene)) placed = damaged("has a touch of a body that is not there");
    if (placed) placed = place_catoms(subdomain);
    if (auto done = agree_on_error(subdomain, placed); !done) return done;
    // A program that goes on with the state of another may be the first that reads it.
    connections_.sense_all(subdomain, *physics_.scene, senses_);
    loading_ = {};
    if (in_range_) in_range_->seen = subdomain.ensemble.links().version();
    moved_ = begun;
    bodies_ = subdomain.ensemble.owned_count();
    awake_ = begun ? physics_.scene->awake_bodies() : bodies_;
    subdomain.set_moving(goes_on());
    subdomain.set_motion_bytes(physics_.scene->bytes());
    return {};
}

Result<void> FreeMotion::load_scene(Subdomain& subdomain) {
    if (loading_.scenes.empty()) return damaged("has no bodies");
    auto made = make_physics_scene(world_, kinds_.radii, BodySenses::senses_acceleration(subdomain));
    if (!made) return tl::unexpected<Error>(made.error());
    physics_ = std::move(*made);
    if (!subdomain.alone()) physics_.scene->share();
    if (subdomain.tick() > 0 && changes_gravity(world_)) {
        const auto steps = static_cast<std::uint64_t>(subdomain.tick()) * static_cast<std::uint64_t>(world_.physics.steps);
        if (auto set = physics_.scene->set_gravity(gravity_in_step(world_, steps - 1)); !set) return set;
    }
    if (auto added = add_movers(world_, physics_, kinds_.moved); !added) return added;
    if (auto added = add_materials(world_, physics_, kinds_.surfaces); !added) return tl::unexpected<Error>(added.error());
    // A home takes some room besides that of its bodies.
    physics_.scene->reserve(subdomain.ensemble.owned_count() + loading_.homes.size(), subdomain.next_id());
    if (!subdomain.alone()) divided_.emplace(subdomain, *physics_.scene, *subdomain.partition);
    for (const std::vector<std::byte>& kept : loading_.scenes) {
        ByteReader in(kept, "the scene of a snapshot", ByteReader::Origin::Outside);
        physics_.scene->load_rest(in);
        if (in.failed() || !in.done()) return damaged("has an invalid scene");
    }
    if (connections_.are_beside_joints(subdomain, *physics_.scene)) physics_.scene->have_all_joined();
    // In the order in which the engine wants them.
    std::ranges::sort(loading_.homes, {}, &physics::SavedHome::home);
    for (const physics::SavedHome& home : loading_.homes)
        if (auto loaded = physics_.scene->load_home(home, physics::Holds::Own); !loaded) return loaded;
    tell_looks(subdomain);
    return {};
}

Result<void> FreeMotion::place_catoms(Subdomain& subdomain) {
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        const auto id = static_cast<physics::BodyId>(subdomain.ensemble.id(c));
        if (!physics_.scene->has(id) && !subdomain.owned(c) && in_range_) continue;
        if (!physics_.scene->has(id)) return damaged("has a catom @" + std::to_string(id) + " without a body");
        subdomain.place(c, to_diameters(world_, physics_.scene->state(id).position_m));
    }
    for (const auto& [catom, position] : loading_.positions) subdomain.place(catom, position);
    if (!subdomain.senses_positions()) return {};
    for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) subdomain.sense_position(c, subdomain.ensemble.position(c));
    for (const auto& [catom, position] : loading_.sensed) subdomain.sense_position(catom, position);
    return {};
}

Result<void> place_saved_bodies(Subdomain& subdomain, std::span<const tuple::SavedCatom> catoms, ByteReader& in) {
    std::vector<std::pair<Catom, world::Vec3>> positions, sensed;
    load_some(in, catoms, positions);
    load_some(in, catoms, sensed);
    const auto place = [&](Catom catom, const world::Vec3& position) {
        subdomain.place(catom, position);
        if (subdomain.senses_positions()) subdomain.sense_position(catom, position);
    };
    std::unordered_set<Catom> placed;
    while (!in.done()) {
        const auto places = physics::SavedHome::read(in).places();
        if (!places) return tl::unexpected<Error>(places.error());
        for (const auto& [body, position_m] : *places)
            if (const std::optional<Catom> catom = subdomain.ensemble.find(body)) {
                place(*catom, to_diameters(subdomain.world, position_m));
                placed.insert(*catom);
            }
    }
    for (const tuple::SavedCatom& each : catoms)
        if (each.here() && !placed.contains(each.catom))
            return damaged("has a catom @" + std::to_string(subdomain.ensemble.id(each.catom)) + " without a body");
    for (const auto& [catom, position] : positions) place(catom, position);
    if (!subdomain.senses_positions()) return {};
    for (const auto& [catom, position] : sensed) subdomain.sense_position(catom, position);
    return {};
}

}  // namespace meld::sim
