// The original design's engine, for study: bins filled by atomic exchange, and a sweep in which all workers take contacts and write
// velocities without locks. Two workers that write one body at the same time lose part of an impulse; later sweeps repair most of it.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "physics/collision/broadphase.h"
#include "physics/comparison/contact_log.h"
#include "physics/comparison/engines.h"
#include "physics/comparison/pairwise_features.h"
#include "physics/solver/engine.h"
#include "physics/solver/feature_wrenches.h"
#include "physics/solver/kernels.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kPerJob = 2048;
// The second body of a contact with an obstacle.
constexpr std::uint32_t kNobody = 0xffffffff;

struct FlatContact {
    std::uint32_t a, b;
    std::uint32_t obstacle;
    float normal[3];
    float gap;
    float friction;
    float bounce_speed;
    float impulse;
    float tangent[3];
};

// Plain moves on every processor, but defined behaviour when another worker writes.
float read(float& value) { return std::atomic_ref(value).load(std::memory_order_relaxed); }
void add(float& value, float change) {
    std::atomic_ref shared(value);
    shared.store(shared.load(std::memory_order_relaxed) + change, std::memory_order_relaxed);
}

class HashEngine final : public Engine {
  public:
    explicit HashEngine(World& world) : world_(world) {}

    Result<StepReport> step(const StepTimes& times, Workers& workers) override {
        world_.events.clear();
        if (auto dropped = drop_removed(workers); !dropped) return tl::unexpected(dropped.error());
        Bodies& bodies = world_.bodies;
        LastGood& kept = world_.last_good;
        if (world_.settings.keep_last_good || world_.settings.keep_former_velocities)
            kept.velocity.assign(bodies.velocity.begin(), bodies.velocity.end());
        if (world_.settings.keep_last_good) {
            kept.place.assign(bodies.place.begin(), bodies.place.end());
            kept.orientation.assign(bodies.orientation.begin(), bodies.orientation.end());
            kept.complete = true;
        }
        world_.obstacles.prepare(workers.threads());
        const Rules rules = rules_for(world_.settings, times, world_.smallest_diameter_m());
        min_bounce_speed_ = rules.bounce.min_speed;
        {
            const StageClock clock(world_.times.actuation);
            if (auto pulled = features_.find(world_, times.dt_s, workers); !pulled) return tl::unexpected(pulled.error());
        }
        for (int substep = 0; substep < times.substeps; ++substep)
            if (auto done = substep_once(rules, workers); !done) return tl::unexpected(done.error());
        if (world_.has_features()) account_charges(world_, workers);
        report_events(times);
        return StepReport{.bodies = bodies.count(), .awake_bodies = bodies.count(), .candidates = candidates_, .rebuilt = true};
    }

    void structure_changed() override { removed_ = true; }
    void body_changed(std::uint32_t, bool) override {}
    void gravity_changed() override {}
    void state_restored() override { contacts_.clear(); }
    void each_contact(const ContactVisitor& visit) const override {
        std::for_each(log_.contacts().begin(), log_.contacts().end(), std::cref(visit));
    }
    void add_normal_forces(std::span<ExactSum> of_slot, Workers&) const override { log_.add_normal_forces(world_.bodies, of_slot); }
    std::size_t bytes() const override { return contacts_.capacity() * sizeof(FlatContact) + log_.bytes(); }
    double residual() override {
        double change = 0, impulse = 0;
        for (FlatContact contact : contacts_) {
            const float before = contact.impulse;
            change += std::pow(static_cast<double>(wanted(contact) - before), 2);
            impulse += std::pow(static_cast<double>(before), 2);
        }
        return impulse > 0 ? std::sqrt(change / impulse) : 0;
    }

    std::size_t awake_bodies() const override { return world_.bodies.count(); }
    std::vector<std::uint32_t> slots_of(Home, std::span<const std::uint32_t>) const override { return all_slots(world_.bodies); }
    void save_home(Home, ByteWriter&, ByteWriter& contacts) const override { log_.save(world_.bodies, contacts); }
    Result<void> load_home(Home, std::uint32_t, Holds, ByteReader&, ByteReader& contacts) override { return log_.load(world_, contacts); }
    Result<void> loaded(Workers&) override {
        removed_ = true;
        return {};
    }

  private:
    Result<void> drop_removed(Workers& workers) {
        if (!std::exchange(removed_, false)) return {};
        Bodies& bodies = world_.bodies;
        std::vector<std::uint32_t> kept;
        for (std::uint32_t slot = 0; slot < bodies.count(); ++slot)
            if ((bodies.properties[slot].flags & kRemoved) == 0) kept.push_back(slot);
        if (kept.size() != bodies.count()) bodies.permute(kept, workers);
        return {};
    }

