// Memory in huge pages.
#include "physics/bodies/buffer.h"

#include <cstdint>
#include <cstdlib>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace meld::physics {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

std::size_t whole_pages(std::size_t bytes) { return (bytes + kHugePage - 1) / kHugePage * kHugePage; }

}  // namespace

#if defined(__linux__)

// Mapped separately, not taken from the heap: the C library does not reuse freed memory that was aligned this way, so a world that remakes
// its arrays would grow without end.
void* allocate_large(std::size_t bytes) {
    const std::size_t whole = whole_pages(bytes), mapped = whole + kHugePage;
    void* const memory = mmap(nullptr, mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    auto* const begin = static_cast<std::byte*>(memory);
    const std::size_t before = (kHugePage - reinterpret_cast<std::uintptr_t>(begin) % kHugePage) % kHugePage;
    if (before > 0) munmap(begin, before);
    munmap(begin + before + whole, kHugePage - before);
    // Advice only: without huge pages everything works, more slowly. A last piece that would leave most of a huge page empty stays in small
    // ones.
    static_cast<void>(madvise(begin + before, (bytes + kHugePage / 2) / kHugePage * kHugePage, MADV_HUGEPAGE));
    return begin + before;
}

void free_large(void* memory, std::size_t bytes) { munmap(memory, whole_pages(bytes)); }

std::size_t give_back_pages(void* memory, std::size_t gone_bytes, std::size_t end_bytes) {
    // Huge pages are not split: the rest of one would not be returned before all of it is free.
    const std::size_t end = end_bytes / kHugePage * kHugePage;
    if (end <= gone_bytes) return gone_bytes;
    static_cast<void>(madvise(static_cast<std::byte*>(memory) + gone_bytes, end - gone_bytes, MADV_DONTNEED));
    return end;
}

#else

void* allocate_large(std::size_t bytes) {
    void* const memory = std::aligned_alloc(kHugePage, whole_pages(bytes));
    if (!memory) throw std::bad_alloc();
    return memory;
}

void free_large(void* memory, std::size_t) { std::free(memory); }

std::size_t give_back_pages(void*, std::size_t gone_bytes, std::size_t) { return gone_bytes; }

#endif

}  // namespace meld::physics
