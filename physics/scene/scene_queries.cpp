// Reading a scene: states, contacts by body, sums, digest.
#include <algorithm>
#include <cstring>
#include <numbers>

#include "physics/scene/scene.h"
#include "physics/solver/engine.h"
#include "runtime/base/release_memory.h"

namespace meld::physics {

namespace {

Vec3 vector_of(const float (&v)[3]) { return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])}; }
Vec3 position(const Place& p) { return {p.x, p.y, p.z}; }

}  // namespace

bool Scene::has(BodyId body) const {
    const Bodies& bodies = world_->bodies;
    return bodies.has(body) && (bodies.properties[bodies.slot(body)].flags & kRemoved) == 0;
}

std::size_t Scene::body_count() const {
    const auto& properties = world_->bodies.properties;
    return static_cast<std::size_t>(std::count_if(properties.begin(), properties.end(),
                                                  [](const BodyProperties& one) { return (one.flags & (kRemoved | kGhost)) == 0; }));
}

std::vector<BodyId> Scene::bodies() const {
    std::vector<BodyId> ids;
    for (const BodyProperties& properties : world_->bodies.properties)
        if ((properties.flags & (kRemoved | kGhost)) == 0) ids.push_back(properties.id);
    std::sort(ids.begin(), ids.end());
    return ids;
}

BodyState Scene::state(BodyId body) const {
    const Bodies& bodies = world_->bodies;
    const std::uint32_t slot = bodies.slot(body);
    const Place& place = bodies.place[slot];
    const Orientation& turn = bodies.orientation[slot];
    return {position(place),
            {static_cast<double>(turn.w), static_cast<double>(turn.x), static_cast<double>(turn.y), static_cast<double>(turn.z)},
            vector_of(bodies.velocity[slot].linear),
            (1 / place.radius) * vector_of(bodies.velocity[slot].surface)};
}

Vec3 Scene::acceleration(BodyId body) const {
    const std::uint32_t slot = world_->bodies.slot(body);
    if (slot >= world_->last_good.velocity.size() || world_->last_step_s == 0) return {};
    return (1 / world_->last_step_s) *
           (vector_of(world_->bodies.velocity[slot].linear) - vector_of(world_->last_good.velocity[slot].linear));
}

double Scene::radius(BodyId body) const { return world_->bodies.place[world_->bodies.slot(body)].radius; }

std::optional<BodyShape> Scene::shape(BodyId body) const {
    const BodyShapes::Index index = world_->shapes.of(body);
    return index == 0 ? std::nullopt : std::optional(world_->shapes.kind(index).shape);
}

double Scene::surface_m2(BodyId body) const {
    const double r = radius(body);
    const auto own = shape(body);
    return own ? own->surface_m2() : 4 * std::numbers::pi * r * r;
}

bool Scene::nearer(BodyId body, BodyId other, double within_m) const {
    const auto shape_of = [&](BodyId id) { return shape(id).value_or(BodyShape{{}, radius(id)}); };
    const auto place_of = [&](BodyId id) { return Attitude{state(id).position_m, state(id).orientation}; };
    if (!shape(body) && !shape(other))
        return length(place_of(other).centre - place_of(body).centre) < radius(body) + radius(other) + within_m;
    return physics::nearer(shape_of(body), place_of(body), shape_of(other), place_of(other), within_m);
}

double Scene::moment_of_inertia(BodyId body) const {
    const BodyProperties& properties = world_->bodies.properties[world_->bodies.slot(body)];
    return static_cast<double>(properties.inertia_factor) * static_cast<double>(properties.mass) * radius(body) * radius(body);
}

SwitchedFeatures Scene::features(BodyId body) const {
    const Bodies& bodies = world_->bodies;
    if (bodies.features.empty()) return {};
    const Bodies::FeatureState& state = bodies.features[bodies.slot(body)];
    return {state.on, state.reversed};
}

