#include "runtime/engine/tuple/values.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/base/process/deep_stack.h"

namespace meld::tuple {

namespace {

template <class V>
int compare_words(V a, V b) {
    return a < b ? -1 : b < a ? 1 : 0;
}

// The number of words of a list's items.
std::size_t item_words(Type type, std::size_t count) { return type.kind() == ValueType::String ? (count + 7) / 8 : count; }

u64 word_of(const List* list) { return reinterpret_cast<u64>(list); }

}  // namespace

int compare(Type type, Value a, Value b) {
    switch (type.kind()) {
        case ValueType::Float:
            return compare_words(a.real, b.real);
        case ValueType::Node:
            return compare_words(a.catom, b.catom);
        case ValueType::Int:
        case ValueType::Bool:
            return compare_words(a.integer, b.integer);
        case ValueType::String:
            return compare_words(bytes_of(a.list).compare(bytes_of(b.list)), 0);
        default:
            break;
    }
    if (a.list == b.list) return 0;
    const std::size_t left = length(a.list), right = length(b.list);
    // Words are compared without a test of the type for each.
    if (!type.has_fields() && type.item(0).kind() == ValueType::Int) {
        for (std::size_t i = 0; i < std::min(left, right); ++i)
            if (a.list->items[i] != b.list->items[i]) return compare_words(item(a.list, i).integer, item(b.list, i).integer);
        return compare_words(left, right);
    }
    for (std::size_t i = 0; i < std::min(left, right); ++i)
        if (const int c = compare(type.item(i), item(a.list, i), item(b.list, i))) return c;
    return compare_words(left, right);
}

namespace {

constexpr u64 kSign = u64{1} << 63;

// A byte for each of the first eight items: 0 at the end, and 2 and more for a number. A number for which a byte is too small is the last:
// 1 or 255, and if it is the first, the rest of the word is its own.
u64 prefix_of_ints(const List* list) {
    constexpr i64 kLeast = 0, kMost = 252;
    u64 prefix = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(8, length(list)); ++i) {
        const i64 v = item(list, i).integer;
        const bool fits = v >= kLeast && v <= kMost;
        prefix |= (fits ? static_cast<u64>(v) + 2 : v < kLeast ? 1u : 255u) << (56 - 8 * i);
        if (fits) continue;
        return i == 0 ? prefix | (std::bit_cast<u64>(v) ^ kSign) >> 8 : prefix;
    }
    return prefix;
}

}  // namespace

u64 order_prefix(Type type, Value v) {
    switch (type.kind()) {
        case ValueType::Int:
            return std::bit_cast<u64>(v.integer) ^ kSign;
        case ValueType::Node:
        case ValueType::Bool:
            return v.catom;
        case ValueType::Float: {
            const u64 bits = normal(ValueType::Float, v).catom;
            return (bits & kSign) != 0 ? ~bits : bits | kSign;
        }
        case ValueType::String: {
            u64 prefix = 0;
            for (std::size_t i = 0; i < std::min<std::size_t>(8, length(v.list)); ++i)
                prefix |= u64{static_cast<unsigned char>(bytes_of(v.list)[i])} << (56 - 8 * i);
            return prefix;
        }
        default:
            if (length(v.list) == 0) return 0;
            if (!type.has_fields() && type.item(0).kind() == ValueType::Int) return prefix_of_ints(v.list);
            return order_prefix(type.item(0), item(v.list, 0));
    }
}

u64 hash(Type type, Value v) {
    if (!type.compound()) return normal(type.kind(), v).catom;
    if (type.kind() == ValueType::String) return hash_text(bytes_of(v.list));
    u64 h = length(v.list);
    for (std::size_t i = 0; i < length(v.list); ++i) h = hash_combine(h, hash(type.item(i), item(v.list, i)));
    return h;
}

// ---- arena

namespace {

// Most values that are read are a few lists of a few words; those that a tick sends may be millions.
constexpr std::size_t kFirstChunk = 512, kLargestChunk = 1 << 16, kListWords = sizeof(List) / sizeof(u64);
static_assert(sizeof(List) % sizeof(u64) == 0 && alignof(List) <= alignof(u64));

}  // namespace

u64* Arena::words(std::size_t count) {
    if (count > left_) next_chunk(count);
    u64* const words = next_;
    next_ += count, left_ -= count;
    return words;
}

