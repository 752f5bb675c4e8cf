// Values of more than one word, handled by their types: their order, hash and size, the blocks in which facts keep them, and their transfer
// between processes. Text is in value_text.h.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

// A type of a module: a number in its table of types.
class Type {
  public:
    Type(const TypeInfo* table, u16 number) : table_(table), number_(number) {}
    ValueType kind() const { return table_[number_].kind; }
    // Whether its values are lists.
    bool compound() const { return kind() >= ValueType::String; }
    // Structs, tuples and vec3 have a fixed number of fields; lists, sets and arrays have elements of one type.
    bool has_fields() const { return kind() >= ValueType::Struct; }
    std::size_t field_count() const { return kind() == ValueType::Vec3 ? 3 : table_[number_].part_count; }
    // The type of the field or element at an index.
    Type item(std::size_t index) const {
        const TypeInfo& info = table_[number_];
        if (info.kind == ValueType::Vec3) return {table_, static_cast<u16>(ValueType::Float)};
        return {table_, info.parts[has_fields() ? index : 0]};
    }

  private:
    const TypeInfo* table_;
    u16 number_;
};
inline Type type_of(const ModuleInfo& module, const FieldInfo& field) { return {module.types, field.deep}; }

inline Value item(const List* list, std::size_t index) { return std::bit_cast<Value>(list->items[index]); }
// The bytes of a string.
inline std::string_view bytes_of(const List* string) {
    return string == nullptr ? std::string_view{} : std::string_view(reinterpret_cast<const char*>(string->items), string->count);
}
inline std::size_t length(const List* list) { return list == nullptr ? 0 : list->count; }

// Three-way: numbers as numbers, strings by bytes, everything else by elements in order, a prefix before the longer value.
int compare(Type type, Value a, Value b);
// A word in the same order, as far as possible: if a's is less than b's, a is less than b. Of a list of small numbers it has the first
// eight.
u64 order_prefix(Type type, Value v);
// By content; equal values hash equal. The hash of a single word is the word.
u64 hash(Type type, Value v);
// A value as it is stored: zero has one sign.
inline Value normal(ValueType kind, Value v) {
    if (kind == ValueType::Float) v.real += 0.0;
    return v;
}

// Memory for lists that live as long as it does: for values that were read, until a fact keeps them, and for those that are sent.
class Arena {
  public:
    u64* words(std::size_t count);
    // A list of these items; null if there are none.
    const List* list(const std::vector<u64>& items);
    const List* text(std::string_view bytes);
    // A list of so many items, more than none, which are to be written to the words that it returns too.
    std::pair<const List*, u64*> make_list(std::size_t count);
    // All lists end. Their memory is used again; what was not needed since the last call is freed.
    void clear();
    std::size_t bytes() const;

  private:
    struct Chunk {
        std::unique_ptr<u64[]> words;
        std::size_t count = 0;
    };
    void next_chunk(std::size_t count);
    const List* place(u64* at, std::size_t count);
    std::vector<Chunk> chunks_;
    std::size_t used_ = 0;  // Chunks; the last of them is being filled.
    u64* next_ = nullptr;
    std::size_t left_ = 0;  // In words.
};

// To bytes, without addresses, and back: into an arena, for the same types. A single word is packed unchanged.
void pack(Type type, Value v, ByteWriter& out);
Value unpack(Type type, ByteReader& in, Arena& arena);

// The lists that the facts of one process own. A stored list is in one block with everything in it and a count of its owners, so sharing it
// only counts. Different threads may keep and release at the same time, each with its own pool.
class ListStore {
  public:
    explicit ListStore(int pools) : pools_(static_cast<std::size_t>(pools)) {}
    ~ListStore();  // All lists must have been released.
    ListStore(const ListStore&) = delete;
    ListStore& operator=(const ListStore&) = delete;

    // The same value with one more owner; empty lists are null. If a list has more items than the limit, returns null, and too_long()
    // reports it.
    const List* keep(Type type, const List* list, int pool);
    // One owner more of a stored list.
    void share(const List* list);
    // A copy of a list outside of blocks, which nobody owns, under the same limit; empty lists are null.
    const List* copy(Type type, const List* list, Arena& arena, int pool);
    // One owner less. The last one frees the block.
    void release(const List* list, int pool);
    // The same for any value; single words have no owner.
    Value keep(Type type, Value v, int pool) {
        if (!type.compound()) return normal(type.kind(), v);
        return {.list = keep(type, v.list, pool)};
    }
    void release(Type type, Value v, int pool) {
        if (type.compound()) release(v.list, pool);
    }

    // The items of a stored list with one owner, who may change them in place; null for all others.
    u64* own_items(const List* list) const;

    // No list may have more items, and no block more bytes, than this.
    void limit(std::size_t items) { most_items_ = items; }
    // The first list that was refused since the last call; none if it has no items.
    struct Refused {
        std::size_t items = 0;
        bool text = false;  // It is a string, and its items bytes.
    };
    Refused too_long(int pool);
    // The bytes of all blocks. Not while others keep or release.
    std::size_t bytes() const;

  private:
    // The words of a copy of a list with everything in it, of which `before` bytes come first; none if it is refused.
    std::size_t words_for(Type type, const List* list, std::size_t before, int pool);
    // Each on its own cache line. Blocks move between pools, so a pool's bytes may be negative; the sum is correct.
    struct alignas(64) Pool {
        std::ptrdiff_t bytes = 0;
        Refused too_long;
    };

    std::vector<Pool> pools_;
    std::size_t most_items_ = ~std::size_t{0};
};

}  // namespace meld::tuple
