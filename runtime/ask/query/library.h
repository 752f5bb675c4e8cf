// The functions of the library as a question calls them: those of runtime/module/kernel/library.h, by name.
#pragma once

#include <string_view>

#include "runtime/module/abi/module_abi.h"

namespace meld::inspect {

// The type is that of the elements, for functions that compare them. The caller has arguments of the types that the function takes.
using LibraryCall = Value (*)(Eval& e, const TypeInfo* types, u16 type, const Value* arguments);

// The function that check::LibraryFunction::cpp names; `real` chooses the one for floats where there is one for each type of numbers.
// Null: there is none, or it draws random numbers.
LibraryCall library_call(std::string_view cpp, bool real);

}  // namespace meld::inspect
