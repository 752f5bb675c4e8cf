// Which names of a file mean what: found in its tokens, so that it works for half-written items and for what the checker refuses.
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

// The number of arguments where it is not known.
constexpr std::size_t kAnyArity = static_cast<std::size_t>(-1);

struct Symbol {
    SymbolKind kind = SymbolKind::Predicate;
    std::string name = {};
    // Of predicates and functions; else 0.
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

// What the files of a program declare: names with their numbers of arguments.
struct Declared {
    std::map<std::string, std::set<std::size_t>> predicates = {};
    std::map<std::string, std::set<std::size_t>> functions = {};
    std::set<std::string> constants = {};
};

// Adds what a file declares.
void add_declared(const FileTokens& file, Declared& declared);

// All occurrences in a file, in order. A predicate with a wrong number of arguments is taken for the one of that name.
std::vector<Occurrence> find_occurrences(const FileTokens& file, std::uint32_t index, const Declared& declared);

// The text between the brackets of the call at this name; kAnyArity where the closing one is missing.
std::size_t count_arguments(const FileTokens& file, std::size_t name);

}  // namespace meld::lsp
