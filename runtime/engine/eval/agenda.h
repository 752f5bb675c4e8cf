// Which catoms have new input, and what: for each dirty bit that is in use one bit per catom, in groups of 64 catoms. So a wave marks few
// bytes, an empty agenda costs nothing, and a full one is visited in the order of memory.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

class Agenda {
  public:
    static constexpr u32 kGroup = 64;               // Catoms.
    static constexpr u32 kBlock = kGroup * kGroup;  // Catoms whose groups share a word of the summary.

    void resize(std::size_t catoms) {
        MELD_EXPECT(catoms >= count_, "{} catoms after {}", catoms, count_);
        count_ = catoms;
        active_.resize((catoms + kGroup - 1) / kGroup, 0);
        summary_.resize((active_.size() + kGroup - 1) / kGroup, 0);
        for (u32 bit = 0; bit < kDirtyWordBits; ++bit)
            if (at_[bit] != nullptr) make_room(bit);
    }
    std::size_t bytes() const {
        std::size_t words = summary_.capacity();
        for (const auto& plane : planes_) words += plane.capacity();
        return words * sizeof(u64) + active_.capacity() * sizeof(u32);
    }
    // While this many dirty bits are in use.
    static std::size_t bytes_for(std::size_t catoms, std::size_t bits) { return catoms * bits / 8 + catoms / 16 + catoms / 512; }

    // Adds bits to a catom's dirty word. Not while other threads mark, unless catoms of other blocks.
    void mark(u32 catom, u64 bits) { mark_all({&catom, 1}, bits); }
    void mark_all(std::span<const u32> catoms, u64 bits) {
        for (u64 left = stored(bits); left != 0; left &= left - 1) {
            const u32 bit = static_cast<u32>(std::countr_zero(left));
            u64* const words = plane(bit);
            for (const u32 catom : catoms) {
                check(catom, bits);
                const u32 group = catom / kGroup;
                const u64 before = words[group];
                words[group] = before | u64{1} << (catom % kGroup);
                if (before != 0) continue;
                if (active_[group] == 0) summary_[group / 64] |= u64{1} << (group % 64);
                active_[group] |= u32{1} << bit;
            }
        }
    }
    // The same for the catoms of a group, one bit for each.
    void mark_group(u32 group, u64 catoms, u64 bits) {
        MELD_EXPECT(group < active_.size() && catoms != 0, "group {}", group);
        for (u64 left = stored(bits); left != 0; left &= left - 1) {
            const u32 bit = static_cast<u32>(std::countr_zero(left));
            plane(bit)[group] |= catoms;
            active_[group] |= u32{1} << bit;
        }
        summary_[group / 64] |= u64{1} << (group % 64);
    }
    // The same from several threads at once; the result does not depend on their order.
    void mark_shared(u32 catom, u64 bits) {
        check(catom, bits);
        const u32 group = catom / kGroup;
        for (u64 left = stored(bits); left != 0; left &= left - 1) {
            const u32 bit = static_cast<u32>(std::countr_zero(left));
            const std::atomic_ref<u64> word(plane(bit)[group]);
            const u64 mine = u64{1} << (catom % kGroup);
            if ((word.load(std::memory_order_relaxed) & mine) != 0) continue;
            if (word.fetch_or(mine, std::memory_order_relaxed) != 0) continue;
            if (std::atomic_ref<u32>(active_[group]).fetch_or(u32{1} << bit, std::memory_order_relaxed) != 0) continue;
            std::atomic_ref<u64>(summary_[group / 64]).fetch_or(u64{1} << (group % 64), std::memory_order_relaxed);
        }
    }
    u64 dirty(u32 catom) const { return dirty_among(catom, active_[catom / kGroup]); }
    // Forgets a catom that is removed, or is not here.
    void forget(u32 catom) {
        MELD_EXPECT(catom < count_, "catom {}", catom);
        for (u32 bits = active_[catom / kGroup]; bits != 0; bits &= bits - 1)
            plane(static_cast<u32>(std::countr_zero(bits)))[catom / kGroup] &= ~(u64{1} << (catom % kGroup));
    }
    bool empty() const {
        for (const u64 s : summary_)
            if (s != 0) return false;
        return true;
    }
    void clear() { clear(0, blocks()); }
    // The same for some blocks of groups, from several threads at once; of each block by one of them.
    std::size_t blocks() const { return summary_.size(); }
    void clear(std::size_t from, std::size_t to) {
        for (std::size_t s = from; s < to; ++s) {
            for (u64 groups = summary_[s]; groups != 0; groups &= groups - 1) {
                const std::size_t group = s * 64 + static_cast<std::size_t>(std::countr_zero(groups));
                for (u32 bits = active_[group]; bits != 0; bits &= bits - 1) plane(static_cast<u32>(std::countr_zero(bits)))[group] = 0;
                active_[group] = 0;
            }
            summary_[s] = 0;
        }
    }
    // The groups of these blocks in which a catom has been marked: how many there are, and which.
    std::size_t group_count(std::size_t from, std::size_t to) const {
        std::size_t count = 0;
        for (std::size_t s = from; s < to; ++s) count += static_cast<std::size_t>(std::popcount(summary_[s]));
        return count;
    }
    void copy_groups(std::size_t from, std::size_t to, u32* out) const {
        for (std::size_t s = from; s < to; ++s)
            for (u64 groups = summary_[s]; groups != 0; groups &= groups - 1)
                *out++ = static_cast<u32>(s * 64 + static_cast<std::size_t>(std::countr_zero(groups)));
    }

