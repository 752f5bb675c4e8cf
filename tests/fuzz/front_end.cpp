#include "tests/fuzz/front_end.h"

#include "compiler/check/check.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/front/embedded.h"
#include "compiler/lint/lint.h"
#include "compiler/syntax/parse.h"
#include "runtime/base/assert.h"

namespace meld::fuzz {

std::optional<check::Program> front_end(std::string text) {
    source::FileSet files;
    diagnostics::Reporter report;
    const std::uint32_t prelude = files.add("stdlib/prelude.meld", front::kPrelude);
    // A path nowhere near a file, so that includes find nothing but themselves.
    const std::uint32_t file = files.add("/nowhere/fuzz.meld", std::move(text));
    syntax::Tree tree = syntax::parse(files, prelude, report);
    MELD_CHECK(!report.has_errors(), "the prelude is wrong");
    syntax::Tree program_tree = syntax::parse(files, file, report);
    syntax::print(program_tree);
    tree.append(std::move(program_tree));
    check::separate_modules(tree, prelude + 1, report);
    const std::vector<diagnostics::Diagnostic> unused_names = lint::find_unused_names(files, tree, file);
    check::Program program = check::check(files, tree, prelude + 1, report);
    lint::lint(program, file, unused_names, {}, report);
    diagnostics::render_text(files, report.sorted(), diagnostics::Colour::Always);
    diagnostics::render_json(files, report.sorted());
    if (report.has_errors()) return std::nullopt;
    check::print(program);
    program.name = "fuzz";
    return program;
}

}  // namespace meld::fuzz
