// Relations between types: which fit each other, what two of them have in common, and which types a program's words name.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// Names of types: those of the language, and those that a program declares.
using TypeNames = std::map<std::string, Type>;
const TypeNames& language_types();

// The type that a program names; Type::Error, and a report, if a name in it is unknown. Names that the tree lost to syntax errors are not
// reported.
Type to_type(const syntax::Type& type, const TypeNames& names, const syntax::Tree& tree, diagnostics::Reporter& report);

// The help for a word that is not a type: the name of `known` that was probably meant, also in another language, or all types.
void suggest_type(diagnostics::Diagnostic& d, const std::string& word, const std::vector<std::string>& known);

// Whether some part of it is not known yet: `list _` of an empty list.
bool has_unknown(const Type& type);

// The common type of two: unknown parts take the known ones, int and float make float, also inside lists. None if they do not fit.
std::optional<Type> join(const Type& a, const Type& b);

// Whether a value of one type is also a value of the other without conversion. Unknown types fit.
bool same(const Type& a, const Type& b);

// `type` with its unknown parts taken from `other`, where the two fit.
Type refined(const Type& type, const Type& other);

// Whether `sum` is defined, and which types to sum instead.
bool summable(const Type& type);
inline constexpr const char* kSummable = "sum an int, a float, a vec3 or a list of floats";

// Whether `<` is defined: not for sets and vectors, or types that contain them.
bool ordered(const Type& type);

}  // namespace meld::check