void Arena::next_chunk(std::size_t count) {
    const auto too_small = [&](const Chunk& chunk) { return chunk.count < count; };
    chunks_.erase(chunks_.begin() + static_cast<std::ptrdiff_t>(used_),
                  std::find_if_not(chunks_.begin() + static_cast<std::ptrdiff_t>(used_), chunks_.end(), too_small));
    if (used_ == chunks_.size()) {
        const std::size_t size = chunks_.empty() ? kFirstChunk : std::min(kLargestChunk, 2 * chunks_.back().count);
        chunks_.push_back({nullptr, std::max(size, count)});
        chunks_.back().words = std::make_unique_for_overwrite<u64[]>(chunks_.back().count);
    }
    next_ = chunks_[used_].words.get();
    left_ = chunks_[used_++].count;
}

void Arena::clear() {
    chunks_.resize(used_);
    used_ = left_ = 0;
    next_ = nullptr;
}

std::size_t Arena::bytes() const {
    std::size_t total = 0;
    for (const Chunk& chunk : chunks_) total += chunk.count * sizeof(u64);
    return total;
}

// The items follow the list.
const List* Arena::place(u64* at, std::size_t count) { return new (at) List{at + kListWords, static_cast<u32>(count), 0}; }

std::pair<const List*, u64*> Arena::make_list(std::size_t count) {
    u64* const at = words(kListWords + count);
    return {place(at, count), at + kListWords};
}

const List* Arena::list(const std::vector<u64>& items) {
    if (items.empty()) return nullptr;
    const auto [list, copy] = make_list(items.size());
    std::copy(items.begin(), items.end(), copy);
    return list;
}

const List* Arena::text(std::string_view bytes) {
    if (bytes.empty()) return nullptr;
    u64* const at = words(kListWords + (bytes.size() + 7) / 8);
    std::memcpy(at + kListWords, bytes.data(), bytes.size());
    return place(at, bytes.size());
}

// ---- packing

void pack(Type type, Value v, ByteWriter& out) {
    if (!type.compound()) return out.write(v);
    const std::size_t count = length(v.list);
    out.write_count(count);
    if (count == 0) return;
    if (type.kind() == ValueType::String) return out.write_bytes(v.list->items, count);
    for (std::size_t i = 0; i < count; ++i) pack(type.item(i), item(v.list, i), out);
}

Value unpack(Type type, ByteReader& in, Arena& arena) {
    if (!type.compound()) return in.read<Value>();
    Value v{.list = nullptr};
    if (type.kind() == ValueType::String) {
        const auto text = in.read_block();
        v.list = arena.text({reinterpret_cast<const char*>(text.data()), text.size()});
        return v;
    }
    // An item is a word or the count of a list.
    const std::size_t count = in.read_count(sizeof(u32));
    if (count == 0) return v;
    const auto [list, items] = arena.make_list(count);
    for (std::size_t i = 0; i < count; ++i) items[i] = unpack(type.item(i), in, arena).catom;
    v.list = list;
    return v;
}

// ---- blocks

namespace {

struct Block {
    std::atomic<u32> owners;
    u32 bytes;
    List list;  // Its items, and the lists inside it with theirs, follow.
};
static_assert(sizeof(Block) == 24);

Block* block_of(const List* list) {
    return reinterpret_cast<Block*>(const_cast<std::byte*>(reinterpret_cast<const std::byte*>(list)) - offsetof(Block, list));
}

// The size of a list with everything in it, without the List itself; and the longest list in it.
struct Measure {
    std::size_t words = 0;
    std::size_t longest = 0;
    bool longest_is_text = false;

