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

// The arguments of a fact that is a row.
inline void read_row(const PredicateInfo& p, const u8* row, std::vector<Value>& out) {
    out.resize(p.arity);
    for (u32 i = 0; i < p.arity; ++i) out[i] = load_field(p.fields[i], row);
}

}  // namespace meld::tuple
