// A scene in a snapshot.
#include <vector>

#include "physics/scene/scene.h"
#include "physics/solver/engine.h"
#include "physics/solver/saved_bodies.h"

namespace meld::physics {

namespace {

// The error of bytes that end too early, which names them.
tl::unexpected<Error> damaged(const ByteReader& in) {
    return fail(in.outcome().error().problem, "It is damaged, or was made by another version", ExitCode::RecordingRefused);
}

}  // namespace

void SavedHome::write(ByteWriter& out) const {
    out.write(home);
    out.write_block(bodies);
    out.write_block(contacts);
}

SavedHome SavedHome::read(ByteReader& in) {
    SavedHome saved{.home = in.read<Home>()};
    saved.bodies = in.read_block();
    saved.contacts = in.read_block();
    return saved;
}

Result<std::vector<SavedHome::SavedPlace>> SavedHome::places() const {
    ByteReader in(bodies, "the bodies of a snapshot", ByteReader::Origin::Outside);
    std::vector<SavedPlace> places;
    each_saved_place(in, [&](BodyId body, Vec3 position_m) { places.push_back({body, position_m}); });
    if (in.failed()) return damaged(in);
    return places;
}

Home Scene::home(BodyId body) const { return engine_->home(world_->bodies.slot(body)); }

void Scene::save_home(Home home, std::span<const BodyId> bodies, ByteWriter& out) const {
    std::vector<std::uint32_t> slots;
    for (const BodyId body : bodies) slots.push_back(slot(body));
    ByteWriter saved, contacts;
    save_bodies(*world_, engine_->slots_of(home, slots), saved);
    engine_->save_home(home, saved, contacts);
    SavedHome{home, saved.view(), contacts.view()}.write(out);
}

void Scene::save_rest(ByteWriter& out) const {
    out.write(world_->tick);
    out.write(world_->last_step_s);
    engine_->save_rest(out);
}

void Scene::load_rest(ByteReader& in) {
    world_->tick = in.read<std::uint64_t>();
    world_->last_step_s = in.read<double>();
    engine_->load_rest(in);
}

Result<void> Scene::load_home(const SavedHome& saved, Holds holds) {
    ByteReader bodies(saved.bodies, "the bodies of a snapshot", ByteReader::Origin::Outside),
        contacts(holds == Holds::Ghosts ? std::span<const std::byte>() : saved.contacts, "the contacts of a snapshot",
                 ByteReader::Origin::Outside);
    const auto first = static_cast<std::uint32_t>(slot_count());
    if (auto done = load_bodies(*world_, holds, bodies); !done) return done;
    if (auto done = engine_->load_home(saved.home, first, holds, bodies, contacts); !done) return done;
    for (const ByteReader* in : {&bodies, &contacts}) {
        if (in->failed()) return damaged(*in);
        if (!in->done()) return damaged_snapshot("has too many bytes");
    }
    return {};
}

Result<void> Scene::loaded(Workers& workers) {
    contacts_known_ = false;
    // Engines that keep the substeps put them there to the last bit.
    for (MovingFrame& frame : world_->obstacles.frames()) frame.place(static_cast<double>(world_->tick) * world_->last_step_s);
    return engine_->loaded(workers);
}

}  // namespace meld::physics
