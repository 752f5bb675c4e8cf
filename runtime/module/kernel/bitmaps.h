// A set of rows of ints that lie close together: for all rows that are alike but for the last argument, a bitmap of the values of that
// argument. Whether a row is there is one bit, and of the rows that a rule derives one after another, most are in the same bitmap. Included
// by modules with sets that grow in rounds.
#pragma once

#include "runtime/module/kernel/values.h"

namespace meld {

// From so many bytes on, memory is reserved and given back if the host finds that better: in scratch memory, what has grown would be there
// twice. From so many rows on, a set is worth a look whether bitmaps serve it.
#ifdef MELD_CHECKED
constexpr u64 kReserved_bytes = 1 << 12;
constexpr u32 kRowsForBitmaps = 32;
#else
constexpr u64 kReserved_bytes = 1 << 14;
constexpr u32 kRowsForBitmaps = 4096;
#endif

// Memory that is given back; zeroed if it was reserved.
inline void* lent(Eval& e, u64 bytes, bool& zeroed) {
    void* const reserved = bytes < kReserved_bytes ? nullptr : e.host->reserve(&e, bytes, bytes);
    zeroed = reserved != nullptr;
    return zeroed ? reserved : scratch(e, bytes);
}
inline void* lent_zeroed(Eval& e, u64 bytes) {
    bool zeroed = false;
    void* const memory = lent(e, bytes, zeroed);
    if (!zeroed) __builtin_memset(memory, 0, bytes);
    return memory;
}
inline void give_back(Eval& e, void* memory, u64 bytes) {
    if (bytes >= kReserved_bytes) e.host->give_back(&e, memory);
}

// Of rows of T. Those that are not told apart by ints have none.
template <class T, bool = requires { T::kWords; }>
struct Bitmaps {
    using Row = typename T::Row;
    static constexpr bool used = false;
    void start() {}
    bool make(Eval&, const Row*, u32, u32) { return false; }
    bool has(const Row&) { return false; }
    bool add(Eval&, const Row&, u32) { return false; }
    void see(const Row&) {}
    bool sees(const Row&) { return false; }
    struct Values {
        bool next(Row&) { return false; }
    };
    void end_round(Eval&) {}
    void end(Eval&) {}
};

template <class T>
struct Bitmaps<T, true> {
    using Row = typename T::Row;
    bool used = false;

    void start() {
        used = false;
        stale_ = nullptr;
    }
    // Holds these rows from now on, of which rules see the first ones. False, and nothing is held: they lie so far apart that bitmaps would
    // take more than two words a row. Where bitmaps were too short before, they get room at both ends, so that it is done seldom.
    [[gnu::noinline]] bool make(Eval& e, const Row* rows, u32 count, u32 visible) {
        const bool again = used;
        end(e);
        u64 least = last_word(rows[0]), most = least;
        for (u32 i = 1; i < count; ++i) {
            const u64 word = last_word(rows[i]);
            if (word < least) least = word;
            if (word > most) most = word;
        }
        if ((most - least) / 64 >= count || !choose_span(e, rows, count, least, most, again)) return false;
        for (u32 i = 0; i < count; ++i) set(e, rows[i]);
        for (u32 i = 0; i < visible; ++i) see(rows[i]);
        return used = true;
    }
    // Whether a row has been derived.
    bool has(const Row& row) {
        const u64 at = last_word(row) - base_;
        if (at >= u64{words_} * 64) return false;
        if (!alike(row, there_of_) && !go_to(row)) return false;
        return (there_[at / 64] >> (at % 64) & 1) != 0;
    }
    // Adds one that has not been, the last of so many. False: it lies elsewhere, or now all lie too far apart.
    [[gnu::noinline]] bool add(Eval& e, const Row& row, u32 count) {
        if (last_word(row) - base_ >= u64{words_} * 64) return false;
        set(e, row);
        return u64{maps_} * words_ <= u64{count} * 2;
    }
    // From now on rules see a row that is there.
    void see(const Row& row) {
        const u64 at = last_word(row) - base_;
        seen(row)[at / 64] |= u64{1} << (at % 64);
    }
    bool sees(const Row& row) {
        const u64 at = last_word(row) - base_;
        if (at >= u64{words_} * 64) return false;
        const u64* const map = seen(row);
        return map != nullptr && (map[at / 64] >> (at % 64) & 1) != 0;
    }
    // Goes through rows that rules see by all arguments but the last, in the order of the last; it stays good until the round ends.
    struct Values {
        const u64* map = nullptr;
        u64 word = 0;
        u64 value = 0;  // Of the lowest bit of this word.
        u32 left = 0;   // Words after it.

        bool next(Row& row) {
            while (word == 0) {
                if (left == 0) return false;
                --left;
                word = *++map;
                value += 64;
            }
            T::set_last(row, value + static_cast<u32>(__builtin_ctzll(word)));
            word &= word - 1;
            return true;
        }
    };
    Values values(const Row& row) {
        const u64* const map = seen(row);
        if (map == nullptr) return {};
        return {map, *map, base_, words_ - 1};
    }
    void end_round(Eval& e) {
        for (; stale_ != nullptr; stale_ = stale_->next) give_back(e, stale_->bits, stale_->bytes);
    }
    // None is held any more.
    void end(Eval& e) {
        if (!used) return;
        give_back_later(e);
        give_back(e, heads_, heads_bytes());
        used = false;
    }

