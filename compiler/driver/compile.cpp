#include "compiler/driver/compile.h"

#include <filesystem>

#include "compiler/build/build.h"
#include "compiler/check/check.h"
#include "compiler/driver/embedded.h"
#include "compiler/emit/emit.h"
#include "compiler/plan/plan.h"
#include "compiler/syntax/parse.h"
#include "runtime/abi/module_abi.h"

namespace meld::driver {

namespace {

Result<std::string> build(const std::string& cpp, const plan::Plan& plan, const CompileOptions& options) {
    BuildOptions build_options;
    if (!options.cache_dir.empty()) build_options.cache_dir = options.cache_dir;
    build_options.optimisation = options.optimisation;
    build_options.headers = module_headers();
    build_options.schema_hash = emit::schema_hash(plan);
    build_options.abi_version = kAbiVersion;
    return build_module(cpp, plan.program.name, build_options);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> module_headers() {
    return {{"meld/module_eval.h", kModuleEval}, {"runtime/abi/module_library.h", kModuleLibrary}, {"runtime/abi/module_values.h", kModuleValues}, {"runtime/abi/module_abi.h", kModuleAbi}, {"runtime/abi/geometry_abi.h", kGeometryAbi}};
}

std::optional<Stage> stage_named(const std::string& name) {
    if (name == "tokens") return Stage::Tokens;
    if (name == "ast") return Stage::Tree;
    if (name == "program") return Stage::Program;
    if (name == "plan") return Stage::Plan;
    if (name == "cpp") return Stage::Cpp;
    if (name == "module") return Stage::Module;
    return std::nullopt;
}

Result<void> compile(const std::string& path, const CompileOptions& options, Compilation& out) {
    const std::uint32_t prelude = out.files.add("stdlib/prelude.meld", kPrelude);
    const Result<std::uint32_t> file = out.files.read(path);
    if (!file) return tl::unexpected<Error>(file.error());
    if (options.last == Stage::Tokens) {
        out.result = syntax::print_tokens(out.files, *file, out.report);
        return {};
    }
    syntax::Tree tree = syntax::parse(out.files, prelude, out.report);
    syntax::Tree program_tree = syntax::parse(out.files, *file, out.report, {options.library_paths});
    if (options.last == Stage::Tree) {
        out.result = syntax::print(program_tree);
        return {};
    }
    for (syntax::Item& item : program_tree.items) tree.items.push_back(std::move(item));
    tree.lost = std::move(program_tree.lost);
    tree.lost_file = program_tree.lost_file;

    // Items that were read are checked even where others were not: all mistakes in one run.
    check::Program program = check::check(out.files, tree, prelude + 1, out.report);
    if (out.report.has_errors()) return {};
    program.name = std::filesystem::path(path).stem().string();
    program.source_text = out.files.file(*file).text();
    if (options.last == Stage::Program) {
        out.result = check::print(program);
        return {};
    }
    const plan::Plan plan = plan::make_plan(std::move(program));
    if (options.last == Stage::Plan) out.result = plan::print(plan);
    if (options.last == Stage::Explain) out.result = plan::explain(plan);
    if (!out.result.empty()) return {};
    std::string cpp = emit::emit_module(plan);
    if (options.last == Stage::Cpp) {
        out.result = std::move(cpp);
        return {};
    }
    Result<std::string> module = build(cpp, plan, options);
    if (!module) return tl::unexpected<Error>(module.error());
    out.result = *module;
    return {};
}

}  // namespace meld::driver
