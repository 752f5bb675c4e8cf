// Scratch memory for values that are computed while a question is answered: the kernel's Eval, which module code has too. What was made
// since a mark can be given back, so that a search keeps only what its present bindings need.
#pragma once

#include <memory>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

class Scratch : public Eval {
  public:
    // The view is that of the run: its constants, and the limits of the world.
    explicit Scratch(const SubdomainView& view);
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    struct Mark {
        std::size_t chunk;
        u8* at;
    };
    Mark mark() const { return {chunk_, arena}; }
    // Everything made since the mark ends.
    void release(Mark mark);

    // Whether what was computed last has a value; if not, that is counted, and the next computation starts again.
    bool went_well() {
        if (trap == Trap::None) [[likely]]
            return true;
        note_failure();
        return false;
    }
    u64 failures() const { return failures_; }
    Trap first_failure() const { return first_; }

  private:
    void note_failure();
    void use(std::size_t chunk);

    struct Chunk {
        std::unique_ptr<u8[]> bytes;
        std::size_t size;
    };
    std::vector<Chunk> chunks_;
    std::size_t chunk_ = 0;
    Host host_{};
    u64 failures_ = 0;
    Trap first_ = Trap::None;
};

}  // namespace meld::inspect
