// Values of more than one word, driven by their types: their order, hash and size, the blocks in which facts keep them, and
// their way between processes. Text is in value_text.h.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string_view>
#include <vector>

#include "runtime/abi/module_abi.h"
#include "runtime/base/bytes.h"

namespace meld::tuple {

// A type of a module: a number in its table of types.
class Type {
  public:
    Type(const TypeInfo* table, u16 number) : table_(table), number_(number) {}
    ValueType kind() const { return table_[number_].kind; }
    // Whether its values are lists.
    bool compound() const { return kind() >= ValueType::String; }
    // Structs, tuples and vec3 have a fixed number of fields; lists, sets and arrays elements of one type.
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
inline std::size_t length(const List* list) { return list == nullptr ? 0 : list->count; }

// Three-way: numbers as numbers, strings by bytes, all else by elements in order, a prefix before what it begins.
int compare(Type type, Value a, Value b);
// A word in the same order, as far as it tells: where a's is less than b's, a is less than b.
u64 order_prefix(Type type, Value v);
// By content; what compares equal hashes equal. Of a single word it is the word.
u64 hash(Type type, Value v);
// A value as it is kept: there is one zero.
inline Value normal(ValueType kind, Value v) {
    if (kind == ValueType::Float) v.real += 0.0;
    return v;
}

// Memory for lists that live as long as it does: what has been read, before a fact keeps it.
class Arena {
  public:
    u64* words(std::size_t count);
    // A list of these items; null where there are none.
    const List* list(const std::vector<u64>& items);
    const List* text(std::string_view bytes);

  private:
    std::deque<List> lists_;
    std::vector<std::unique_ptr<u64[]>> words_;
};

// Into bytes, without addresses, and back: into an arena, for the same types. A single word is packed as it is.
void pack(Type type, Value v, ByteWriter& out);
Value unpack(Type type, ByteReader& in, Arena& arena);

// The lists that the facts of one process own. A list that is kept stands with everything in it in one block with a count of
// its owners, so that to hand it on is to count. Different threads may keep and release at once, each with its own pool.
class ListStore {
  public:
    explicit ListStore(int pools) : pools_(static_cast<std::size_t>(pools)) {}
    ~ListStore();  // All lists must have been released.
    ListStore(const ListStore&) = delete;
    ListStore& operator=(const ListStore&) = delete;

    // The same value with one owner more; empty lists are null. Where a list has more items than the limit, null is
    // returned and too_long() says so.
    const List* keep(Type type, const List* list, int pool);
    // One owner less. The last one frees the block.
    void release(const List* list, int pool);
    // The same of any value; single words are nobody's.
    Value keep(Type type, Value v, int pool) {
        if (!type.compound()) return normal(type.kind(), v);
        return {.list = keep(type, v.list, pool)};
    }
    void release(Type type, Value v, int pool) {
        if (type.compound()) release(v.list, pool);
    }

    // The items of a list that is kept and has one owner, who may change them where they are; null of all others.
    u64* own_items(const List* list) const;

    // No list may have more items, and no block more bytes.
    void limit(std::size_t items) { most_items_ = items; }
    // The first list that was refused since it was last asked; of no items: none.
    struct Refused {
        std::size_t items = 0;
        bool text = false;  // It is a string, and its items bytes.
    };
    Refused too_long(int pool);
    // Of all blocks. Not while others keep or release.
    std::size_t bytes() const;

  private:
    // Each on its own cache line. Blocks move between pools, so a pool's bytes may be negative; the sum is right.
    struct alignas(64) Pool {
        std::ptrdiff_t bytes = 0;
        Refused too_long;
    };

    std::vector<Pool> pools_;
    std::size_t most_items_ = ~std::size_t{0};
};

}  // namespace meld::tuple
