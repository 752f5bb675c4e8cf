// C++ text to a module: a shared object in a cache that is addressed by content.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "compiler/build/backend/backend.h"
#include "compiler/build/module_cache.h"
#include "runtime/base/error.h"

namespace meld {

struct BuildOptions {
    std::string cache_dir = default_cache_dir();
    int optimisation = 2;  // 0 to 3, as in -O2
    // What the text may include besides <cstdint>, <cstddef> and <cstring>: include path and text.
    std::vector<std::pair<std::string, std::string>> headers = {};
    // Files to link in, the header they may include as <meld/extern.h>, and the functions that they must define.
    std::vector<ExternSource> linked = {};
    std::string extern_header = {};
    std::vector<std::string> externs = {};
    std::uint64_t schema_hash = 0;
    std::uint32_t abi_version = 0;
    CacheLimits limits = {};
};

// A very long text in parts, which are compiled in pieces of some parts each. A piece is in the cache by itself, so that after a change
// only those are compiled whose text differs.
struct TextPart {
    std::string name;  // Decides which parts are one piece: the same after a change in other parts.
    std::string text;
    CodePasses passes = CodePasses::Few;
    bool alone = false;  // Changes often.
};
struct TextInParts {
    std::string shared;  // Declarations that all parts see.
    std::vector<TextPart> parts;
    // One part in so many is the last of its piece, and a piece has at most twice as many. The declarations take some ten milliseconds
    // of each piece, a part about as much.
    std::size_t parts_of_piece = 8;
};

// Compiles and links the text and returns the path of the module, from the cache if the same text was built with the same options before.
// The name appears in Clang's messages and must be usable as a file name. Errors: if the text is not C++, that is our bug,
// ExitCode::OurBug; a linked file that does not compile, or an extern that no file defines, is the program's error; a cache that cannot be
// written is ExitCode::UsageOrWorld. Any number of processes and threads may build the same module at the same time. Costs a few tenths of
// a millisecond if cached.
Result<std::string> build_module(const std::string& cpp_text, const std::string& name, const BuildOptions& options);

// The same of a text in parts, on as many threads as there are cores.
Result<std::string> build_module(const TextInParts& text, const std::string& name, const BuildOptions& options);

}  // namespace meld
