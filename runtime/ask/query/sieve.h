// Looks at many catoms at once for those from which a body may be satisfied: most often none.
//
// It takes the first steps of the search from a catom, as far as it knows them, and each step for a thousand catoms before the next: what a
// step costs by itself is paid once for all of them. Whatever it cannot decide, such as a value that would overflow or a fact of another
// process, it lets through: the solver then looks exactly.
#pragma once

#include <span>
#include <vector>

#include "runtime/ask/query/row_lookup.h"
#include "runtime/ask/query/sieve_code.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

class Sieve {
  public:
    // All outlive it.
    Sieve(const Program& program, const check::Rule& rule, check::VariableId start, const sim::Subdomain& subdomain);

    // Those of these catoms of this process that are left, in their order. The state of the run does not change meanwhile.
    std::vector<u64> pass(std::span<const u32> catoms);
    // It lets everything through.
    bool idle() const { return code_.instructions.empty(); }
    // How many facts and neighbours it has gone through so far.
    u64 rows_made() const { return rows_made_; }

  private:
    static constexpr u32 kRows = 1024;
    using Code = std::vector<Instruction>;
    // Rows made from the same rows: of each, its registers, and which rows are left.
    struct Level {
        std::vector<Value> cells;  // [register * kRows + row]
        std::vector<u32> left;
        u32 made = 0;
        std::vector<i64> ends;  // Of Not and Count: how many rows that were made from each have come to the end.
    };

    Value* cells(u32 level, Register r) { return levels_[level].cells.data() + std::size_t{r} * kRows; }
    // Takes the instructions from this one on; `ends` counts the rows at the end by what they have in `by`.
    void run(const Code& code, std::size_t at, u32 level, Register by, std::vector<i64>& ends);
    template <class Holds>
    void filter(u32 level, const Holds& holds);
    // Makes rows; `each` gets a row and calls add() for each that comes from it.
    template <class Each>
    void make(const Code& code, std::size_t at, u32 level, Register by, std::vector<i64>& ends, const Each& each);
    void rows(const Code& code, std::size_t at, u32 level, Register by, std::vector<i64>& ends);
    void part(const Instruction& i, u32 level);
    void find(const Instruction& i, u32 level);
    void read(const Instruction& i, u32 level);
    void compute(const Instruction& i, u32 level);
    void test(const Instruction& i, u32 level);
    // The catom's facts are here; else its row goes, undecided.
    bool here(u32 level, u32 row, u32 catom);
    void undecided(u32 level, u32 row) { kept_[cells(level, SieveCode::kOrigin)[row].catom] = 1; }

    const sim::Subdomain& subdomain_;
    SieveCode code_;
    std::vector<Level> levels_;
    std::vector<i64> kept_;  // By origin.
    u64 rows_made_ = 0;
    std::vector<RowLookups> lookups_;  // By number; for the catoms of one pass of so many rows.
};

}  // namespace meld::inspect
