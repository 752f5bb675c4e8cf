// Comparing the contacts of two steps.
#include "physics/comparison/contact_log.h"

#include <algorithm>
#include <iterator>

#include "physics/solver/saved_bodies.h"

namespace meld::physics {

void ContactLog::update(World& world, std::vector<ContactReport> contacts) {
    contacts_ = std::move(contacts);
    std::vector<Touch> now;
    for (const ContactReport& contact : contacts_) now.push_back(contact.touch);
    std::sort(now.begin(), now.end());
    now.erase(std::unique(now.begin(), now.end()), now.end());
    const auto note = [&](const std::vector<Touch>& some, const std::vector<Touch>& others, bool began) {
        std::vector<Touch> difference;
        std::set_difference(some.begin(), some.end(), others.begin(), others.end(), std::back_inserter(difference));
        for (const Touch& touch : difference) world.events.push_back({touch, began});
    };
    note(now, touching_, true);
    note(touching_, now, false);
    std::sort(world.events.begin(), world.events.end());
    touching_ = std::move(now);
}

void ContactLog::add_normal_forces(const Bodies& bodies, std::span<ExactSum> of_slot) const {
    for (const ContactReport& contact : contacts_) {
        if (!(contact.normal_force_n > 0)) continue;
        of_slot[bodies.slot(contact.touch.body)].add(contact.normal_force_n);
        if (!contact.touch.other_is_obstacle) of_slot[bodies.slot(contact.touch.other)].add(contact.normal_force_n);
    }
}

void ContactLog::save(const Bodies& bodies, ByteWriter& out) const {
    const auto stays = [&](BodyId body) { return (bodies.properties[bodies.slot(body)].flags & kRemoved) == 0; };
    std::vector<Touch> kept;
    std::copy_if(touching_.begin(), touching_.end(), std::back_inserter(kept),
                 [&](const Touch& touch) { return stays(touch.body) && (touch.other_is_obstacle || stays(touch.other)); });
    out.write_count(kept.size());
    for (const Touch& touch : kept) out.write(touch);
}

Result<void> ContactLog::load(const World& world, ByteReader& in) {
    touching_.resize(in.read_count(sizeof(Touch)));
    for (Touch& touch : touching_) {
        touch = in.read<Touch>();
        const bool other = touch.other_is_obstacle ? touch.other < world.obstacles.count() : world.bodies.has(touch.other);
        if (!world.bodies.has(touch.body) || !other) return damaged_snapshot("has invalid contacts");
    }
    return {};
}

}  // namespace meld::physics
