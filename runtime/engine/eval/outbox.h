// The linear facts that the catoms of one thread send in a tick, as rows: compiled modules write them here. Lists of rows are copied to an
// arena of their column, and go with it to the receivers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <vector>

#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

class Outbox {
  public:
    explicit Outbox(const ModuleInfo& module) : columns_(module.column_count), places_(module.column_count) {
        for (u32 c = 0; c < module.column_count; ++c) columns_[c].row_bytes = sent_bytes(module.columns[c].row_bytes);
    }

    // As Eval::outgoing.
    Outgoing* places() { return places_.data(); }
    // Adds an entry with one receiver; returns where its row is to be written.
    u8* add(u16 column, u32 to, u32 from) {
        const std::size_t row_bytes = columns_[column].row_bytes;
        Outgoing& place = places_[column];
        if (static_cast<std::size_t>(place.end - place.next) < row_bytes + sizeof to) take_chunk(column);
        u8* const at = place.next;
        *reinterpret_cast<SentRow*>(at) = {from, 1};
        std::memcpy(at + row_bytes, &to, sizeof to);
        place.next += row_bytes + sizeof to;
        ++place.sent;
        return at + sizeof(SentRow);
    }

    tuple::Arena& lists(u16 column) { return columns_[column].lists; }
    // Whether a row of the column points to a stored list.
    bool shares(u16 column) const { return columns_[column].shares; }
    void share(u16 column) { columns_[column].shares = true; }

    // Calls visit(const u32* to, receivers, from, const u8* row) for each entry of a column, in the order of sending.
    template <class Visit>
    void each_entry(u16 column, const Visit& visit) const {
        const Column& c = columns_[column];
        for (std::size_t i = 0; i < c.used; ++i) {
            const u8* const end = i + 1 == c.used ? places_[column].next : c.chunks[i].bytes.get() + c.chunks[i].filled;
            for (const u8* at = c.chunks[i].bytes.get(); at != end;) {
                const auto [from, receivers] = *reinterpret_cast<const SentRow*>(at);
                const auto* const to = reinterpret_cast<const u32*>(at + c.row_bytes);
                visit(to, receivers, from, at + sizeof(SentRow));
                at = reinterpret_cast<const u8*>(to + receivers);
            }
        }
    }
    // Calls visit(to, from, const u8* row) for each row.
    template <class Visit>
    void each(u16 column, const Visit& visit) const {
        each_entry(column, [&](const u32* to, u32 receivers, u32 from, const u8* row) {
            for (u32 k = 0; k < receivers; ++k) visit(to[k], from, row);
        });
    }
    // Rows, one for each receiver.
    std::size_t count(u16 column) const { return places_[column].sent; }
    std::size_t count() const {
        std::size_t all = 0;
        for (std::size_t c = 0; c < columns_.size(); ++c) all += count(static_cast<u16>(c));
        return all;
    }

    // Facts that are in Broadcast::said.
    std::size_t said() const {
        std::size_t all = 0;
        for (const Outgoing& place : places_) all += place.said;
        return all;
    }

    // The chunks stay, so that a steady tick allocates nothing.
    void clear() {
        for (std::size_t c = 0; c < columns_.size(); ++c) {
            columns_[c].used = 0;
            columns_[c].lists.clear();
            columns_[c].shares = false;
            places_[c] = {};
        }
    }

  private:
    struct Chunk {
        std::unique_ptr<u8[]> bytes;
        std::size_t size = 0, filled = 0;
    };
    struct Column {
        std::size_t row_bytes = 0;  // With what is before the row.
        std::vector<Chunk> chunks;
        std::size_t used = 0;  // Chunks; the last of them is being filled.
        tuple::Arena lists;
        bool shares = false;
    };
    static constexpr std::size_t kFirstChunk = 1 << 10, kLargestChunk = 1 << 16;

    void take_chunk(u16 column) {
        Column& c = columns_[column];
        Outgoing& place = places_[column];
        if (c.used > 0) {
            Chunk& full = c.chunks[c.used - 1];
            full.filled = static_cast<std::size_t>(place.next - full.bytes.get());
        }
        if (c.used == c.chunks.size()) {
            const std::size_t size = c.used == 0 ? kFirstChunk : std::min(kLargestChunk, 2 * c.chunks.back().size);
            c.chunks.push_back({.bytes = nullptr, .size = std::max(size, c.row_bytes + sizeof(u32))});
            c.chunks.back().bytes = std::make_unique_for_overwrite<u8[]>(c.chunks.back().size);
        }
        const Chunk& fresh = c.chunks[c.used++];
        place.next = fresh.bytes.get();
        place.end = place.next + fresh.size;
    }

    std::vector<Column> columns_;
    std::vector<Outgoing> places_;
};

}  // namespace meld::eval
