// A linear rule that has fired: which, where and with which values. Kept of a tick for whoever asks for it, such as a debugger.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

struct Firing {
    u32 rule = 0;
    u64 catom = 0;                      // Its id.
    std::vector<std::byte> bound = {};  // By each variable that the program names: its name, the number of its type, its value.
};

inline std::vector<std::byte> pack_bound(const TypeInfo* types, std::span<const BoundVariable> variables, const Value* values) {
    ByteWriter out;
    for (std::size_t i = 0; i < variables.size(); ++i) {
        out.write_string(variables[i].name);
        out.write(variables[i].type);
        tuple::pack({types, variables[i].type}, values[i], out);
    }
    return out.take();
}

}  // namespace meld::eval
