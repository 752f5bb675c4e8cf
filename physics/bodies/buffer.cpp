#include "physics/bodies/buffer.h"

#include <sys/mman.h>

namespace meld::physics {

std::size_t give_back_pages(void* memory, std::size_t gone_bytes, std::size_t end_bytes) {
    // Huge pages are not split: the rest of one would not be returned before all of it is free.
    constexpr std::size_t kHugePage = std::size_t{2} << 20;
    const std::size_t end = end_bytes / kHugePage * kHugePage;
    if (end <= gone_bytes) return gone_bytes;
    static_cast<void>(madvise(static_cast<std::byte*>(memory) + gone_bytes, end - gone_bytes, MADV_DONTNEED));
    return end;
}

}  // namespace meld::physics
