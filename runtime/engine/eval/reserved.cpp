#include "runtime/engine/eval/reserved.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>

namespace meld::eval {

void* Reserved::take(u32 catom, u64 bytes) {
    if (catom != catom_) clear();
    catom_ = catom;
    void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) return nullptr;
    all_.push_back({memory, bytes});
    return memory;
}

// What was taken last is mostly what is given back.
std::vector<Reserved::Pages>::iterator Reserved::find(void* memory) {
    const auto found = std::ranges::find(all_.rbegin(), all_.rend(), memory, &Pages::memory);
    return found == all_.rend() ? all_.end() : std::prev(found.base());
}

void Reserved::give_back(void* memory) {
    const auto found = find(memory);
    if (found == all_.end()) return;
    munmap(found->memory, found->bytes);
    all_.erase(found);
}

void Reserved::empty(void* memory) {
    const auto found = find(memory);
    if (found == all_.end()) return;
    // Its first page remains, and takes none of the machine's memory.
    const u64 page = static_cast<u64>(sysconf(_SC_PAGESIZE));
    if (found->bytes > page) munmap(static_cast<u8*>(memory) + page, found->bytes - page);
    found->bytes = std::min(found->bytes, page);
    madvise(memory, found->bytes, MADV_DONTNEED);
}

void Reserved::clear() {
    for (const Pages& p : all_) munmap(p.memory, p.bytes);
    all_.clear();
}

}  // namespace meld::eval
