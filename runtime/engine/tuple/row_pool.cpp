#include "runtime/engine/tuple/row_pool.h"

#include "runtime/base/assert.h"
#include "runtime/base/large_array.h"
#include "runtime/base/process/deep_stack.h"

namespace meld::tuple {

std::uint8_t* RowPool::take(std::size_t bytes) {
    MELD_EXPECT(bytes > 0);
    const std::size_t cls = size_class(bytes), size = std::size_t{1} << cls;
    if (!free_[cls].empty()) {
        std::uint8_t* block = free_[cls].back();
        free_[cls].pop_back();
        return block;
    }
    if (size > kSlab / 4) return new_slab(size);
    if (left_ < size) {
        left_ = reserved_ < kMany ? kSlab : kLargeSlab;
        next_ = new_slab(left_);
    }
    std::uint8_t* block = next_;
    next_ += size;
    left_ -= size;
    return block;
}

std::uint8_t* RowPool::new_slab(std::size_t bytes) {
    auto* const slab = static_cast<std::uint8_t*>(allocate_large(bytes));
    if (slab == nullptr) memory_has_run_out();
    slabs_.emplace_back(slab);
    reserved_ += bytes;
    return slab;
}

void RowPool::give(std::uint8_t* block, std::size_t bytes) {
    MELD_EXPECT(block != nullptr && bytes > 0);
    free_[size_class(bytes)].push_back(block);
}

}  // namespace meld::tuple
