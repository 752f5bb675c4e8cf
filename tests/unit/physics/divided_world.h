// A world divided among parts, with the messages carried by hand.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "physics/scene/subdomain.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {

inline Settings settings_for_parts() {
    Settings settings;
    settings.min_radius_m = 0.3, settings.max_radius_m = 0.5;
    settings.sleep_ticks = 10;
    return settings;
}

inline Settings settings_for_shapes() {
    Settings settings = settings_for_parts();
    settings.max_radius_m = 0.9, settings.least_radius_m = 0.2;
    return settings;
}

// Makes the bodies of a part, of those for which the function says so.
using Furnish = void (&)(Scene&, const std::function<bool(BodyId)>&);

class Divided {
  public:
    Divided(int parts, Subdomain::OwnerOf owner, Furnish furnish_it, const Settings& settings = settings_for_parts()) {
        for (int self = 0; self < parts; ++self) {
            scenes_.push_back(make_scene(settings));
            scenes_.back()->share();
            // Bodies begin anywhere; the first rebuild brings them to their owners.
            furnish_it(*scenes_.back(), [&](BodyId id) { return static_cast<int>(id) % parts == self; });
            subdomains_.push_back(std::make_unique<Subdomain>(*scenes_.back(), owner, self, parts));
        }
    }

    bool must_rebuild() const {
        return std::any_of(subdomains_.begin(), subdomains_.end(), [](const auto& part) { return part->must_rebuild(kTick, 2); });
    }
    void tick() {
        bool recomposes = false;
        for (const auto& part : subdomains_) recomposes = part->recomposes() || recomposes;
        if (recomposes) {
            Subdomain::OfParts held;
            for (const auto& part : subdomains_) held.push_back(part->members_held().take());
            std::vector<Subdomain::Messages> sent;
            for (const auto& part : subdomains_) sent.push_back(part->pack_members(held));
            for (const auto& messages : sent)
                for (const auto& [to, bytes] : messages) need(subdomains_[static_cast<std::size_t>(to)]->unpack_members(bytes.view()));
            for (const auto& part : subdomains_) part->recompose(workers_);
        }
        if (recomposes || must_rebuild()) {
            Velocities velocities;
            for (const auto& part : subdomains_) velocities.add(part->velocities());
            for (const auto& part : subdomains_) part->set_velocities(velocities, kTick, 2);
            std::vector<Subdomain::Messages> sent;
            for (const auto& part : subdomains_) sent.push_back(part->pack_bodies(workers_));
            for (const auto& messages : sent)
                for (const auto& [to, bytes] : messages) need(subdomains_[static_cast<std::size_t>(to)]->unpack_bodies(bytes.view()));
            for (const auto& part : subdomains_) part->unpacked();
            ++rebuilds;
        }
        std::vector<Stage> stages;
        for (const auto& part : subdomains_) stages = part->stages(kTick, 2);
        for (std::size_t i = 0; i < stages.size(); ++i) {
            Stage stage = stages[i];
            const int rounds = stage.has_rounds() ? subdomains_[0]->rounds() : 1;
            most_rounds = std::max(most_rounds, stage.has_rounds() ? rounds : 0);
            for (stage.round = 0; stage.round < rounds; ++stage.round) run_and_exchange(stage);
            if (!stage.must_agree()) continue;
            std::uint8_t bouncing = 0;
            Subdomain::OfParts blocks;
            for (const auto& part : subdomains_) {
                bouncing |= part->bouncing_colours();
                blocks.push_back(part->bouncing_blocks().take());
            }
            for (const auto& part : subdomains_) part->agree_on_bounces(blocks);
            i += static_cast<std::size_t>(stage.left_out(bouncing));
        }
        for (const auto& part : subdomains_) part->finish();
    }
    // Does something to all parts.
    void change(const std::function<void(Scene&)>& what) {
        for (const auto& scene : scenes_) what(*scene);
    }
    // What breaks; the loads that parts have are then as of now.
    std::vector<ConnectionPair> break_connections() {
        std::vector<ConnectionPair> all;
        for (const auto& scene : scenes_) {
            const auto broken = need(scene->solve_loads(workers_));
            all.insert(all.end(), broken.begin(), broken.end());
        }
        std::ranges::sort(all);
        all.erase(std::unique(all.begin(), all.end()), all.end());
        change([&](Scene& scene) {
            for (const auto& [one, other] : all) need(scene.release(one, other));
        });
        return all;
    }
    // All that have a load have the same.
    std::map<ConnectionPair, ConnectionLoad> loads() const {
        std::map<ConnectionPair, ConnectionLoad> all;
        for (const auto& scene : scenes_)
            for (const auto& [pair, load] : scene->loads()) {
                const auto [at, is_new] = all.emplace(pair, load);
                EXPECT_TRUE(is_new || at->second == load) << pair.first << " " << pair.second;
            }
        return all;
    }

