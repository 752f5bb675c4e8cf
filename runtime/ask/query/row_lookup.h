// Looks up the rows of long tables by some of their fields, for a sieve that goes through the same table many times.
#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "runtime/ask/query/sieve_code.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

// The rows of one table in chains, by the hash of a key.
class RowLookup {
  public:
    // The table stays as it is while this is used.
    void build(const RowsHead& table, std::size_t row_bytes, std::span<const Instruction::Field> key);
    bool is_built() const { return !first_.empty(); }

    // Calls visit(number) for all rows with these values, and maybe for some others.
    template <class Visit>
    void each(std::span<const i64> key, const Visit& visit) const {
        for (u32 row = first_[hash(key) & (first_.size() - 1)]; row != kNone32; row = next_[row]) visit(row);
    }

  private:
    static u64 hash(std::span<const i64> key);
    std::vector<u32> first_, next_;
};

// Those of one instruction, by catom.
class RowLookups {
  public:
    // A table of at most so many rows is looked through each time.
    static constexpr u32 kScanned = 32;

    // To be called each time a longer table is needed. Null: it is to be looked through, since it has not been so several times yet, or
    // since all lookups together have become too large.
    const RowLookup* at(u32 catom, const RowsHead& table, std::size_t row_bytes, std::span<const Instruction::Field> key);
    // To be called before the tables change.
    void clear();

  private:
    struct Table {
        u32 scans = 0;
        RowLookup lookup = {};
    };
    std::unordered_map<u32, Table> tables_;
    std::size_t rows_ = 0;
};

}  // namespace meld::inspect
