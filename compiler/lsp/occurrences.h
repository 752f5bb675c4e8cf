// The meanings of the names in a file: found in its tokens, so that it works for unfinished items and for items that the check rejects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "compiler/lsp/items.h"

namespace meld::lsp {

enum class SymbolKind { Predicate, Constant, Function, Variable, Include };

// The number of arguments if it is unknown.
constexpr std::size_t kAnyArity = static_cast<std::size_t>(-1);

struct Symbol {
    SymbolKind kind = SymbolKind::Predicate;
    std::string name = {};
    // For predicates and functions; otherwise 0.
    std::size_t arity = 0;
    // Variables belong to one item of one file.
    std::uint32_t file = 0;
    std::size_t item = 0;

    auto operator<=>(const Symbol&) const = default;
};

// Derives: in a head. Reads: in a body.
enum class Role { Declaration, Derives, Reads, Uses };

struct Occurrence {
    Symbol symbol;
    Role role = Role::Uses;
    source::Span span = {};
    std::size_t item = 0;
};

// The declarations in the files of a program: names with their numbers of arguments.
struct Declared {
    std::map<std::string, std::set<std::size_t>> predicates = {};
    std::map<std::string, std::set<std::size_t>> functions = {};
    std::set<std::string> constants = {};
};

// Adds what a file declares.
void add_declared(const FileTokens& file, Declared& declared);

// All occurrences in a file, in order. A predicate with a wrong number of arguments counts as the one with that name.
std::vector<Occurrence> find_occurrences(const FileTokens& file, std::uint32_t index, const Declared& declared);

// The text between the brackets of the call at this name; kAnyArity if the closing one is missing.
std::size_t count_arguments(const FileTokens& file, std::size_t name);

}  // namespace meld::lsp
