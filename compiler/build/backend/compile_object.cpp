// Drives Clang's front end and LLVM's code generator over a file system that exists in memory only.
#include "compiler/build/backend/compile_object.h"

#include "compiler/build/backend/front_end.h"
#include "compiler/build/backend/halves.h"
#include "compiler/build/backend/run_clang.h"

namespace meld {

Result<std::vector<std::string>> compile_object(const std::string& cpp_text, const std::string& name,
                                                const std::vector<std::pair<std::string, std::string>>& headers,
                                                const ObjectOptions& options) {
    const std::string source = kMemoryRoot + name + ".cpp";
    const bool halved = cpp_text.size() >= kLongModule && options.optimisation == 1;  // Otherwise there are no steps, or there is no gain.
    std::vector<std::string> arguments = front_end_arguments(source, options);
    if (halved) arguments.push_back("-disable-llvm-passes");
    arguments.push_back(source);
    auto files = in_memory_files(headers);
    add_file(*files, source, cpp_text);
    ClangRun run = run_clang(arguments, files, halved ? ClangOutput::Bitcode : ClangOutput::Object);
    if (run.output.empty()) return text_does_not_compile(name, run.messages);
    if (halved) return compile_halves(run.output, options);
    return std::vector<std::string>{std::move(run.output)};
}

}  // namespace meld
