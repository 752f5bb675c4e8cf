// The part of the build that needs Clang, in a separate shared library that is opened only to compile: loading Clang takes 20 ms, and most
// starts of meldc find their module in the cache.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"

namespace meld {

// The number of bytes of emitted text from which a module counts as long. Below it -O2 takes some 0.2 s, which leaves little to gain; the
// longest examples have 80,000.
inline constexpr std::size_t kLongModule = 40'000;

struct ObjectOptions {
    int optimisation = 2;
    std::string target_cpu;
};

// A C or C++ file whose functions a program calls.
struct ExternSource {
    std::string path;
    std::string text;
};
struct ExternObject {
    std::string object;                // ELF
    std::vector<std::string> symbols;  // The symbols that it defines for others.
};

// What the pieces of a very long module have in common: declarations, which Clang has parsed already.
struct SharedPart {
    std::string text;
    std::string parsed;  // Of compile_shared().
};
// What is done for code. All: the passes of LLVM for the level of optimisation. Few: those that matter most. Quick: the same, and code
// that is generated instruction by instruction, in a fifth of the time. None: such code without passes, for tables of data.
enum class CodePasses { All, Few, Quick, None };

// The functions of the library; compile_object.h, compile_piece.h, compile_extern.h and link_module.h describe them.
struct Backend {
    Result<std::vector<std::string>> (*compile_object)(const std::string& cpp_text, const std::string& name,
                                                       const std::vector<std::pair<std::string, std::string>>& headers,
                                                       const ObjectOptions& options);
    Result<std::string> (*compile_shared)(const std::string& text, const std::vector<std::pair<std::string, std::string>>& headers,
                                          const ObjectOptions& options);
    Result<std::string> (*compile_piece)(const std::string& text, const SharedPart& shared,
                                         const std::vector<std::pair<std::string, std::string>>& headers, CodePasses passes,
                                         const ObjectOptions& options);
    Result<ExternObject> (*compile_extern)(const ExternSource& source, const std::string& header, const ObjectOptions& options);
    Result<void> (*link_module)(const std::vector<std::string>& object_paths, const std::string& output_path);
};

inline constexpr const char* kBackendLibrary = "libmeld_backend.so";
inline constexpr const char* kBackendEntry = "meld_backend";

}  // namespace meld

// The library's only exported function.
extern "C" const meld::Backend* meld_backend();
