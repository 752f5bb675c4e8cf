// Takes the impulses out of the batches and sorts them for the new ones.
#include "physics/solver/warm_start_cache.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "physics/solver/contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

WarmStartCache::WarmStartCache(std::vector<Chunks<CachedContact>>& lists, const BlockGrid& grid, const Bodies& bodies,
                               std::size_t blocks_per_job, Workers& workers)
    : blocks_(grid.blocks()), blocks_per_job_(blocks_per_job), done_((blocks_.size() + blocks_per_job - 1) / blocks_per_job) {
    std::size_t total = 0;
    for (const auto& list : lists) total += list.size();
    if (total == 0) return;
    end_.assign(bodies.count(), 0);
    const auto advance = [&](std::uint32_t id) { return std::atomic_ref(end_[bodies.slot(id)]).fetch_add(1, std::memory_order_relaxed); };
    workers.run(lists.size(), [&](int, std::size_t list) {
        lists[list].each([&](const CachedContact& contact) {
            if (bodies.has(contact.id())) advance(contact.id());
        });
    });
    std::uint32_t first = 0;
    for (std::uint32_t& end : end_) first += std::exchange(end, first);
    contacts_.resize(first);
    // end_[slot] starts at the slot's first entry, and is behind its last one when all are in.
    workers.run(lists.size(), [&](int, std::size_t list) {
        lists[list].consume([&](const CachedContact& contact) {
            if (bodies.has(contact.id())) contacts_[advance(contact.id())] = contact;
        });
    });
    lists.clear();
    MELD_ENSURE(end_.empty() || end_.back() == contacts_.size(), "{} of {} contacts", end_.back(), contacts_.size());
}

void WarmStartCache::done(std::size_t job) {
    if (contacts_.empty()) return;
    MELD_EXPECT(job < done_.size(), "job {} of {}", job, done_.size());
    const std::lock_guard lock(mutex_);
    MELD_ASSERT(!done_[job], "job {} is done twice", job);
    done_[job] = true;
    while (next_job_ < done_.size() && done_[next_job_]) ++next_job_;
    const std::size_t laid_out = std::min(blocks_.size(), next_job_ * blocks_per_job_);
    // A block is finished when the last of the blocks around it is.
    const auto wanted = [&](const Block& block) {
        return std::any_of(block.neighbours.begin(), block.neighbours.end(),
                           [&](std::uint32_t n) { return n != kNoBlock && n >= laid_out; });
    };
    while (next_block_ < blocks_.size() && !wanted(blocks_[next_block_])) ++next_block_;
    const std::uint32_t slot = next_block_ < blocks_.size() ? blocks_[next_block_].first : static_cast<std::uint32_t>(end_.size());
    gone_bytes_ = give_back_front(contacts_, gone_bytes_, slot == 0 ? 0 : end_[slot - 1]);
}

std::vector<CachedContact> Contacts::take_out(const Bodies& bodies, const Composites& composites, Workers& workers) {
    std::vector<std::vector<CachedContact>> ended(static_cast<std::size_t>(workers.threads()));
    cached_.clear();
    cached_.resize(static_cast<std::size_t>(workers.threads()));
    const auto removed = [&](std::uint32_t slot) { return (bodies.properties[slot].flags & kRemoved) != 0; };
    const bool composed = !composites.empty() || !composites.joined().empty();
    const auto indifferent = [&](const Batch& batch, int i, bool is_pair) {
        const BodyProperties& a = bodies.properties[batch.a[i]];
        return is_pair ? composites.indifferent(a, bodies.properties[batch.b[i]]) : composites.immovable(a);
    };
    const auto take = [](auto& list, const Batch& batch, int i, std::uint32_t partner, std::uint32_t id, float sign, bool touches) {
        if (batch.normal_impulse[i] == 0 && batch.tx[i] == 0 && batch.ty[i] == 0 && batch.tz[i] == 0 && !touches) return;
        MELD_ASSERT(id < kMaxBodies && batch.normal_impulse[i] == batch.normal_impulse[i], "body {}", id);
        list.push_back({id << 1 | (touches ? 1u : 0u),
                        partner,
                        batch.normal_impulse[i],
                        {sign * batch.tx[i], sign * batch.ty[i], sign * batch.tz[i]}});
    };
    workers.run(pairs_.chunks.size() + obstacles_.chunks.size(), [&](int worker, std::size_t n) {
        const bool is_pair = n < pairs_.chunks.size();
        Chunk& chunk = is_pair ? pairs_.chunks[n] : obstacles_.chunks[n - pairs_.chunks.size()];
        for (std::size_t at = 0; at < chunk.batches.size(); ++at) {
            const Batch& batch = chunk.batches[at];
            for (int i = 0; i < kLanes; ++i) {
                if (batch.a[i] >= bodies.count()) continue;
                const bool touches = (chunk.touching[at] >> i & 1) != 0;
                const std::uint32_t a = bodies.properties[batch.a[i]].id;
                const bool ends = removed(batch.a[i]) || (is_pair && removed(batch.b[i])) || (composed && indifferent(batch, i, is_pair));
                if (ends && !touches) continue;
                const auto note = [&](std::uint32_t partner, std::uint32_t id, float sign) {
                    if (ends)
                        take(ended[static_cast<std::size_t>(worker)], batch, i, partner, id, sign, touches);
                    else
                        take(cached_[static_cast<std::size_t>(worker)], batch, i, partner, id, sign, touches);
                };
                if (!is_pair) {
                    note(obstacle_code(chunk.lanes[at * kLanes + static_cast<std::size_t>(i)]), a, 1);
                    continue;
                }
                const std::uint32_t b = bodies.properties[batch.b[i]].id;
                note(std::max(a, b), std::min(a, b), a < b ? 1.0f : -1.0f);
            }
        }
        // Frees the chunk: its memory makes room for the list that its contacts moved to.
        chunk = Chunk();
    });
    pairs_ = Layout(), obstacles_ = Layout();
    release_memory(adhesion), release_memory(bounces_);
    candidates_ = 0;
    for (std::size_t worker = 1; worker < ended.size(); ++worker)
        ended[0].insert(ended[0].end(), ended[worker].begin(), ended[worker].end());
    return std::move(ended[0]);
}

std::vector<CachedContact> Contacts::cached_of(const std::vector<bool>& ids_wanted) const {
    std::vector<CachedContact> found;
    const auto wanted = [&](std::uint32_t id) { return id < ids_wanted.size() && ids_wanted[id]; };
    for (const auto& list : cached_)
        list.each([&](const CachedContact& contact) {
            if (wanted(contact.id()) || wanted(contact.partner)) found.push_back(contact);
        });
    return found;
}

void Contacts::add_cached(std::vector<CachedContact> contacts) {
    cached_.emplace_back();
    for (const CachedContact& contact : contacts) cached_.back().push_back(contact);
}

}  // namespace meld::physics
