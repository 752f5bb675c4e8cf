#include "tests/reference/programs/compiled.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "compiler/check/check.h"
#include "compiler/driver/compile.h"
#include "compiler/front/embedded.h"
#include "compiler/syntax/parse.h"
#include "tests/reference/programs/draft.h"

namespace meld::reference {

namespace {

std::string messages(const source::FileSet& files, const diagnostics::Reporter& report) {
    std::vector<diagnostics::Diagnostic> errors;
    for (const diagnostics::Diagnostic& d : report.sorted())
        if (diagnostics::info(d.kind).severity == diagnostics::Severity::Error) errors.push_back(d);
    return diagnostics::render_text(files, errors, diagnostics::Colour::Never);
}

}  // namespace

Result<check::Program> checked(const std::string& text) {
    source::FileSet files;
    diagnostics::Reporter report;
    const std::uint32_t prelude = files.add("stdlib/prelude.meld", front::kPrelude);
    const std::uint32_t file = files.add("program.meld", text);
    syntax::Tree tree = syntax::parse(files, prelude, report), own = syntax::parse(files, file, report);
    tree.append(std::move(own));
    if (report.has_errors()) return fail(messages(files, report));
    check::separate_modules(tree, prelude + 1, report);
    check::Program program = check::check(files, tree, prelude + 1, report, goes_far(text) ? check::Worlds::Graphs : check::Worlds::Any);
    if (report.has_errors()) return fail(messages(files, report));
    return program;
}

Workshop::Workshop(Level the_level) : level(the_level) {
    std::string name = (std::filesystem::temp_directory_path() / "meld-reference-XXXXXX").string();
    folder_ = mkdtemp(name.data()) == nullptr ? "." : name;
}

Workshop::~Workshop() {
    std::error_code ignored;
    if (folder_ != ".") std::filesystem::remove_all(folder_, ignored);
}

Result<Module> Workshop::module(const std::string& text, bool by_links) {
    const std::string path = folder_ + "/program.meld";
    std::ofstream(path) << text;
    driver::Compilation compilation;
    driver::CompileOptions options{.cache_dir = folder_ + "/cache"};
    if (level == Level::Quick) options.optimisation = 0;
    options.plan.links = by_links;
    options.plan.checked = true;
    options.worlds = goes_far(text) ? check::Worlds::Graphs : check::Worlds::Any;
    const Result<void> done = driver::compile(path, options, compilation);
    if (!done) return tl::unexpected<Error>(done.error());
    if (compilation.report.has_errors()) return fail(messages(compilation.files, compilation.report));
    Result<Module> module = load_module(compilation.result, kAbiVersion);
    // It is hardly ever asked for again, and looking through a large cache takes long.
    std::error_code ignored;
    std::filesystem::remove(compilation.result, ignored);
    return module;
}

}  // namespace meld::reference
