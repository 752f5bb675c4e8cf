// One run of Clang's front end and LLVM's code generator over given arguments and files.
#pragma once

#include <clang/Frontend/FrontendAction.h>
#include <llvm/ADT/IntrusiveRefCntPtr.h>
#include <llvm/Support/VirtualFileSystem.h>

#include <string>
#include <vector>

namespace meld {

// All files in memory are below this folder.
inline const std::string kMemoryRoot = "/claymeld/";

enum class ClangOutput { Object, Bitcode };

struct ClangRun {
    std::string output;  // Empty: it did not compile.
    std::string messages;
};

// Takes the action with these arguments, and returns whether it did; messages are appended. `bytes` is where its output goes, if any.
bool run_clang_action(const std::vector<std::string>& arguments, llvm::IntrusiveRefCntPtr<llvm::vfs::FileSystem> files,
                      clang::FrontendAction& action, std::string& messages, llvm::SmallVectorImpl<char>& bytes);

// Compiles like Clang's compiler proper with these arguments. May be called from several threads at once.
ClangRun run_clang(const std::vector<std::string>& arguments, llvm::IntrusiveRefCntPtr<llvm::vfs::FileSystem> files,
                   ClangOutput output = ClangOutput::Object);

}  // namespace meld
