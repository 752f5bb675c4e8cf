#include "runtime/ask/query/scratch_memory.h"

#include <algorithm>

#include "runtime/base/assert.h"
#include "runtime/engine/eval/nearest_rotation.h"

namespace meld::inspect {

namespace {

constexpr std::size_t kFirstChunk = 1 << 16;

}  // namespace

Scratch::Scratch(const SubdomainView& view) : Eval{} {
    subdomain = &view;
    host = &host_;
    // Nothing else of the host is needed by what a question may compute: it draws no random numbers and looks at nothing by itself.
    host_.nearest_rotation = eval::nearest_rotation;
    host_.more_arena = [](Eval* e, u64 bytes) {
        auto& self = *static_cast<Scratch*>(e);
        const std::size_t next = self.chunk_ + 1;
        // A chunk that was given back may be too small.
        if (next < self.chunks_.size() && self.chunks_[next].size < bytes) self.chunks_.resize(next);
        if (next == self.chunks_.size()) {
            const std::size_t size = std::max<std::size_t>(bytes, self.chunks_.back().size * 2);
            self.chunks_.push_back({std::make_unique_for_overwrite<u8[]>(size), size});
        }
        self.use(next);
    };
    chunks_.push_back({std::make_unique_for_overwrite<u8[]>(kFirstChunk), kFirstChunk});
    use(0);
}

void Scratch::use(std::size_t chunk) {
    chunk_ = chunk;
    arena = arena_start = chunks_[chunk].bytes.get();
    arena_end = arena + chunks_[chunk].size;
}

void Scratch::release(Mark mark) {
    MELD_EXPECT(mark.chunk <= chunk_, "a mark in chunk {} of {}", mark.chunk, chunk_);
    if (mark.chunk != chunk_) use(mark.chunk);
    arena = mark.at;
}

void Scratch::note_failure() {
    if (failures_++ == 0) first_ = trap;
    trap = Trap::None;
}

}  // namespace meld::inspect
