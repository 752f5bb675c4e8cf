#include "runtime/engine/tuple/row_pool.h"

#include "runtime/base/assert.h"

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
    reserved_ += bytes;
    return slabs_.emplace_back(bytes).data();
}

void RowPool::give(std::uint8_t* block, std::size_t bytes) {
    MELD_EXPECT(block != nullptr && bytes > 0);
    free_[size_class(bytes)].push_back(block);
}

}  // namespace meld::tuple
