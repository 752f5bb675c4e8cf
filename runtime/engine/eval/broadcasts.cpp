#include "runtime/engine/eval/broadcasts.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/engine/eval/agenda.h"

namespace meld::eval {

Broadcasts::Broadcasts(const ModuleInfo& module) : module_(module), columns_(module.broadcast_count) {
    if (columns_.empty()) return;
    views_.resize(module.column_count);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        columns_[i].number = module.broadcasts[i];
        columns_[i].entry_bytes = broadcast_bytes(module.columns[module.broadcasts[i]].row_bytes);
    }
}

const Broadcasts::Column& Broadcasts::of(u16 column) const {
    const auto found = std::ranges::find(columns_, column, &Column::number);
    MELD_EXPECT(found != columns_.end(), "column {} is not told to all neighbours", column);
    return *found;
}

void Broadcasts::begin(SubdomainView& subdomain, bool leave, std::size_t catoms) {
    if (columns_.empty()) return;
    const std::size_t next = 1 - last_;
    subdomain.broadcasts = views_.data();
    subdomain.broadcast_round = ++round_;
    for (Column& c : columns_) {
        Broadcast& view = views_[c.number];
        MELD_EXPECT(!waiting_ || c.catoms[last_] == catoms, "{} catoms after {}, which have not read yet", catoms, c.catoms[last_]);
        view = {};
        if (waiting_) view.heard = c.entries[last_].data() + c.entry_bytes;
        if (!leave) continue;
        const std::size_t bytes = (catoms + 1) * c.entry_bytes;
        if (c.entries[next].size() != bytes) c.entries[next].assign(bytes, 0);
        const std::size_t wakes = kFront + (catoms + Agenda::kGroup - 1) / Agenda::kGroup * Agenda::kGroup;
        if (c.woken.size() != wakes) c.woken.assign(wakes, 0);
        c.catoms[next] = catoms;
        view.said = c.entries[next].data() + c.entry_bytes;
        view.woken = c.woken.data() + kFront;
    }
    last_ = next;
    waiting_ = leave;
}

void Broadcasts::end(Agenda& agenda) {
    if (!waiting_) return;
    bool any = false;
    for (Column& c : columns_) {
        const u64 bits = module_.columns[c.number].own_dirty;
        const std::size_t groups = (c.woken.size() - kFront) / Agenda::kGroup;
        for (std::size_t group = 0; group < groups; ++group) {
            u8* const woken = c.woken.data() + kFront + group * Agenda::kGroup;
            u64 catoms = 0;
            for (std::size_t word = 0; word < Agenda::kGroup / 8; ++word) {
                u64 eight;
                std::memcpy(&eight, woken + 8 * word, sizeof eight);
                // Each byte is 0 or 1: the product gathers them in the highest byte, the first as its lowest bit.
                catoms |= (eight * u64{0x0102040810204080} >> 56) << (8 * word);
            }
            if (catoms == 0) continue;
            std::memset(woken, 0, Agenda::kGroup);
            agenda.mark_group(static_cast<u32>(group), catoms, bits);
            any = true;
        }
    }
    waiting_ = any;
}

std::size_t Broadcasts::bytes() const {
    std::size_t total = 0;
    for (const Column& c : columns_) total += c.entries[0].capacity() + c.entries[1].capacity() + c.woken.capacity();
    return total;
}

}  // namespace meld::eval
