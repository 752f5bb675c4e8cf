#include "compiler/driver/compile.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <mutex>
#include <utility>

#include "compiler/build/build.h"
#include "compiler/driver/embedded.h"
#include "compiler/emit/emit.h"
#include "compiler/front/front_end.h"
#include "compiler/plan/plan.h"
#include "compiler/syntax/parse.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::driver {

namespace {

constexpr std::uint64_t kMaxLinked_bytes = std::uint64_t{64} << 20;

Result<std::string> read_linked(const std::string& path) {
    static constexpr std::string_view endings[] = {".c", ".cc", ".cpp", ".cxx"};
    if (std::none_of(std::begin(endings), std::end(endings), [&](std::string_view ending) { return path.ends_with(ending); }))
        return fail(fmt::format("cannot link {}: it is not a C or C++ file", path), "Link files that end in .c or .cpp");
    return read_input(path, kMaxLinked_bytes);
}

// The files with other programs. Errors: one cannot be read, or is named twice; there are too many.
Result<std::vector<std::uint32_t>> read_programs(const std::string& path, const std::vector<std::string>& others, source::FileSet& files) {
    if (others.size() >= syntax::kMaxPrograms)
        return fail(fmt::format("there are {} programs of one ensemble, and the maximum is {}", others.size() + 1, syntax::kMaxPrograms));
    std::vector<std::uint32_t> read;
    for (std::size_t i = 0; i < others.size(); ++i) {
        const auto same = [&](const std::string& other) {
            std::error_code error;
            return other == others[i] || std::filesystem::equivalent(other, others[i], error);
        };
        const auto before = others.begin() + static_cast<std::ptrdiff_t>(i);
        if (same(path) || std::any_of(others.begin(), before, same))
            return fail(fmt::format("{} is named twice among the programs of the ensemble", others[i]), "Name each once");
        const Result<std::uint32_t> file = files.read(others[i]);
        if (!file) return tl::unexpected<Error>(file.error());
        read.push_back(*file);
    }
    return read;
}

// -O2 takes half as long again to compile, and its code runs some 7 % faster: worth it as long as nobody waits for it.
// Linear rules that are emitted a second time (singles) do not make a module long: it has few of them, and they are what it evaluates. Nor
// do the tables at its end, most of which describe the prelude: they are not code.
int optimisation_for(const std::string& cpp, const plan::Plan& plan) {
    constexpr std::size_t kLongCode = 24'000, kRulesAgain = 10'000;
    const std::size_t code = cpp.find("\nstatic constexpr FieldInfo kFields");
    MELD_EXPECT(code != std::string::npos, "a module without tables");
    return code < kLongCode + (plan.singles.apply() ? kRulesAgain : 0) ? 2 : 1;
}

// Does the work; after a second, prints what is being done and how long it has taken.
void with_progress(const std::string& what, const std::function<void()>& work) {
    using namespace std::chrono_literals;
    std::mutex mutex;
    std::condition_variable finished;
    bool done = false;
    Workers(2).run(2, [&](int, std::size_t job) {
        if (job == 0) {
            work();
            const std::lock_guard lock(mutex);
            done = true;
            finished.notify_one();
            return;
        }
        std::unique_lock lock(mutex);
        std::optional<Progress> progress;
        const auto begin = std::chrono::steady_clock::now();
        for (auto pause = 1000ms; !finished.wait_for(lock, pause, [&] { return done; }); pause = 200ms) {
            if (!progress) progress.emplace();
            progress->update([&] {
                return fmt::format("{}: {:.0f} s", what, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
            });
        }
    });
}

// From so many functions of rules on, a module is compiled in pieces. No example has as many.
constexpr std::size_t kManyFunctions = 80;
// From so many on, code is generated quickly.
constexpr std::size_t kVeryManyFunctions = 600;

// Tests compile short programs in pieces too, of about so many parts each.
std::optional<std::size_t> parts_of_piece() {
    const char* const said = std::getenv("CLAYMELD_PARTS_OF_PIECE");
    return said == nullptr || *said == '\0' ? std::nullopt : std::optional<std::size_t>(std::max(1, std::atoi(said)));
}

// Where a level is asked for, the module is compiled as a whole.
bool in_pieces(const plan::Plan& plan, const CompileOptions& options) {
    if (plan.program.rules.empty()) return false;
    return parts_of_piece() || (!options.optimisation && emit::functions_of_rules(plan) >= kManyFunctions);
}

TextInParts text_in_parts(const plan::Plan& plan) {
    emit::ModuleParts emitted = emit::emit_parts(plan);
    TextInParts text;
    text.shared = std::move(emitted.shared);
    const CodePasses rules = emit::functions_of_rules(plan) < kVeryManyFunctions ? CodePasses::Few : CodePasses::Quick;
    for (emit::ModulePart& part : emitted.parts) {
        const bool tables = part.kind == emit::ModulePart::Kind::Tables;
        const CodePasses passes = tables ? CodePasses::None : part.kind == emit::ModulePart::Kind::Kernel ? CodePasses::All : rules;
        text.parts.push_back({part.name, std::move(part.text), passes, tables});
    }
    if (const std::optional<std::size_t> parts = parts_of_piece()) text.parts_of_piece = *parts;
    return text;
}

Result<std::string> build(const plan::Plan& plan, const CompileOptions& options) {
    BuildOptions build_options;
    if (!options.cache_dir.empty()) build_options.cache_dir = options.cache_dir;
    std::optional<TextInParts> parts;
    std::string cpp;
    if (plan.in_pieces())
        parts = text_in_parts(plan);
    else
        cpp = emit::emit_module(plan);
    build_options.optimisation = options.optimisation.value_or(parts ? 1 : optimisation_for(cpp, plan));
    build_options.headers = module_headers();
    build_options.extern_header = kExtern;
    for (const std::string& path : options.link) {
        Result<std::string> text = read_linked(path);
        if (!text) return text;
        build_options.linked.push_back({path, std::move(*text)});
    }
    for (const check::Function& f : plan.program.functions)
        if (f.external) build_options.externs.push_back(f.name);
    build_options.schema_hash = emit::schema_hash(plan);
    build_options.abi_version = kAbiVersion;
    Result<std::string> module;
    const auto build = [&] {
        module = parts ? build_module(*parts, plan.program.name, build_options) : build_module(cpp, plan.program.name, build_options);
    };
    std::size_t size_bytes = cpp.size();
    if (parts) {
        size_bytes = parts->shared.size();
        for (const TextPart& part : parts->parts) size_bytes += part.text.size();
    }
    if (options.progress)
        with_progress(fmt::format("compiling {}, {} kB of C++", plan.program.name, size_bytes / 1000), build);
    else
        build();
    return module;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> module_headers() {
    std::vector<std::pair<std::string, std::string>> headers;
    for (const EmbeddedText& header : kModuleHeaders) headers.emplace_back(header.name, header.text);
    return headers;
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
    const std::uint32_t prelude_files = front::add_prelude(out.files);
    const Result<std::uint32_t> file = out.files.read(path, InputKind::FileOrPipe);
    if (!file) return tl::unexpected<Error>(file.error());
    if (options.last == Stage::Tokens) {
        out.result = syntax::print_tokens(out.files, *file, out.report);
        return {};
    }
    const Result<std::vector<std::uint32_t>> programs = read_programs(path, options.programs, out.files);
    if (!programs) return tl::unexpected<Error>(programs.error());
    const syntax::ParseOptions parse = {.library_paths = options.library_paths, .programs = *programs, .links_c = !options.link.empty()};
    front::ParsedProgram parsed = front::parse_program(out.files, *file, prelude_files, out.report, parse);
    parsed.worlds = options.worlds;
    parsed.acyclic = options.acyclic;
    parsed.lattice = options.lattice;
    parsed.ports = options.ports;
    if (options.last == Stage::Tree) {
        out.result = syntax::print(parsed.program);
        return {};
    }
    check::Program program = front::check_program(out.files, *file, prelude_files, std::move(parsed), out.report);
    if (out.report.has_errors()) return {};
    if (options.last == Stage::Program) {
        out.result = check::print(program);
        return {};
    }
    plan::Plan plan = plan::make_plan(std::move(program), options.plan);
    if (options.last == Stage::Plan) out.result = plan.stored.empty() ? check::print(plan.program) : plan::print(plan);
    if (options.last == Stage::Explain) out.result = plan::explain(plan);
    if (!out.result.empty()) return {};
    if (in_pieces(plan, options)) emit::name_for_pieces(plan);
    if (options.last == Stage::Cpp) {
        out.result = emit::emit_module(plan);
        return {};
    }
    Result<std::string> module = build(plan, options);
    if (!module) return tl::unexpected<Error>(module.error());
    out.result = *module;
    return {};
}

}  // namespace meld::driver