    // Calls visit(group) for each group in which a catom has been marked; it may have been forgotten since.
    template <class Visit>
    void each_group(const Visit& visit) const {
        for (std::size_t s = 0; s < summary_.size(); ++s)
            for (u64 groups = summary_[s]; groups != 0; groups &= groups - 1)
                visit(static_cast<u32>(s * 64 + static_cast<std::size_t>(std::countr_zero(groups))));
    }
    // Calls visit(catom, dirty) for each catom of a group that has new input, ascending. It may forget or mark that catom.
    template <class Visit>
    void each_of(u32 group, const Visit& visit) const {
        const u32 active = active_[group];
        u64 catoms = 0;
        for (u32 bits = active; bits != 0; bits &= bits - 1) catoms |= word(static_cast<u32>(std::countr_zero(bits)), group);
        if (std::has_single_bit(active)) {
            for (; catoms != 0; catoms &= catoms - 1) visit(group * kGroup + static_cast<u32>(std::countr_zero(catoms)), meant(active));
            return;
        }
        std::array<u64, kGroup> dirty = {};
        for (u32 bits = active; bits != 0; bits &= bits - 1) {
            const u32 bit = static_cast<u32>(std::countr_zero(bits));
            for (u64 left = word(bit, group); left != 0; left &= left - 1)
                dirty[static_cast<std::size_t>(std::countr_zero(left))] |= u64{1} << bit;
        }
        for (; catoms != 0; catoms &= catoms - 1) {
            const u32 number = static_cast<u32>(std::countr_zero(catoms));
            visit(group * kGroup + number, meant(dirty[number]));
        }
    }
    // The same for all groups.
    template <class Visit>
    void each(const Visit& visit) const {
        each_group([&](u32 group) { each_of(group, visit); });
    }

  private:
    // A new catom has all bits of a birth, so one stands for them.
    static u64 stored(u64 bits) { return (bits & kDirtyBorn) != 0 ? (bits & ~u64{kDirtyBirths}) | kDirtyBorn : bits; }
    static u64 meant(u64 bits) { return (bits & kDirtyBorn) != 0 ? bits | kDirtyBirths : bits; }

    void check([[maybe_unused]] u32 catom, [[maybe_unused]] u64 bits) const {
        MELD_EXPECT(catom < count_ && bits != 0 && bits >> kDirtyWordBits == 0, "catom {}, bits {:x}", catom, bits);
        MELD_EXPECT((bits & kDirtyBorn) == 0 || (bits & kDirtyBirths) == kDirtyBirths, "catom {}, bits {:x}", catom, bits);
    }
    u64 dirty_among(u32 catom, u32 active) const {
        u64 bits = 0;
        for (u32 left = active; left != 0; left &= left - 1) {
            const u32 bit = static_cast<u32>(std::countr_zero(left));
            bits |= (word(bit, catom / kGroup) >> (catom % kGroup) & 1) << bit;
        }
        return meant(bits);
    }
    u64 word(u32 bit, u32 group) const { return at_[bit].load(std::memory_order_relaxed)[group]; }
    u64* plane(u32 bit) {
        u64* const known = at_[bit].load(std::memory_order_acquire);
        return known != nullptr ? known : first_use(bit);
    }
    [[gnu::noinline, gnu::cold]] u64* first_use(u32 bit) {
        const std::lock_guard lock(making_);
        if (at_[bit].load(std::memory_order_relaxed) == nullptr) make_room(bit);
        return at_[bit].load(std::memory_order_relaxed);
    }
    void make_room(u32 bit) {
        // The first size is exact: worlds are usually made at once. Never empty, so that it has an address.
        planes_[bit].resize(std::max<std::size_t>(1, active_.size()), 0);
        at_[bit].store(planes_[bit].data(), std::memory_order_release);
    }

    std::size_t count_ = 0;
    std::array<std::vector<u64>, kDirtyWordBits> planes_;    // By dirty bit and group: who has it.
    std::array<std::atomic<u64*>, kDirtyWordBits> at_ = {};  // Their words; null until the bit is used.
    std::mutex making_;
    std::vector<u32> active_;   // By group: the bits that some catom may have.
    std::vector<u64> summary_;  // One bit for each group with such bits.
};

}  // namespace meld::eval