double Scene::pressure(BodyId body) {
    double force = 0;
    for (const std::uint32_t index : contacts_of(body)) force += std::max(0.0, contacts()[index].normal_force_n);
    return force / surface_m2(body);
}

double Scene::energy_drawn_j(BodyId body) const {
    const Bodies& bodies = world_->bodies;
    return bodies.energy.empty() ? 0 : bodies.energy[bodies.slot(body)];
}

double Scene::temperature_k(BodyId body, std::size_t feature) const {
    const Bodies& bodies = world_->bodies;
    const std::uint32_t slot = bodies.slot(body);
    const std::vector<Feature>& table = world_->tables[bodies.features.empty() ? 0 : bodies.features[slot].table];
    return feature < table.size() ? world_->coils.kelvin(table[feature], body, feature) : Feature{}.ambient_k;
}

bool Scene::warming(double by_k) const { return world_->coils.warming(world_->tables, world_->bodies, by_k); }

bool Scene::fixed(BodyId body) const { return (world_->bodies.properties[world_->bodies.slot(body)].flags & kFixed) != 0; }
bool Scene::asleep(BodyId body) const { return engine_->asleep(world_->bodies.slot(body)); }
std::size_t Scene::awake_bodies() const { return engine_->awake_bodies(); }
const Obstacles& Scene::obstacles() const { return world_->obstacles; }
std::span<const TouchEvent> Scene::events() const { return world_->events; }
void Scene::forget_events() {
    world_->events.clear();
    if (world_->events.capacity() > world_->bodies.count() / 2) release_memory(world_->events);
}

std::uint32_t Scene::slot(BodyId body) const { return world_->bodies.slot(body); }
std::size_t Scene::slot_count() const { return world_->bodies.count(); }

void Scene::each_contact(const ContactVisitor& visit) const { engine_->each_contact(visit); }

void Scene::sum_normal_forces(std::vector<ExactSum>& of_slot, Workers& workers) const {
    of_slot.assign(slot_count(), {});
    engine_->add_normal_forces(of_slot, workers);
}

std::span<const ContactReport> Scene::contacts() {
    if (contacts_known_) return contacts_;
    contacts_.clear();
    each_contact([&](const ContactReport& contact) { contacts_.push_back(contact); });
    std::sort(contacts_.begin(), contacts_.end(), [](const ContactReport& a, const ContactReport& b) { return a.touch < b.touch; });
    const std::size_t count = world_->bodies.count();
    contact_start_.assign(count + 1, 0);
    const auto ends = [&](const ContactReport& contact, const auto& f) {
        f(world_->bodies.slot(contact.touch.body));
        if (!contact.touch.other_is_obstacle) f(world_->bodies.slot(contact.touch.other));
    };
    for (const ContactReport& contact : contacts_) ends(contact, [&](std::uint32_t slot) { ++contact_start_[slot + 1]; });
    for (std::size_t slot = 0; slot < count; ++slot) contact_start_[slot + 1] += contact_start_[slot];
    contact_index_.resize(contact_start_[count]);
    std::vector<std::uint32_t> next(contact_start_.begin(), contact_start_.end() - 1);
    for (std::size_t i = 0; i < contacts_.size(); ++i)
        ends(contacts_[i], [&](std::uint32_t slot) { contact_index_[next[slot]++] = static_cast<std::uint32_t>(i); });
    contacts_known_ = true;
    return contacts_;
}

std::span<const std::uint32_t> Scene::contacts_of(BodyId body) {
    contacts();
    const std::uint32_t slot = world_->bodies.slot(body);
    if (slot + 1u >= contact_start_.size()) return {};
    return {contact_index_.data() + contact_start_[slot], contact_index_.data() + contact_start_[slot + 1]};
}

Vec3 Scene::spin_of(std::uint32_t slot) const {
    return (1 / world_->bodies.place[slot].radius) * vector_of(world_->bodies.velocity[slot].surface);
}

