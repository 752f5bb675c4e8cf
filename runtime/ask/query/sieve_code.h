// What a sieve does to many rows at once (sieve.h): instructions over registers, which hold a word for each row.
#pragma once

#include <optional>
#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/order.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

using Register = u32;

struct Instruction {
    enum class Kind {
        Find,     // to = the catom of this process with the number in a; a row without one goes.
        Number,   // to = the number of the catom in a.
        Read,     // The fact of a record at the catom in a; a row without one goes.
        Rows,     // A new row for each fact in the rows at the catom in a.
        Links,    // A new row for each neighbour of the catom in a: to.
        Compute,  // to = a `op` b
        Test,     // A row for which a `op` b is false goes.
        Keep,     // A row in which a is 0 goes.
        Not,      // A row for which `inner` has rows left goes.
        Count,    // to = how many rows `inner` has left.
    } kind = Kind::Keep;
    Register to = 0, a = 0, b = 0;
    check::Op op = check::Op::Equal;
    bool real = false;  // Of floats.
    bool back = false;  // Links: the port is the neighbour's.
    u32 predicate = kNone32;
    struct Field {
        const FieldInfo* info;
        Register to;
    };
    std::vector<Field> fields = {};
    // Rows: what a fact must agree with that is known before it is read. Long tables are looked up by that; a test still follows.
    std::vector<Field> key = {};
    u32 lookup = kNone32;                // Its number among the instructions with a key.
    std::optional<Register> port = {};   // Links.
    std::vector<Register> carried = {};  // Rows, Links, Not, Count: what new rows take over.
    std::vector<Instruction> inner = {};
};

struct SieveCode {
    // In the first rows, these are the row's own number and its catom.
    static constexpr Register kOrigin = 0, kStart = 1;
    struct Fixed {
        Register at;
        Value value;
    };
    std::vector<Instruction> instructions;
    std::vector<Fixed> fixed;  // The same in all rows, always.
    u32 registers = 2;
    u32 lookups = 0;  // Instructions with a key.
    u32 levels = 1;   // How often rows are made from rows, at most.
};

// As many of these steps as a sieve can take, from the first on. The catom of `start` is known.
SieveCode sieve_code(const Program& program, const check::Rule& rule, const std::vector<Step>& steps, check::VariableId start,
                     const SubdomainView& view);

}  // namespace meld::inspect