    void add(Type type, const List* list) {
        if (length(list) > longest) {
            longest = length(list);
            longest_is_text = type.kind() == ValueType::String;
        }
        words += item_words(type, length(list));
        if (type.kind() == ValueType::String || length(list) == 0) return;
        if (!type.has_fields()) {
            if (const Type element = type.item(0); element.compound())
                for (std::size_t i = 0; i < list->count; ++i) add_inner(element, item(list, i).list);
            return;
        }
        for (std::size_t i = 0; i < list->count; ++i)
            if (const Type field = type.item(i); field.compound()) add_inner(field, item(list, i).list);
    }
    void add_inner(Type type, const List* list) {
        if (length(list) == 0) return;
        words += sizeof(List) / sizeof(u64);
        add(type, list);
    }
};

// Copies the items of a list, and the lists in it, to `to` and after it; returns where the next may begin.
u64* copy_items(Type type, const List& from, List& into, u64* to) {
    u64* items = to;
    to += item_words(type, from.count);
    into.items = items;
    into.count = from.count;
    if (type.kind() == ValueType::String) {
        std::memcpy(items, from.items, from.count);
        return to;
    }
    if (!type.has_fields() && !type.item(0).compound() && type.item(0).kind() != ValueType::Float) {
        std::memcpy(items, from.items, std::size_t{from.count} * sizeof(u64));
        return to;
    }
    for (std::size_t i = 0; i < from.count; ++i) {
        const Type inner = type.item(i);
        const Value v = item(&from, i);
        if (!inner.compound()) {
            items[i] = normal(inner.kind(), v).catom;
        } else if (length(v.list) == 0) {
            items[i] = word_of(nullptr);
        } else {
            List* list = new (to) List{nullptr, 0, 0};
            items[i] = word_of(list);
            to = copy_items(inner, *v.list, *list, to + sizeof(List) / sizeof(u64));
        }
    }
    return to;
}

}  // namespace

ListStore::~ListStore() { MELD_ENSURE(bytes() == 0, "{} bytes of lists are nobody's", bytes()); }

const List* ListStore::keep(Type type, const List* list, int pool) {
    if (length(list) == 0) return nullptr;
    if (list->stored != 0) {
        share(list);
        return list;
    }
    const std::size_t words = words_for(type, list, sizeof(Block), pool), bytes = sizeof(Block) + words * sizeof(u64);
    if (words == 0) return nullptr;
    void* memory = std::malloc(bytes);
    if (memory == nullptr) memory_has_run_out();
    Block* block = new (memory) Block{1, static_cast<u32>(bytes), {nullptr, 0, 1}};
    copy_items(type, *list, block->list, reinterpret_cast<u64*>(block + 1));
    pools_[static_cast<std::size_t>(pool)].bytes += static_cast<std::ptrdiff_t>(bytes);
    return &block->list;
}

void ListStore::share(const List* list) { block_of(list)->owners.fetch_add(1, std::memory_order_relaxed); }

const List* ListStore::copy(Type type, const List* list, Arena& arena, int pool) {
    if (length(list) == 0) return nullptr;
    const std::size_t words = words_for(type, list, sizeof(List), pool);
    if (words == 0) return nullptr;
    u64* const at = arena.words(kListWords + words);
    List* const copied = new (at) List{nullptr, 0, 0};
    copy_items(type, *list, *copied, at + kListWords);
    return copied;
}

std::size_t ListStore::words_for(Type type, const List* list, std::size_t before, int pool) {
    Measure measure;
    measure.add(type, list);
    if (measure.longest <= most_items_ && before + measure.words * sizeof(u64) <= 0xffffffff) return measure.words;
    Refused& refused = pools_[static_cast<std::size_t>(pool)].too_long;
    if (refused.items == 0) refused = {measure.longest, measure.longest_is_text};
    return 0;
}

void ListStore::release(const List* list, int pool) {
    if (list == nullptr) return;
    MELD_EXPECT(list->stored != 0);
    Block* block = block_of(list);
    // The last owner must see everything that others did with the list before it frees it.
    if (block->owners.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
    pools_[static_cast<std::size_t>(pool)].bytes -= static_cast<std::ptrdiff_t>(block->bytes);
    block->~Block();
    std::free(block);
}

u64* ListStore::own_items(const List* list) const {
    const bool own = length(list) > 0 && list->stored != 0 && block_of(list)->owners.load(std::memory_order_acquire) == 1;
    return own ? const_cast<u64*>(list->items) : nullptr;
}

ListStore::Refused ListStore::too_long(int pool) { return std::exchange(pools_[static_cast<std::size_t>(pool)].too_long, {}); }

std::size_t ListStore::bytes() const {
    std::ptrdiff_t total = 0;
    for (const Pool& pool : pools_) total += pool.bytes;
    return static_cast<std::size_t>(total);
}

}  // namespace meld::tuple
