// Drives Clang's front end and LLVM's code generator over a file system that exists in memory only.
#include "compiler/build/backend/compile_object.h"

#include <clang/Basic/Diagnostic.h>
#include <clang/Basic/FileManager.h>
#include <clang/CodeGen/CodeGenAction.h>
#include <clang/Frontend/CompilerInstance.h>
#include <clang/Frontend/CompilerInvocation.h>
#include <clang/Frontend/TextDiagnosticPrinter.h>
#include <fmt/format.h>
#include <llvm/Support/TargetSelect.h>
#include <llvm/Support/VirtualFileSystem.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/TargetParser/Host.h>

#include <mutex>

#include "compiler/build/backend/freestanding_headers.h"

namespace meld {
namespace {

// All files of a compilation are below this folder of the in-memory file system.
const std::string kRoot = "/claymeld/";

void initialise_native_target() {
    static std::once_flag once;
    std::call_once(once, [] {
        llvm::InitializeNativeTarget();
        llvm::InitializeNativeTargetAsmPrinter();
        llvm::InitializeNativeTargetAsmParser();
    });
}

// The options as clang's compiler proper takes them; its defaults already mean no exceptions and no errno from <math.h>.
std::vector<std::string> front_end_arguments(const std::string& source, const ObjectOptions& options) {
    // clang-format off
    std::vector<std::string> arguments = {
        "-triple", llvm::sys::getDefaultTargetTriple(), "-target-cpu", options.target_cpu,
        "-emit-obj", "-x", "c++", "-std=c++20", "-O" + std::to_string(options.optimisation),
        "-ffp-contract=off", "-fno-rtti", "-mrelocation-model", "pic", "-pic-level", "2",
        "-fvisibility-inlines-hidden", "-nostdsysteminc", "-nobuiltininc", "-nostdinc++", "-I", kRoot, "-isystem", kRoot + "freestanding",
        "-w", "-main-file-name", source,
        // Loops here are over a dozen ports or a handful of rows: unrolled they are only larger, and take a third longer to compile.
        "-fno-unroll-loops"};
    // clang-format on
    arguments.push_back(source);
    return arguments;
}

llvm::IntrusiveRefCntPtr<llvm::vfs::FileSystem> in_memory_files(const std::string& source, const std::string& cpp_text,
                                                                const std::vector<std::pair<std::string, std::string>>& headers) {
    auto files = llvm::makeIntrusiveRefCnt<llvm::vfs::InMemoryFileSystem>();
    const auto add = [&](const std::string& path, llvm::StringRef text) {
        files->addFile(path, 0, llvm::MemoryBuffer::getMemBuffer(text, path, true));
    };
    for (const FreestandingHeader& header : kFreestandingHeaders) add(fmt::format("{}freestanding/{}", kRoot, header.name), header.text);
    for (const auto& [path, text] : headers) add(kRoot + path, text);
    add(source, cpp_text);
    return files;
}

}  // namespace

Result<std::string> compile_object(const std::string& cpp_text, const std::string& name,
                                   const std::vector<std::pair<std::string, std::string>>& headers, const ObjectOptions& options) {
    initialise_native_target();
    const std::string source = kRoot + name + ".cpp";
    std::string messages;
    llvm::raw_string_ostream message_stream(messages);
    auto diagnostic_options = llvm::makeIntrusiveRefCnt<clang::DiagnosticOptions>();
    diagnostic_options->ShowPresumedLoc = true;  // follow #line to the .meld file
    clang::TextDiagnosticPrinter printer(message_stream, diagnostic_options.get());
    clang::DiagnosticsEngine diagnostics(llvm::makeIntrusiveRefCnt<clang::DiagnosticIDs>(), diagnostic_options, &printer, false);

    const std::vector<std::string> arguments = front_end_arguments(source, options);
    std::vector<const char*> pointers;
    for (const std::string& argument : arguments) pointers.push_back(argument.c_str());
    auto invocation = std::make_shared<clang::CompilerInvocation>();
    bool succeeded = clang::CompilerInvocation::CreateFromArgs(*invocation, pointers, diagnostics);

    llvm::SmallVector<char, 0> object;
    if (succeeded) {
        clang::CompilerInstance compiler;
        compiler.setInvocation(invocation);
        compiler.createDiagnostics(&printer, false);
        compiler.setVerboseOutputStream(std::make_unique<llvm::raw_null_ostream>());  // "1 error generated."
        compiler.createFileManager(in_memory_files(source, cpp_text, headers));
        compiler.setOutputStream(std::make_unique<llvm::raw_svector_ostream>(object));
        clang::EmitObjAction action;
        succeeded = compiler.ExecuteAction(action);
    }
    if (!succeeded || object.empty())
        return fail(fmt::format("the C++ generated for {} does not compile:\n{}", name, messages),
                    "This is a bug in Claymeld; please report it with the program", ExitCode::OurBug);
    return std::string(object.begin(), object.end());
}

}  // namespace meld
