// What types have to do with each other: which fit, what two of them have in common, and what a program's words name.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// Names of types: those of the language, and those that a program declares.
using TypeNames = std::map<std::string, Type>;
const TypeNames& language_types();

// The type that a program wrote; Type::Error, and a report, where a name in it is unknown. Names that the
// tree lost to syntax errors are not missed.
Type to_type(const syntax::Type& type, const TypeNames& names, const syntax::Tree& tree, diagnostics::Reporter& report);

// What to say of a word that is no type: the name of `known` that was probably meant, also in another language, or all types.
std::string help_for_type(const std::string& word, const std::vector<std::string>& known);

// Whether some part of it is not known yet: `list _` of an empty list.
bool has_unknown(const Type& type);

// The type of what may be the one or the other: unknown parts take the known ones, int and float make float, inside lists
// too. None if they do not go together.
std::optional<Type> join(const Type& a, const Type& b);

// Whether a value of the one is a value of the other as it is. What is unknown fits.
bool same(const Type& a, const Type& b);

// `type` with its unknown parts taken from `other`, where the two fit.
Type refined(const Type& type, const Type& other);

// Whether `<` has a meaning: not for sets and vectors, nor what contains one.
bool ordered(const Type& type);

}  // namespace meld::check
