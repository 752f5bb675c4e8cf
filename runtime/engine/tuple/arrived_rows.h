// Rows of linear facts that arrive for many catoms of one column at once. They are scattered into one block, by receiver, each receiver's
// in order, and stay there: the receivers' heads refer to them until their evaluation consumes them or writes the rest elsewhere.
//
// A delivery is opened for a column, counts every row, makes room, places every row, and ends. Its cost is proportional to the rows that
// arrive and to those that their receivers hold already, not to the number of catoms.
#pragma once

#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "runtime/base/process/parallel_for.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

class Columns;

class ArrivedRows {
  public:
    ArrivedRows(const ModuleInfo& module, Columns& columns) : module_(module), columns_(columns), blocks_(module.column_count) {}

    // ---- one delivery, in this order
    // shares: some rows point to stored lists.
    void open(u16 column, bool shares);
    // A function to call for all rows in turn: counts one for each of these catoms that is `here`. It is a value of its own, so that a loop
    // over many rows has all of it in registers.
    template <class Here>
    auto counter(Here here) {
        return [counts = counts_.data(), &receivers = receivers_, here](const u32* catoms, u32 count) {
            for (u32 k = 0; k < count; ++k)
                if (here(catoms[k]) && counts[catoms[k]]++ == 0) receivers.push_back(catoms[k]);
        };
    }
    void make_room();
    // The same for the copies: one for each catom that is `here`; lists of the row are in lists(), or stored and the caller's. Bytes: of a
    // row, or 0. The function returns where the last copy is.
    template <u32 Bytes, class Here>
    auto placer(Here here) {
        return [rows = filling_.bytes.get(), next = counts_.data(), bytes = row_bytes_, here](const u32* catoms, u32 count, const u8* row) {
            const std::size_t size = Bytes == 0 ? bytes : Bytes;
            u8* at = nullptr;
            for (u32 k = 0; k < count; ++k)
                if (here(catoms[k])) std::memcpy(at = rows + next[catoms[k]]++ * size, row, size);
            return at;
        };
    }
    // Where lists of these rows are; what is there when a delivery is opened may be used again.
    std::vector<Arena>& lists() { return filling_.lists; }
    // Puts the rows of each receiver in order, with those that it holds, and leaves them to it.
    void end(Workers& workers);
    // Of the last delivery.
    const std::vector<u32>& receivers() const { return blocks_[column_].receivers; }
    // In a tick without deliveries. When it is the second in turn, what is left of earlier ones moves, and their memory is freed.
    void rest();
    // Whether rows of the last delivery of the column may point to stored lists.
    bool owns_lists(u16 column) const { return blocks_[column].owns_lists; }

    std::size_t bytes() const;

  private:
    struct Block {
        std::unique_ptr<u8[]> bytes;
        std::size_t size = 0;
        std::vector<u32> receivers;
        std::vector<Arena> lists;
        bool owns_lists = false;
    };
    struct Prefixed {
        u64 prefix;
        const u8* row;
    };
    struct Worker {
        // Memory to sort the rows of a receiver.
        std::vector<u8> unsorted;
        std::vector<Prefixed> order;
        bool owns_lists = false;  // Of rows that a receiver held.
    };
    RowsHead* heads(u16 column) const;
    void leave(std::size_t receiver, int pool);
    void sort_many(u8* rows, u32 count, Worker& room) const;
    void move_what_is_left(u16 column);

    const ModuleInfo& module_;
    Columns& columns_;
    std::vector<Block> blocks_;  // By column: the last delivery.
    Block filling_;              // This one; in between, a block that is free.
    u16 column_ = 0;
    u32 row_bytes_ = 0;
    std::vector<u32> counts_;     // By catom: the rows that come, then where the next one goes; 0 between deliveries.
    std::vector<u32> receivers_;  // In the order of their first rows.
    std::vector<u32> starts_;     // Of their rows in the block; one more than there are receivers.
    std::vector<Worker> workers_;
    int quiet_ticks_ = 0;
};

}  // namespace meld::tuple
