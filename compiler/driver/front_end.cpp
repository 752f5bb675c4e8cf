// The stages before planning, one function each.
#include "compiler/driver/front_end.h"

#include <filesystem>
#include <utility>

#include "compiler/check/check.h"
#include "compiler/driver/embedded.h"
#include "compiler/driver/question.h"
#include "compiler/lint/lint.h"
#include "runtime/base/assert.h"

namespace meld::driver {

namespace {

std::vector<syntax::Library> libraries() {
    std::vector<syntax::Library> result;
    for (const EmbeddedText& library : kLibraries) result.push_back({library.name, library.text});
    return result;
}

}  // namespace

std::uint32_t add_prelude(source::FileSet& files) {
    MELD_EXPECT(files.count() == 0);
    files.add("stdlib/prelude.meld", kPrelude);
    return 1;
}

ParsedProgram parse_program(source::FileSet& files, std::uint32_t file, std::uint32_t prelude_files, diagnostics::Reporter& report,
                            const syntax::ParseOptions& options) {
    ParsedProgram parsed;
    for (std::uint32_t i = 0; i < prelude_files; ++i) parsed.prelude.append(syntax::parse(files, i, report));
    syntax::ParseOptions with_libraries = options;
    with_libraries.libraries = libraries();
    parsed.program = syntax::parse(files, file, report, with_libraries);
    return parsed;
}

check::Program check_program(const source::FileSet& files, std::uint32_t file, std::uint32_t prelude_files, ParsedProgram parsed,
                             diagnostics::Reporter& report) {
    syntax::Tree tree = std::move(parsed.prelude);
    tree.append(std::move(parsed.program));
    check::separate_modules(tree, prelude_files, report);
    const std::vector<diagnostics::Diagnostic> unused_names = lint::find_unused_names(files, tree, file);
    check::Program program = check::check(files, tree, prelude_files, report);
    add_witness(program);
    lint::lint(program, file, unused_names, report);
    program.name = std::filesystem::path(files.file(file).path()).stem().string();
    program.source_text = files.file(file).text();
    return program;
}

}  // namespace meld::driver
