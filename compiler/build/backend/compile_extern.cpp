// Files that are linked in are compiled as the module is, but may include the system's C headers.
#include "compiler/build/backend/compile_extern.h"

#include <fmt/format.h>
#include <llvm/Object/ObjectFile.h>
#include <llvm/TargetParser/Host.h>

#include "compiler/build/backend/run_clang.h"

namespace meld {
namespace {

// The headers that a C compiler brings itself; the rest is the C library's.
struct CompilerHeader {
    const char* name;
    const char* text;
};
constexpr CompilerHeader kCompilerHeaders[] = {
    {"stddef.h", R"(
typedef __SIZE_TYPE__ size_t;
typedef __PTRDIFF_TYPE__ ptrdiff_t;
#ifndef __cplusplus
typedef __WCHAR_TYPE__ wchar_t;
#undef NULL
#define NULL ((void*)0)
#else
#undef NULL
#define NULL __null
#endif
#undef offsetof
#define offsetof(type, member) __builtin_offsetof(type, member)
#undef __need_size_t
#undef __need_wchar_t
#undef __need_NULL
#undef __need_ptrdiff_t
)"},
    {"stdint.h", R"(#pragma once
typedef __INT8_TYPE__ int8_t;
typedef __INT16_TYPE__ int16_t;
typedef __INT32_TYPE__ int32_t;
typedef __INT64_TYPE__ int64_t;
typedef __UINT8_TYPE__ uint8_t;
typedef __UINT16_TYPE__ uint16_t;
typedef __UINT32_TYPE__ uint32_t;
typedef __UINT64_TYPE__ uint64_t;
typedef __INTPTR_TYPE__ intptr_t;
typedef __UINTPTR_TYPE__ uintptr_t;
#define INT32_MAX __INT32_MAX__
#define INT64_MAX __INT64_MAX__
#define INT32_MIN (-__INT32_MAX__ - 1)
#define INT64_MIN (-__INT64_MAX__ - 1)
#define UINT32_MAX __UINT32_MAX__
#define UINT64_MAX __UINT64_MAX__
)"},
    {"stdarg.h", R"(
#ifndef __GNUC_VA_LIST
#define __GNUC_VA_LIST
typedef __builtin_va_list __gnuc_va_list;
#endif
#ifdef __need___va_list
#undef __need___va_list
#else
typedef __builtin_va_list va_list;
#define va_start(list, last) __builtin_va_start(list, last)
#define va_end(list) __builtin_va_end(list)
#define va_arg(list, type) __builtin_va_arg(list, type)
#define va_copy(to, from) __builtin_va_copy(to, from)
#endif
)"},
    {"stdbool.h", R"(#pragma once
#ifndef __cplusplus
#define bool _Bool
#define true 1
#define false 0
#endif
)"},
};

std::vector<std::string> arguments(const std::string& path, bool cpp, const ObjectOptions& options) {
    // clang-format off
    std::vector<std::string> all = {
        "-triple", llvm::sys::getDefaultTargetTriple(), "-target-cpu", options.target_cpu, "-emit-obj",
        "-x", cpp ? "c++" : "c", cpp ? "-std=c++20" : "-std=gnu17", "-O" + std::to_string(options.optimisation),
        "-ffp-contract=off", "-mrelocation-model", "pic", "-pic-level", "2", "-nobuiltininc",
        "-I", kMemoryRoot, "-internal-isystem", kMemoryRoot + "compiler",
        "-internal-externc-isystem", "/usr/include/" + llvm::sys::getDefaultTargetTriple(),
        "-internal-externc-isystem", "/usr/include/x86_64-linux-gnu", "-internal-externc-isystem", "/usr/include/aarch64-linux-gnu",
        "-internal-externc-isystem", "/usr/include", "-main-file-name", path};
    // clang-format on
    if (cpp) all.insert(all.end(), {"-fno-rtti", "-nostdinc++"});
    all.push_back(path);
    return all;
}

std::vector<std::string> defined_symbols(const std::string& object) {
    std::vector<std::string> names;
    auto file = llvm::object::ObjectFile::createObjectFile(llvm::MemoryBufferRef(object, "extern"));
    if (!file) {
        llvm::consumeError(file.takeError());
        return names;
    }
    for (const llvm::object::SymbolRef& symbol : (*file)->symbols()) {
        auto flags = symbol.getFlags();
        auto name = symbol.getName();
        if (flags && name && !(*flags & llvm::object::SymbolRef::SF_Undefined) && (*flags & llvm::object::SymbolRef::SF_Global))
            names.push_back(name->str());
        if (!flags) llvm::consumeError(flags.takeError());
        if (!name) llvm::consumeError(name.takeError());
    }
    return names;
}

}  // namespace

Result<ExternObject> compile_extern(const ExternSource& source, const std::string& header, const ObjectOptions& options) {
    const bool cpp = !source.path.ends_with(".c");
    const std::string path = kMemoryRoot + source.path.substr(source.path.find_last_of('/') + 1);
    auto memory = llvm::makeIntrusiveRefCnt<llvm::vfs::InMemoryFileSystem>();
    const auto add = [&](const std::string& name, llvm::StringRef text) {
        memory->addFile(name, 0, llvm::MemoryBuffer::getMemBuffer(text, name, true));
    };
    for (const CompilerHeader& own : kCompilerHeaders) add(fmt::format("{}compiler/{}", kMemoryRoot, own.name), own.text);
    add(kMemoryRoot + "meld/extern.h", header);
    add(path, source.text);
    auto files = llvm::makeIntrusiveRefCnt<llvm::vfs::OverlayFileSystem>(llvm::vfs::getRealFileSystem());
    files->pushOverlay(memory);
    ClangRun run = run_clang(arguments(path, cpp, options), files);
    if (run.output.empty())
        return fail(fmt::format("{} does not compile:\n{}", source.path, run.messages),
                    "One file is compiled at a time; of its own project it sees <meld/extern.h> only", ExitCode::ProgramWrong);
    std::vector<std::string> symbols = defined_symbols(run.output);
    return ExternObject{std::move(run.output), std::move(symbols)};
}

}  // namespace meld
