// The functions of the library: their types, and the C++ function of runtime/module/kernel/library.h for each. The table also makes
// docs/functions.md.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::check {

// A type in a signature: T stands for any type, N for int or float, S for a struct of floats, R for a list or a struct of them.
struct LibraryType {
    Type::Kind kind = Type::Kind::Error;
    char variable = 0;
    std::vector<LibraryType> parts = {};
};
using LibraryBindings = std::map<char, Type>;

struct LibraryFunction {
    std::string name;
    std::string signature;  // "list T, int -> T"
    std::string text;       // Its result, in a sentence.
    std::vector<LibraryType> parameters = {};
    LibraryType result = {};
    Op op = Op::Library;       // Those with an operator of their own need no C++ function.
    std::string cpp = {};      // The name there.
    bool compares = false;     // It compares values of type T, and gets the type as an argument.
    bool random = false;       // It returns a different value for each call.
    std::string section = {};  // Its section in the docs; empty: a name of older programs.
};

// All functions, sorted by section. Several may share a name; then they differ in the number of arguments.
const std::vector<LibraryFunction>& library();
// The function with this name and number of arguments; otherwise any with the name, or null.
const LibraryFunction* library_function(const std::string& name, std::size_t arguments);

// The functions that the library `older` (stdlib/older.meld) declares for programs of Linear Meld; and what to write where a program uses
// the name for something else.
std::span<const std::string_view> older_functions();
bool is_older(std::string_view name);
inline constexpr const char* kUseOlder = "write `use \"older\".` before it";

// What the machine of Linear Meld told programs about itself, by a fact or a function: facts_consumed, just-moved. Nothing here is like it.
struct MachineState {
    std::string_view word;  // With hyphens; programs also write it with underscores.
    std::string_view cure;
    bool never = false;  // It holds for no catom.
};
// Null: the word is none of these.
const MachineState* machine_state(std::string_view word);

// What the letters of a parameter stand for if its argument has this type. False if it does not fit.
bool match(const LibraryType& parameter, const Type& argument, LibraryBindings& bindings);
// The type with its letters replaced; one that is not bound is unknown.
Type substitute(const LibraryType& type, const LibraryBindings& bindings);

// Whether the term calls a random function, itself or through functions of the program.
bool is_random(const Program& program, const Term& term);

}  // namespace meld::check
