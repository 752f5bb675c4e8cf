// C++ text to an ELF object in memory, with the Clang and LLVM libraries; no process is started and no file is read.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"

namespace meld {

struct ObjectOptions {
    int optimisation = 2;
    std::string target_cpu;
};

// Compiles `cpp_text`, which sees the given headers (include path, text) and the freestanding integer headers and nothing
// else. The name appears in messages. Clang's complaints come back as an error with ExitCode::OurBug: emitted text is
// always meant to compile. May be called from several threads at once.
Result<std::string> compile_object(const std::string& cpp_text, const std::string& name,
                                   const std::vector<std::pair<std::string, std::string>>& headers, const ObjectOptions& options);

// The version of the Clang libraries in use, a part of the cache key.
std::string clang_version();

}  // namespace meld
