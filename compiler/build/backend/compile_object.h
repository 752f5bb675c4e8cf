// C++ text to ELF objects in memory, with the Clang and LLVM libraries; no process is started and no file is read.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Compiles `cpp_text`, which sees the given headers (include path, text) and the freestanding integer headers and nothing
// else. The name appears in messages. Clang's complaints come back as an error with ExitCode::OurBug: emitted text is
// always meant to compile. A long text (kLongModule) becomes two objects at -O1, made side by side; all are to be linked.
// May be called from several threads at once.
Result<std::vector<std::string>> compile_object(const std::string& cpp_text, const std::string& name,
                                                const std::vector<std::pair<std::string, std::string>>& headers,
                                                const ObjectOptions& options);

}  // namespace meld
