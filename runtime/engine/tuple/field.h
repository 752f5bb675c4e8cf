// The value of a field in a record or a row, and those of all fields of a row.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

template <class Int>
i64 load_narrow(const u8* at) {
    Int value = 0;
    std::memcpy(&value, at, sizeof value);
    return value;
}

// `element`: of a fact for each port, the port.
inline Value load_field(const FieldInfo& field, const u8* base, std::size_t element = 0) {
    Value v{};
    const u8* at = base + field.offset + element * field.bytes;
    switch (field.bytes) {
        case 1:
            v.integer = field.type == ValueType::Bool ? *at : static_cast<i8>(*at);
            break;
        case 2:
            v.integer = load_narrow<i16>(at);
            break;
        case 4:
            v.integer = load_narrow<i32>(at);
            break;
        default:
            std::memcpy(&v, at, 8);
    }
    return v;
}

// Of a predicate with at most one fact in a record, or of a row: the word at this place, and whether there is the fact.
inline u32 word_at(const u8* record, u32 offset) {
    u32 word = 0;
    std::memcpy(&word, record + offset, sizeof word);
    return word;
}
inline bool is_present(const PredicateInfo& p, const u8* record) {
    if (p.rank_offset != kNone32) return word_at(record, p.rank_offset) != kAbsent;
    return (record[p.presence_offset] & p.presence_mask) != 0;
}

// The arguments of a fact that is a row.
inline void read_row(const PredicateInfo& p, const u8* row, std::vector<Value>& out) {
    out.resize(p.arity);
    for (u32 i = 0; i < p.arity; ++i) out[i] = load_field(p.fields[i], row);
}

}  // namespace meld::tuple
