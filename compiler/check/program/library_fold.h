// Functions of the library as folds: a declared aggregate, an aggregate of a body or `custom addfloatlists`.
#pragma once

#include <optional>
#include <string>

#include "compiler/check/program/library.h"
#include "compiler/diagnostics/diagnostics.h"

namespace meld::check {

// The type that a fold of such values by this function has: it combines two values of that type into a third. None if the library has no
// such function of two arguments, or if they or the result are of other types.
std::optional<Type> type_of_library_fold(const std::string& name, const Type& value);

// A function of the program that calls this one; made at the first use with this type. No rule can name it. None as above.
std::optional<FunctionId> library_fold(Program& program, const std::string& name, const Type& value, Span span);

// The message about a function of the library that does not fold values of this type.
void refuse_library_fold(const LibraryFunction& f, const Type& value, Span span, diagnostics::Reporter& report);

}  // namespace meld::check