    Result<void> substep_once(const Rules& rules, Workers& workers) {
        Bodies& bodies = world_.bodies;
        const auto count = static_cast<std::uint32_t>(bodies.count());
        {
            const StageClock clock(world_.times.pairs);
            if (auto found = broadphase_->find(bodies, 0, workers); !found) return found;
        }
        {
            const StageClock clock(world_.times.refresh);
            if (auto collided = collide(workers); !collided) return collided;
        }
        accelerate(bodies.velocity.data(), bodies.place.data(), bodies.wrenches.empty() ? nullptr : bodies.wrenches.data(),
                   features_.wrenches().empty() ? nullptr : features_.wrenches().data(), 0, count, rules.move);
        rule_ = rules.solve;
        {
            const StageClock clock(world_.times.solve);
            const int sweeps = world_.settings.solver.sweeps * world_.settings.solver.inner_sweeps;
            for (int sweep = 0; sweep < sweeps; ++sweep)
                workers.run((contacts_.size() + kPerJob - 1) / kPerJob, [&](int, std::size_t job) {
                    for (std::size_t i = job * kPerJob; i < std::min(contacts_.size(), (job + 1) * kPerJob); ++i) solve(contacts_[i]);
                });
        }
        const StageClock clock(world_.times.move);
        move_bodies(bodies, 0, count, rules.move.step_s);
        return world_.check_speeds();
    }

    float friction(std::uint8_t one, std::uint8_t other) const { return common_friction(world_.materials[one], world_.materials[other]); }

