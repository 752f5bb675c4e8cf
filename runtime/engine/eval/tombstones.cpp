#include "runtime/engine/eval/tombstones.h"

namespace meld::eval {

void Tombstones::lose(u32 catom, u16 predicate, u64 key, u32 rank, i64 now, u32 greatest_rank, u32 latency) {
    MELD_EXPECT(predicate != kNone16 && now > 0, "predicate {} in tick {}", predicate, now);
    for (u32 at = first_of(catom); at != kNone32; at = losses_[at].next) {
        Entry& e = losses_[at].entry;
        if (e.predicate != predicate || e.key != key) continue;
        e.least_rank = expired(e, now, greatest_rank, latency) ? rank : std::min(e.least_rank, rank);
        e.time = now;
        return;
    }
    add(catom, {predicate, rank, key, now});
}

void Tombstones::sweep(i64 now, u32 greatest_rank, u32 latency) {
    const auto gone = [&](const Loss& loss) { return loss.catom == kNone32 || expired(loss.entry, now, greatest_rank, latency); };
    if (!forgotten_ && std::ranges::none_of(losses_, gone)) return;
    std::erase_if(losses_, gone);
    forgotten_ = false;
    // What is left is found anew, and memory of a wave that has passed is given back.
    std::vector<Loss> left;
    left.swap(losses_);
    table_ = {};
    lines_ = {};
    catoms_ = 0;
    losses_.reserve(left.size());
    for (const Loss& loss : left) add(loss.catom, loss.entry);
}

void Tombstones::forget(u32 catom) {
    if (!has(catom)) return;
    u32& first = line_of(catom)[catom % kLine];
    for (u32 at = first; at != kNone32; at = losses_[at].next) losses_[at].catom = kNone32;
    first = kNone32;
    forgotten_ = true;
    --catoms_;
}

void Tombstones::restore(u32 catom, const std::vector<Entry>& entries) {
    MELD_EXPECT(!has(catom), "catom {} remembers losses already", catom);
    for (const Entry& entry : entries) add(catom, entry);
}

void Tombstones::add(u32 catom, const Entry& entry) {
    MELD_EXPECT(catom != kNone32, "a loss of no catom");
    const u32 added = static_cast<u32>(losses_.size());
    losses_.push_back({entry, catom, kNone32});
    u32& first = line_of(catom)[catom % kLine];
    if (first == kNone32) {
        first = added;
        ++catoms_;
        return;
    }
    u32 last = first;
    while (losses_[last].next != kNone32) last = losses_[last].next;
    losses_[last].next = added;
}

// A new one if there is none yet.
Tombstones::Line& Tombstones::line_of(u32 catom) {
    if (2 * (lines_.size() + 1) > table_.size()) {
        std::vector<Slot> before(std::max<std::size_t>(16, 2 * table_.size()));
        before.swap(table_);
        for (const Slot& slot : before)
            if (slot.catoms != kNone32) table_[slot_of(slot.catoms)] = slot;
    }
    Slot& slot = table_[slot_of(catom / kLine)];
    if (slot.catoms == kNone32) {
        slot = {catom / kLine, static_cast<u32>(lines_.size())};
        lines_.emplace_back().fill(kNone32);
    }
    return lines_[slot.line];
}

}  // namespace meld::eval
