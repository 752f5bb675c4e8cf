// C++ text to ELF objects in memory, with the Clang and LLVM libraries; no process is started and no file is read.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// Compiles `cpp_text`, which sees only the given headers (include path, text) and the freestanding integer headers. The name appears in
// messages. Errors that Clang reports are returned with ExitCode::OurBug, because emitted text should always compile. A long text
// (kLongModule) becomes two objects at -O1, compiled in parallel; both are to be linked. May be called from several threads at once.
Result<std::vector<std::string>> compile_object(const std::string& cpp_text, const std::string& name,
                                                const std::vector<std::pair<std::string, std::string>>& headers,
                                                const ObjectOptions& options);

}  // namespace meld
