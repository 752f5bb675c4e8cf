#include "runtime/engine/eval/reserved.h"

#include <sys/mman.h>

#include <algorithm>

namespace meld::eval {

void* Reserved::take(u32 catom, u64 bytes) {
    if (catom != catom_) clear();
    catom_ = catom;
    void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    all_.push_back({memory, bytes});
    return memory;
}

void Reserved::give_back(void* memory) {
    const auto found = std::ranges::find(all_, memory, &Pages::memory);
    if (found == all_.end()) return;
    munmap(found->memory, found->bytes);
    all_.erase(found);
}

void Reserved::clear() {
    for (const Pages& p : all_) munmap(p.memory, p.bytes);
    all_.clear();
}

}  // namespace meld::eval
