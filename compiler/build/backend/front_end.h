// What Clang's front end is given to compile emitted text: its arguments, and a file system that exists in memory only.
#pragma once

#include <llvm/ADT/IntrusiveRefCntPtr.h>
#include <llvm/ADT/StringRef.h>
#include <llvm/Support/VirtualFileSystem.h>

#include <string>
#include <utility>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "runtime/base/error.h"

namespace meld {

// The options as clang's compiler proper takes them. The caller adds what is its own, and `source` at the end.
std::vector<std::string> front_end_arguments(const std::string& source, const ObjectOptions& options);

// The headers that a module may include: the given ones (include path, text) and the freestanding ones. They are not copied.
llvm::IntrusiveRefCntPtr<llvm::vfs::InMemoryFileSystem> in_memory_files(const std::vector<std::pair<std::string, std::string>>& headers);
// Adds a file, whose text is not copied and ends with a zero byte.
void add_file(llvm::vfs::InMemoryFileSystem& files, const std::string& path, llvm::StringRef text);

// The error of emitted text that Clang refuses.
tl::unexpected<Error> text_does_not_compile(const std::string& what, const std::string& messages);

}  // namespace meld
