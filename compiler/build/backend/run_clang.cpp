#include "compiler/build/backend/run_clang.h"

#include <clang/Basic/Diagnostic.h>
#include <clang/Basic/FileManager.h>
#include <clang/CodeGen/CodeGenAction.h>
#include <clang/Frontend/CompilerInstance.h>
#include <clang/Frontend/CompilerInvocation.h>
#include <clang/Frontend/TextDiagnosticPrinter.h>
#include <llvm/Support/TargetSelect.h>
#include <llvm/Support/raw_ostream.h>

#include <mutex>

namespace meld {
namespace {

void initialise_native_target() {
    static std::once_flag once;
    std::call_once(once, [] {
        llvm::InitializeNativeTarget();
        llvm::InitializeNativeTargetAsmPrinter();
        llvm::InitializeNativeTargetAsmParser();
    });
}

}  // namespace

bool run_clang_action(const std::vector<std::string>& arguments, llvm::IntrusiveRefCntPtr<llvm::vfs::FileSystem> files,
                      clang::FrontendAction& action, std::string& messages, llvm::SmallVectorImpl<char>& bytes) {
    initialise_native_target();
    llvm::raw_string_ostream message_stream(messages);
    auto diagnostic_options = llvm::makeIntrusiveRefCnt<clang::DiagnosticOptions>();
    diagnostic_options->ShowPresumedLoc = true;  // follow #line to the .meld file
    clang::TextDiagnosticPrinter printer(message_stream, diagnostic_options.get());
    clang::DiagnosticsEngine diagnostics(llvm::makeIntrusiveRefCnt<clang::DiagnosticIDs>(), diagnostic_options, &printer, false);

    std::vector<const char*> pointers;
    for (const std::string& argument : arguments) pointers.push_back(argument.c_str());
    auto invocation = std::make_shared<clang::CompilerInvocation>();
    if (!clang::CompilerInvocation::CreateFromArgs(*invocation, pointers, diagnostics)) return false;
    clang::CompilerInstance compiler;
    compiler.setInvocation(invocation);
    compiler.createDiagnostics(&printer, false);
    compiler.setVerboseOutputStream(std::make_unique<llvm::raw_null_ostream>());  // "1 error generated."
    compiler.createFileManager(std::move(files));
    compiler.setOutputStream(std::make_unique<llvm::raw_svector_ostream>(bytes));
    return compiler.ExecuteAction(action);
}

ClangRun run_clang(const std::vector<std::string>& arguments, llvm::IntrusiveRefCntPtr<llvm::vfs::FileSystem> files, ClangOutput output) {
    std::unique_ptr<clang::CodeGenAction> action;
    if (output == ClangOutput::Object)
        action = std::make_unique<clang::EmitObjAction>();
    else
        action = std::make_unique<clang::EmitBCAction>();
    ClangRun out;
    llvm::SmallVector<char, 0> bytes;
    if (run_clang_action(arguments, std::move(files), *action, out.messages, bytes)) out.output.assign(bytes.begin(), bytes.end());
    return out;
}

}  // namespace meld