    void add_contact(std::uint32_t a, std::uint32_t b, std::uint32_t obstacle, Vec3 normal, double gap, std::uint8_t other_material) {
        Bodies& bodies = world_.bodies;
        const std::uint8_t material = bodies.properties[a].material;
        FlatContact contact{a,
                            b,
                            obstacle,
                            {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)},
                            static_cast<float>(gap),
                            friction(material, other_material),
                            0,
                            0,
                            {}};
        const float restitution = std::max(world_.materials[material].restitution, world_.materials[other_material].restitution);
        const float parting = parting_speed(contact);
        if (restitution > 0 && parting < -min_bounce_speed_) contact.bounce_speed = -restitution * parting;
        contacts_.push_back(contact);
    }

    Result<void> collide(Workers& workers) {
        Bodies& bodies = world_.bodies;
        contacts_.clear();
        candidates_ = 0;
        for (const auto& list : broadphase_->pairs) {
            candidates_ += list.size();
            for (const BodyPair pair : list) {
                const Place &a = bodies.place[pair.first], &b = bodies.place[pair.second];
                const Vec3 apart{b.x - a.x, b.y - a.y, b.z - a.z};
                const double distance = length(apart), radii = a.radius + b.radius;
                if (radii - distance > world_.settings.max_overlap_share * radii)
                    return world_.too_deep(bodies.properties[pair.first].id, bodies.properties[pair.second].id, radii - distance);
                add_contact(pair.first, pair.second, 0, distance > 0 ? (1 / distance) * apart : Vec3{0, 0, 1}, distance - radii,
                            bodies.properties[pair.second].material);
            }
        }
        std::array<SurfaceContact, kMaxSurfaceContacts> found;
        for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) {
            const Place& p = bodies.place[slot];
            for (std::uint32_t obstacle = 0; obstacle < world_.obstacles.count(); ++obstacle) {
                if ((bodies.properties[slot].flags & kFixed) || !world_.obstacles.may_reach(obstacle, {p.x, p.y, p.z}, p.radius, 0))
                    continue;
                const int count = world_.obstacles.collide(0, obstacle, {p.x, p.y, p.z}, p.radius, 0, found);
                for (int i = 0; i < count; ++i) {
                    const SurfaceContact& contact = found[static_cast<std::size_t>(i)];
                    if (auto fine = world_.check_depth(bodies.properties[slot].id, p.radius, obstacle, -contact.gap_m); !fine)
                        return world_.wrong(fine.error().problem, fine.error().suggestion);
                    add_contact(slot, kNobody, obstacle, -contact.normal, contact.gap_m, world_.obstacles.material(obstacle));
                }
            }
        }
        static_cast<void>(workers);
        return {};
    }

    float parting_speed(const FlatContact& c) {
        BodyVelocity& a = world_.bodies.velocity[c.a];
        float speed = 0;
        for (int i = 0; i < 3; ++i)
            speed += c.normal[i] * ((c.b == kNobody ? 0.0f : read(world_.bodies.velocity[c.b].linear[i])) - read(a.linear[i]));
        return speed;
    }

    float wanted(const FlatContact& c) {
        const float mass =
            1 / (world_.bodies.velocity[c.a].inverse_mass + (c.b == kNobody ? 0.0f : world_.bodies.velocity[c.b].inverse_mass));
        const float bias = std::min(std::max(c.gap * rule_.overlap_rate, -rule_.max_depenetration_speed), -c.bounce_speed);
        return std::max(c.impulse - rule_.over_relaxation * mass * (parting_speed(c) + bias), 0.0f);
    }

    void solve(FlatContact& c) {
        BodyVelocity still{};
        BodyVelocity &a = world_.bodies.velocity[c.a], &b = c.b == kNobody ? still : world_.bodies.velocity[c.b];
        MELD_ASSERT(c.a < world_.bodies.count() && (c.b == kNobody || c.b < world_.bodies.count()), "slots {} and {}", c.a, c.b);
        if (a.inverse_mass + b.inverse_mass == 0) return;
        const float now = std::exchange(c.impulse, wanted(c)), change = c.impulse - now;
        float rel[3], surface[3], along = 0;
        for (int i = 0; i < 3; ++i)
            rel[i] = read(b.linear[i]) - read(a.linear[i]), surface[i] = read(b.surface[i]) + read(a.surface[i]),
            along += rel[i] * c.normal[i];
        const float* n = c.normal;
        const float twist[3] = {surface[1] * n[2] - surface[2] * n[1], surface[2] * n[0] - surface[0] * n[2],
                                surface[0] * n[1] - surface[1] * n[0]};
        const float mass = 1 / (a.inverse_mass + b.inverse_mass + a.inverse_surface_mass + b.inverse_surface_mass),
                    limit = c.friction * c.impulse;
        float tangent[3], squared = 0;
        for (int i = 0; i < 3; ++i)
            tangent[i] = c.tangent[i] - rule_.over_relaxation * mass * (rel[i] - twist[i] - along * n[i]),
            squared += tangent[i] * tangent[i];
        const float scale = squared > limit * limit ? limit / std::sqrt(squared) : 1;
        float impulse[3], across[3];
        for (int i = 0; i < 3; ++i)
            across[i] = scale * tangent[i] - c.tangent[i], c.tangent[i] = scale * tangent[i], impulse[i] = change * n[i] + across[i];
        const float turn[3] = {n[1] * across[2] - n[2] * across[1], n[2] * across[0] - n[0] * across[2],
                               n[0] * across[1] - n[1] * across[0]};
        for (int i = 0; i < 3; ++i) {
            add(a.linear[i], -a.inverse_mass * impulse[i]), add(b.linear[i], b.inverse_mass * impulse[i]);
            add(a.surface[i], -a.inverse_surface_mass * turn[i]), add(b.surface[i], -b.inverse_surface_mass * turn[i]);
        }
    }

    void report_events(const StepTimes& times) {
        const StageClock clock(world_.times.events);
        const double per_second = 1 / times.substep_s();
        std::vector<ContactReport> reports;
        for (const FlatContact& c : contacts_) {
            const BodyId a = world_.bodies.properties[c.a].id;
            const Touch touch = c.b == kNobody ? Touch{a, c.obstacle, true} : touch_of(a, world_.bodies.properties[c.b].id);
            const double sign = touch.body == a ? 1 : -1;
            const auto vector = [sign](const float(&v)[3]) {
                return sign * Vec3{static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
            };
            reports.push_back({touch, vector(c.normal), static_cast<double>(c.gap), per_second * static_cast<double>(c.impulse),
                               per_second * vector(c.tangent)});
        }
        features_.discount(reports);
        log_.update(world_, std::move(reports));
    }

    World& world_;
    std::unique_ptr<Broadphase> broadphase_ = make_hash_broadphase();
    std::vector<FlatContact> contacts_;
    PairwiseFeatures features_;
    ContactLog log_;
    SweepRule rule_{};
    float min_bounce_speed_ = 0;
    std::size_t candidates_ = 0;
    bool removed_ = false;
};

}  // namespace

std::unique_ptr<Engine> make_hash_engine(World& world) { return std::make_unique<HashEngine>(world); }

}  // namespace meld::physics