Vec3 Scene::spin_momentum(std::uint32_t slot) const {
    const BodyProperties& what = world_->bodies.properties[slot];
    const double radius = world_->bodies.place[slot].radius;
    const Vec3 spin = spin_of(slot);
    const BodyShapes::Index index = world_->shapes.of(what.id);
    if (index == 0) return (static_cast<double>(what.inertia_factor) * radius * radius) * spin;
    const BodyShapes::Kind& kind = world_->shapes.kind(index);
    const Quat turn = kind.principal(widened(world_->bodies.orientation[slot]));
    const Vec3 own = rotate(conjugate(turn), spin), inertia = kind.inertia_per_kg_m2;
    return rotate(turn, {inertia.x * own.x, inertia.y * own.y, inertia.z * own.z});
}

double Scene::kinetic_energy_j() const {
    const Bodies& bodies = world_->bodies;
    double sum = 0;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        if (bodies.properties[slot].flags & (kFixed | kRemoved | kGhost)) continue;
        const Vec3 v = vector_of(bodies.velocity[slot].linear);
        sum += static_cast<double>(bodies.properties[slot].mass) / 2 * (dot(v, v) + dot(spin_of(slot), spin_momentum(slot)));
    }
    return sum;
}

double Scene::potential_energy_j() const {
    const Bodies& bodies = world_->bodies;
    double sum = 0;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
        if ((bodies.properties[slot].flags & (kFixed | kRemoved | kGhost)) == 0)
            sum -= static_cast<double>(bodies.properties[slot].mass) * dot(world_->settings.gravity_m_s2, position(bodies.place[slot]));
    return sum;
}

Vec3 Scene::momentum() const {
    const Bodies& bodies = world_->bodies;
    Vec3 sum;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
        if ((bodies.properties[slot].flags & (kFixed | kRemoved | kGhost)) == 0)
            sum = sum + static_cast<double>(bodies.properties[slot].mass) * vector_of(bodies.velocity[slot].linear);
    return sum;
}

Vec3 Scene::angular_momentum() const {
    const Bodies& bodies = world_->bodies;
    Vec3 sum;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        if (bodies.properties[slot].flags & (kFixed | kRemoved | kGhost)) continue;
        const double mass = static_cast<double>(bodies.properties[slot].mass);
        sum = sum + mass * cross(position(bodies.place[slot]), vector_of(bodies.velocity[slot].linear)) + mass * spin_momentum(slot);
    }
    return sum;
}

Digest Scene::digest() const {
    struct Row {
        Place place;
        Orientation orientation;
        float linear[3], surface[3];
        std::uint32_t id;
        // Named, so that no byte of a row is uninitialized.
        std::uint32_t zero;
    };
    static_assert(sizeof(Row) == 96);
    const Bodies& bodies = world_->bodies;
    Digest digest;
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
        if (bodies.properties[slot].flags & (kRemoved | kGhost)) continue;
        Row row;
        std::memset(&row, 0, sizeof row);
        row.place = bodies.place[slot];
        row.orientation = bodies.orientation[slot];
        std::memcpy(row.linear, bodies.velocity[slot].linear, sizeof row.linear);
        std::memcpy(row.surface, bodies.velocity[slot].surface, sizeof row.surface);
        row.id = bodies.properties[slot].id;
        digest.add_bytes(std::as_bytes(std::span(&row, 1)));
    }
    return digest;
}

std::uint64_t Scene::tick() const { return world_->tick; }
StageTimes Scene::stage_times() const { return world_->times; }
std::size_t Scene::bytes() const {
    const LastGood& kept = world_->last_good;
    return world_->bodies.bytes() + world_->coils.bytes() + engine_->bytes() + kept.velocity.capacity() * sizeof(BodyVelocity) +
           kept.place.capacity() * sizeof(Place) + kept.orientation.capacity() * sizeof(Orientation);
}
double Scene::residual() { return engine_->residual(); }

}  // namespace meld::physics
