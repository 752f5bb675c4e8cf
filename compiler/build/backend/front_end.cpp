// Arguments and files of Clang's front end.
#include "compiler/build/backend/front_end.h"

#include <fmt/format.h>
#include <llvm/Support/MemoryBuffer.h>
#include <llvm/TargetParser/Host.h>

#include "compiler/build/backend/freestanding_headers.h"
#include "compiler/build/backend/run_clang.h"

namespace meld {

// The options as clang's compiler proper takes them; its defaults already mean no exceptions and no errno from <math.h>.
std::vector<std::string> front_end_arguments(const std::string& source, const ObjectOptions& options) {
    // clang-format off
    return {
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
}

void add_file(llvm::vfs::InMemoryFileSystem& files, const std::string& path, llvm::StringRef text) {
    files.addFile(path, 0, llvm::MemoryBuffer::getMemBuffer(text, path, true));
}

llvm::IntrusiveRefCntPtr<llvm::vfs::InMemoryFileSystem> in_memory_files(const std::vector<std::pair<std::string, std::string>>& headers) {
    auto files = llvm::makeIntrusiveRefCnt<llvm::vfs::InMemoryFileSystem>();
    for (const FreestandingHeader& header : kFreestandingHeaders)
        add_file(*files, fmt::format("{}freestanding/{}", kMemoryRoot, header.name), header.text);
    for (const auto& [path, text] : headers) add_file(*files, kMemoryRoot + path, text);
    return files;
}

tl::unexpected<Error> text_does_not_compile(const std::string& what, const std::string& messages) {
    return fail(fmt::format("the C++ generated for {} does not compile:\n{}", what, messages),
                "This is a bug in Claymeld; please report it with the program", ExitCode::OurBug);
}

}  // namespace meld
