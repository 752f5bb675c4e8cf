#include "physics/statics/spring_net.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// A group has about as many bodies, and one of fewer than kFewInGroup joins another. Large groups are few, small ones bend as they should.
constexpr std::size_t kManyInGroup = 4, kFewInGroup = 3;
constexpr std::uint32_t kNoGroup = 0xffffffff;

}  // namespace

SpringNet::SpringNet(std::vector<Vec3> places, std::vector<Spring> springs) : places_(std::move(places)), springs_(std::move(springs)) {
    diagonal_.assign(count(), Matrix6::Zero());
    std::vector<std::vector<std::pair<std::uint32_t, const Spring*>>> of_body(count());
    for (const Spring& spring : springs_) {
        MELD_EXPECT(spring.one < count() && (spring.other < count() || spring.other == kGround), "{} to {}", spring.one, spring.other);
        of_body[spring.one].emplace_back(spring.other, &spring);
        if (spring.other != kGround) of_body[spring.other].emplace_back(spring.one, &spring);
    }
    first_.push_back(0);
    for (std::size_t body = 0; body < count(); ++body) {
        std::ranges::sort(of_body[body], {}, [](const auto& entry) { return entry.first; });
        for (const auto& [other, spring] : of_body[body]) {
            const Matrix6 here = displacement(spring->at - places_[body]), pulled = here.transpose() * spring->stiffness;
            diagonal_[body] += pulled * here;
            if (other == kGround) continue;
            neighbours_.push_back(other);
            blocks_.push_back(-(pulled * displacement(spring->at - places_[other])));
        }
        first_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
    }
    for (const Matrix6& block : diagonal_) inverse_diagonal_.push_back(block.llt().solve(Matrix6::Identity()));
}

void SpringNet::multiply(const Twists& x, Twists& product) const {
    product.resize(count());
    for (std::size_t body = 0; body < count(); ++body) {
        Vector6 sum = diagonal_[body] * x[body];
        for (std::uint32_t i = first_[body]; i < first_[body + 1]; ++i) sum.noalias() += blocks_[i] * x[neighbours_[i]];
        product[body] = sum;
    }
}

void SpringNet::sweep(const Twists& b, Twists& x, Order order) const {
    for (std::size_t n = 0; n < count(); ++n) {
        const std::size_t body = order == Order::Forward ? n : count() - 1 - n;
        Vector6 left = b[body];
        for (std::uint32_t i = first_[body]; i < first_[body + 1]; ++i) left.noalias() -= blocks_[i] * x[neighbours_[i]];
        x[body].noalias() = inverse_diagonal_[body] * left;
    }
}

std::vector<std::uint32_t> SpringNet::group() const {
    std::vector<std::uint32_t> group_of(count(), kNoGroup);
    std::vector<std::uint32_t> found;
    std::uint32_t groups = 0;
    for (std::uint32_t start = 0; start < count(); ++start) {
        if (group_of[start] != kNoGroup) continue;
        found.assign(1, start);
        group_of[start] = groups;
        for (std::size_t i = 0; i < found.size() && found.size() < kManyInGroup; ++i)
            for (const std::uint32_t next : neighbours(found[i])) {
                if (group_of[next] != kNoGroup || found.size() == kManyInGroup) continue;
                group_of[next] = groups;
                found.push_back(next);
            }
        std::uint32_t beside = kNoGroup;
        for (const std::uint32_t body : found)
            for (const std::uint32_t next : neighbours(body))
                if (group_of[next] != groups && group_of[next] != kNoGroup) beside = std::min(beside, group_of[next]);
        if (found.size() >= kFewInGroup || beside == kNoGroup)
            ++groups;
        else
            for (const std::uint32_t body : found) group_of[body] = beside;
    }
    return group_of;
}

SpringNet SpringNet::coarser(std::vector<std::uint32_t>& group_of) const {
    group_of = group();
    const std::size_t groups = count() == 0 ? 0 : *std::ranges::max_element(group_of) + std::size_t{1};
    std::vector<Vec3> centres(groups);
    std::vector<double> sizes(groups);
    for (std::size_t body = 0; body < count(); ++body) {
        centres[group_of[body]] = centres[group_of[body]] + places_[body];
        sizes[group_of[body]] += 1;
    }
    for (std::size_t g = 0; g < groups; ++g) centres[g] = (1 / sizes[g]) * centres[g];
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<const Spring*>> between;
    for (const Spring& spring : springs_) {
        const std::uint32_t one = group_of[spring.one], other = spring.other == kGround ? kGround : group_of[spring.other];
        if (one != other) between[std::minmax(one, other)].push_back(&spring);
    }
    std::vector<Spring> springs;
    for (const auto& [ends, all] : between) {
        Spring& sum = springs.emplace_back(Spring{.one = ends.first, .other = ends.second});
        for (const Spring* spring : all) sum.at = sum.at + spring->at;
        sum.at = (1 / static_cast<double>(all.size())) * sum.at;
        for (const Spring* spring : all) {
            const Matrix6 there = displacement(spring->at - sum.at);
            sum.stiffness += there.transpose() * spring->stiffness * there;
        }
    }
    return {std::move(centres), std::move(springs)};
}

void SpringNet::gather(std::span<const std::uint32_t> group_of, const SpringNet& groups, const Twists& on_bodies, Twists& on_groups) const {
    on_groups.assign(groups.count(), Vector6::Zero());
    for (std::size_t body = 0; body < count(); ++body)
        on_groups[group_of[body]] += acting_from(on_bodies[body], places_[body] - groups.places_[group_of[body]]);
}

void SpringNet::spread(std::span<const std::uint32_t> group_of, const SpringNet& groups, const Twists& of_groups, Twists& of_bodies) const {
    for (std::size_t body = 0; body < count(); ++body)
        of_bodies[body] += displaced(of_groups[group_of[body]], places_[body] - groups.places_[group_of[body]]);
}

std::size_t SpringNet::bytes() const {
    return places_.capacity() * sizeof(Vec3) + springs_.capacity() * sizeof(Spring) +
           (diagonal_.capacity() + inverse_diagonal_.capacity() + blocks_.capacity()) * sizeof(Matrix6) +
           (first_.capacity() + neighbours_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace meld::physics