    Digest digest() const {
        Digest sum;
        for (const auto& scene : scenes_) sum.combine(scene->digest());
        return sum;
    }
    std::size_t bodies() const {
        std::size_t count = 0;
        for (const auto& scene : scenes_) count += scene->body_count();
        return count;
    }
    std::size_t joints() const {
        std::size_t count = 0;
        for (const auto& scene : scenes_) count += scene->joint_count();
        return count;
    }
    // On all parts that have the joint.
    void drive(BodyId one, BodyId other, const JointDrive& what) {
        for (const auto& scene : scenes_)
            if (scene->joined(one, other)) need(scene->drive_joint(one, other, what));
    }
    const Subdomain& part(std::size_t index) const { return *subdomains_[index]; }
    // By body, what presses on it as its owner knows when all have told what they know.
    std::map<BodyId, double> normal_forces() {
        std::vector<std::vector<ExactSum>> sums(subdomains_.size());
        for (std::size_t i = 0; i < subdomains_.size(); ++i) scenes_[i]->sum_normal_forces(sums[i], workers_);
        // What has been added is not sent on.
        std::vector<Subdomain::Messages> sent;
        for (std::size_t i = 0; i < subdomains_.size(); ++i) sent.push_back(subdomains_[i]->pack_sums(sums[i]));
        for (const auto& messages : sent)
            for (const auto& [to, bytes] : messages)
                subdomains_[static_cast<std::size_t>(to)]->unpack_sums(sums[static_cast<std::size_t>(to)], bytes.view());
        std::map<BodyId, double> found;
        for (std::size_t i = 0; i < subdomains_.size(); ++i)
            for (const BodyId body : scenes_[i]->bodies()) found[body] = sums[i][scenes_[i]->slot(body)].value();
        return found;
    }

    int rebuilds = 0, exchanges = 0, most_rounds = 0;
    std::size_t sent_bytes = 0;

  private:
    void run_and_exchange(const Stage& stage) {
        for (const auto& part : subdomains_) need(part->run(stage, workers_));
        exchanges += stage.must_exchange() ? 1 : 0;
        if (!stage.must_exchange()) return;
        std::vector<Subdomain::Messages> sent;
        for (const auto& part : subdomains_) sent.push_back(part->pack(stage));
        for (const auto& messages : sent)
            for (const auto& [to, bytes] : messages)
                subdomains_[static_cast<std::size_t>(to)]->unpack(stage, bytes.view()), sent_bytes += bytes.size();
    }

    std::vector<std::unique_ptr<Scene>> scenes_;
    std::vector<std::unique_ptr<Subdomain>> subdomains_;
    Workers workers_{1};
};

// A world whose parts own other blocks after each rebuild moves as an undivided one. `prepare` is called for each scene before the first
// tick, and `look` after each tick.
inline void expect_same_bits_divided_anew(Furnish furnish, const std::function<void(Scene&)>& prepare,
                                          const std::function<void(int, Divided&, Scene&, Workers&)>& look) {
    int shift = 0;
    auto scene = make_scene(settings_for_shapes());
    furnish(*scene, [](BodyId) { return true; });
    Workers workers(1);
    Divided divided(
        3, [&](BlockCoordinates c) { return (c.x + c.y + shift) & 3 ? (shift + (c.x > 0)) % 3 : 2; }, furnish, settings_for_shapes());
    prepare(*scene);
    divided.change(prepare);
    for (int tick = 0; tick < 150; ++tick) {
        if (divided.must_rebuild()) ++shift;
        divided.tick();
        run(*scene, 1, 2, workers);
        ASSERT_EQ(divided.digest(), scene->digest()) << tick;
        look(tick, divided, *scene, workers);
    }
    EXPECT_GT(shift, 5);
}

}  // namespace meld::physics