  private:
    static constexpr u32 kBefore = T::kWords - 1;  // Words before the last one.
    struct Head {
        u64 words[kBefore > 0 ? kBefore : 1];
        u32 map;  // + 1; 0: no such head.
    };
    // Bitmaps that something may still go through.
    struct Stale {
        u64* bits;
        u64 bytes;
        Stale* next;
    };
    Stale* stale_ = nullptr;
    u64 base_ = 0;   // The least value that has a bit.
    u32 words_ = 0;  // Of a bitmap.
    u32 maps_ = 0, room_ = 0;
    u64* bits_ = nullptr;    // Each map: which rows are there, then which of them are seen.
    Head* heads_ = nullptr;  // By hash.
    u32 mask_ = 0;
    Row there_of_, seen_of_;  // A row of the map that the last question was about,
    u64* there_ = nullptr;    // and this map.
    u64* seen_ = nullptr;

    static u64 last_word(const Row& row) { return T::word(row, kBefore); }
    static bool alike(const Row& a, const Row& b) {
        u64 differs = 0;
        for (u32 w = 0; w < kBefore; ++w) differs |= T::word(a, w) ^ T::word(b, w);
        return differs == 0;
    }
    template <class Word>
    static u32 hash_of(const Word& word) {
        u64 h = 0;
        for (u32 w = 0; w < kBefore; ++w) {
            h = (h ^ word(w)) * 0x9e3779b97f4a7c15ull;
            h ^= h >> 32;
        }
        return static_cast<u32>(h);
    }
    static u32 hash_of(const Row& row) {
        return hash_of([&](u32 w) { return T::word(row, w); });
    }
    static u32 hash_of(const Head& head) {
        return hash_of([&](u32 w) { return head.words[w]; });
    }
    u64 bits_bytes() const { return u64{room_} * words_ * 2 * sizeof(u64); }
    u64 heads_bytes() const { return (u64{mask_} + 1) * sizeof(Head); }
    // Where the head of a row is, or would be.
    u32 place(const Row& row) const {
        const auto is_of = [&](const Head& head) {
            u64 differs = 0;
            for (u32 w = 0; w < kBefore; ++w) differs |= head.words[w] ^ T::word(row, w);
            return differs == 0;
        };
        u32 at = hash_of(row) & mask_;
        while (heads_[at].map != 0 && !is_of(heads_[at])) at = (at + 1) & mask_;
        return at;
    }
    void give_back_later(Eval& e) {
        Stale* const stale = static_cast<Stale*>(scratch(e, sizeof(Stale)));
        *stale = {bits_, bits_bytes(), stale_};
        stale_ = stale;
    }
    u64* map(u32 number) const { return bits_ + u64{number - 1} * words_ * 2; }

    // Makes the bitmap of a row the one that the last question was about; false: there is none.
    bool go_to(const Row& row) {
        const u32 number = heads_[place(row)].map;
        if (number == 0) return false;
        there_of_ = row;
        there_ = map(number);
        return true;
    }
    u64* seen(const Row& row) {
        if (seen_ != nullptr && alike(row, seen_of_)) return seen_;
        const u32 number = heads_[place(row)].map;
        if (number == 0) return nullptr;
        seen_of_ = row;
        return seen_ = map(number) + words_;
    }
    void set(Eval& e, const Row& row) {
        if ((there_ == nullptr || !alike(row, there_of_)) && !go_to(row)) add_map(e, row);
        const u64 at = last_word(row) - base_;
        there_[at / 64] |= u64{1} << (at % 64);
    }
    // Empty bitmaps from the least to the most value. False: rows have too many heads.
    bool choose_span(Eval& e, const Row* rows, u32 count, u64 least, u64 most, bool more) {
        const u64 first = least / 64, needed = most / 64 - first + 1;
        words_ = 1;
        while (words_ < needed + (more ? needed / 2 : 0)) words_ *= 2;
        base_ = (first - (words_ - needed) / 2) * 64;
        maps_ = 0;
        room_ = 1;
        mask_ = 63;
        heads_ = static_cast<Head*>(lent_zeroed(e, heads_bytes()));
        there_ = seen_ = nullptr;
        bits_ = nullptr;
        for (u32 i = 0; i < count; ++i) {
            Head& head = heads_[place(rows[i])];
            if (head.map != 0) continue;
            if (u64{maps_ + 1} * words_ > count) {
                give_back(e, heads_, heads_bytes());
                return false;
            }
            add_head(e, head, rows[i]);
        }
        while (room_ < maps_) room_ *= 2;
        bits_ = static_cast<u64*>(lent_zeroed(e, bits_bytes()));
        return true;
    }
    void add_head(Eval& e, Head& head, const Row& row) {
        for (u32 w = 0; w < kBefore; ++w) head.words[w] = T::word(row, w);
        head.map = ++maps_;
        if (maps_ * 2 <= mask_) return;
        const Head* const old = heads_;
        const u64 old_bytes = heads_bytes();
        const u32 size = mask_ + 1;
        mask_ = size * 4 - 1;
        heads_ = static_cast<Head*>(lent_zeroed(e, heads_bytes()));
        for (u32 i = 0; i < size; ++i) {
            if (old[i].map == 0) continue;
            u32 at = hash_of(old[i]) & mask_;
            while (heads_[at].map != 0) at = (at + 1) & mask_;
            heads_[at] = old[i];
        }
        give_back(e, const_cast<Head*>(old), old_bytes);
    }
    void add_map(Eval& e, const Row& row) {
        if (maps_ == room_) {
            const u64* const old = bits_;
            const u64 old_bytes = bits_bytes();
            give_back_later(e);
            room_ *= 2;
            bits_ = static_cast<u64*>(lent_zeroed(e, bits_bytes()));
            __builtin_memcpy(bits_, old, old_bytes);
            seen_ = nullptr;
        }
        add_head(e, heads_[place(row)], row);
        there_of_ = row;
        there_ = map(maps_);
    }
};

}  // namespace meld
