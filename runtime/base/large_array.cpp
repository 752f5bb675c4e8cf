#include "runtime/base/large_array.h"

#include <sys/mman.h>

#include <cstdint>
#include <new>

namespace meld {

namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;

std::size_t whole_pages(std::size_t bytes) { return (bytes + kLargePage - 1) / kLargePage * kLargePage; }

void advise(std::uintptr_t from, std::size_t bytes) { static_cast<void>(madvise(reinterpret_cast<void*>(from), bytes, MADV_HUGEPAGE)); }

}  // namespace

void ask_for_large_pages(void* memory, std::size_t bytes) {
    if (memory == nullptr || bytes < kLargeBytes) return;
    const auto begin = reinterpret_cast<std::uintptr_t>(memory);
    const std::uintptr_t from = whole_pages(begin), to = (begin + bytes) / kLargePage * kLargePage;
    if (from < to) advise(from, to - from);
}

// Mapped separately, not taken from the heap: the C library does not reuse freed memory that was aligned this way, so arrays that are made
// again and again would take several times their size.
void* allocate_large(std::size_t bytes) {
    const std::size_t whole = whole_pages(bytes), mapped = whole + kLargePage;
    void* memory = MAP_FAILED;
    while ((memory = mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) == MAP_FAILED) {
        const std::new_handler handler = std::get_new_handler();
        if (handler == nullptr) throw std::bad_alloc();
        handler();
    }
    const auto found = reinterpret_cast<std::uintptr_t>(memory), begin = whole_pages(found);
    if (begin > found) munmap(memory, begin - found);
    munmap(reinterpret_cast<void*>(begin + whole), found + mapped - begin - whole);
    // A last piece that would leave most of a large page empty stays in small ones.
    advise(begin, (bytes + kLargePage / 2) / kLargePage * kLargePage);
    return reinterpret_cast<void*>(begin);
}

void free_large(void* memory, std::size_t bytes) { munmap(memory, whole_pages(bytes)); }

}  // namespace meld
