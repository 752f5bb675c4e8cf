// Drives Clang's front end and LLVM's code generator over a file system that exists in memory only.
#include "compiler/build/backend/compile_object.h"

#include <fmt/format.h>
#include <llvm/TargetParser/Host.h>

#include "compiler/build/backend/freestanding_headers.h"
#include "compiler/build/backend/halves.h"
#include "compiler/build/backend/run_clang.h"

namespace meld {
namespace {

// The options as clang's compiler proper takes them; its defaults already mean no exceptions and no errno from <math.h>.
std::vector<std::string> front_end_arguments(const std::string& source, const ObjectOptions& options) {
    // clang-format off
    std::vector<std::string> arguments = {
        "-triple", llvm::sys::getDefaultTargetTriple(), "-target-cpu", options.target_cpu,
        "-emit-obj", "-x", "c++", "-std=c++20", "-O" + std::to_string(options.optimisation),
        "-ffp-contract=off", "-fno-rtti", "-mrelocation-model", "pic", "-pic-level", "2",
        "-fvisibility-inlines-hidden", "-nostdsysteminc", "-nobuiltininc", "-nostdinc++",
        "-I", kMemoryRoot, "-isystem", kMemoryRoot + "freestanding",
        // Expressions nest up to 300 deep, and each level takes up to five brackets.
        "-fbracket-depth", "4096", "-w", "-main-file-name", source,
        // Loops here are over a dozen ports or a handful of rows: unrolled they are only larger, and take a third longer to compile.
        "-fno-unroll-loops", options.optimisation < 2 ? "-DMELD_STEP=[[gnu::noinline]]" : "-DMELD_STEP="};
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
    for (const FreestandingHeader& header : kFreestandingHeaders)
        add(fmt::format("{}freestanding/{}", kMemoryRoot, header.name), header.text);
    for (const auto& [path, text] : headers) add(kMemoryRoot + path, text);
    add(source, cpp_text);
    return files;
}

}  // namespace

Result<std::vector<std::string>> compile_object(const std::string& cpp_text, const std::string& name,
                                                const std::vector<std::pair<std::string, std::string>>& headers,
                                                const ObjectOptions& options) {
    const std::string source = kMemoryRoot + name + ".cpp";
    const bool halved = cpp_text.size() >= kLongModule && options.optimisation == 1;  // Otherwise there are no steps, or there is no gain.
    std::vector<std::string> arguments = front_end_arguments(source, options);
    if (halved) arguments.push_back("-disable-llvm-passes");
    ClangRun run = run_clang(arguments, in_memory_files(source, cpp_text, headers), halved ? ClangOutput::Bitcode : ClangOutput::Object);
    if (run.output.empty())
        return fail(fmt::format("the C++ generated for {} does not compile:\n{}", name, run.messages),
                    "This is a bug in Claymeld; please report it with the program", ExitCode::OurBug);
    if (halved) return compile_halves(run.output, options);
    return std::vector<std::string>{std::move(run.output)};
}

}  // namespace meld
