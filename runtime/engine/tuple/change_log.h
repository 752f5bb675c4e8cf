// The rows of a column that changed at each catom since its readers were last evaluated. Lives for one tick: an evaluation reads what was
// noted before it, and its own changes are noted for the next.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

// Where a catom of a snapshot is here.
struct SavedCatom {
    u32 catom = kNone32;  // None: nowhere.
    bool owned = false;   // Else it is a ghost.
    bool here() const { return catom != kNone32; }
};

class ChangeLog {
  public:
    // pools: how many threads may note changes at the same time.
    ChangeLog(const ModuleInfo& module, int pools);

    bool follows(u32 column) const { return module_.columns[column].compare_groups != nullptr; }
    void resize(std::size_t catoms);
    // As SubdomainView::changes.
    const RowChanges* const* const* pointers() const { return pointers_.data(); }

    // Room for this many rows; valid until the end of the next evaluation.
    RowChanges* make(u32 column, u32 removed, u32 added, int pool);
    // Adds changes for the catom's readers. One thread at a time notes changes of a catom.
    void note(u32 column, u32 catom, RowChanges* changes, int pool);
    const RowChanges* of(u32 column, u32 catom) const { return noted_[column][catom]; }
    void forget(u32 catom);
    // Whether anything is noted of a catom.
    bool any(u32 catom) const {
        return std::ranges::any_of(noted_, [&](const auto& column) { return catom < column.size() && column[catom] != nullptr; });
    }

    // What was noted of a column for some catoms, oldest first, and back. Ghosts are not told which groups were woken: that is the
    // owner's alone.
    void save(u32 column, std::span<const u32> catoms, ByteWriter& out) const;
    void load(u32 column, std::span<const SavedCatom> catoms, ByteReader& in);

    // Called before and after an evaluation: changes made in it are kept, changes noted before it are dropped after it, but those of catoms
    // that `waits` names, which have not been evaluated.
    void begin_evaluation() { filling_ = 1 - filling_; }
    void end_evaluation(const std::function<bool(u32)>& waits = {});

    std::size_t bytes() const;

  private:
    struct Arena {
        std::vector<std::unique_ptr<u64[]>> chunks;
        std::size_t next = 0, left = 0;  // In words; of the last chunk.
        u64* take(std::size_t words);
        void reset();
    };
    struct Place {
        u32 column;
        u32 catom;
    };
    struct Pool {
        Arena arenas[2];
        std::vector<Place> noted;
    };

    RowChanges* copy(u32 column, const RowChanges& changes, int pool);

    const ModuleInfo& module_;
    std::vector<std::vector<const RowChanges*>> noted_;  // [column][catom]; empty if the changes of a column are not recorded.
    std::vector<const RowChanges* const*> pointers_;
    std::vector<Pool> pools_;
    int filling_ = 0;
};

}  // namespace meld::tuple
