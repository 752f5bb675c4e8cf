// The stages before planning, one function each.
#include "compiler/front/front_end.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/check/check.h"
#include "compiler/check/program/library.h"
#include "compiler/front/embedded.h"
#include "compiler/lint/lint.h"
#include "runtime/base/assert.h"

namespace meld::front {

namespace {

std::vector<syntax::Library> libraries() {
    std::vector<syntax::Library> result;
    for (const EmbeddedText& library : kLibraries) result.push_back({library.name, library.text});
    return result;
}

void add_sources(const source::FileSet& files, std::uint32_t main, const std::vector<std::uint32_t>& others,
                 const std::vector<syntax::Tree::Include>& includes, check::Program& program) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path folder = fs::absolute(files.file(main).path(), error).lexically_normal().parent_path();
    std::vector<std::optional<std::uint32_t>> numbers(files.count());
    const auto add = [&](std::uint32_t i) {
        const source::File& file = files.file(i);
        if (!file.on_disk() || numbers[i]) return;
        const std::string path = fs::absolute(file.path(), error).lexically_normal().lexically_relative(folder).string();
        numbers[i] = static_cast<std::uint32_t>(program.sources.size());
        program.sources.push_back({path, file.text()});
    };
    add(main);
    for (const std::uint32_t other : others) add(other);
    program.programs = static_cast<std::uint32_t>(1 + others.size());
    for (std::uint32_t i = 0; i < files.count(); ++i) add(i);
    // A text without a file, as an editor has.
    if (program.sources.empty()) program.sources.push_back({files.file(main).path(), files.file(main).text()});
    for (const syntax::Tree::Include& include : includes) program.includes.push_back(include.file ? numbers[*include.file] : std::nullopt);
}

// The name that an item declares, if it is one for which nobody would look in a library.
const std::string* declared_name(const syntax::Item& item, bool links_c) {
    if (const auto* e = std::get_if<syntax::Extern>(&item)) return links_c ? &e->name.text : nullptr;
    if (const auto* f = std::get_if<syntax::Function>(&item)) return &f->name.text;
    if (const auto* c = std::get_if<syntax::Constant>(&item)) return &c->name.text;
    const auto* d = std::get_if<syntax::Declaration>(&item);
    return d != nullptr ? &d->name.text : nullptr;
}

// Programs of older Meld call functions of its machine without a declaration: if the text names one of them that it does not declare, the
// program has the library `older`, as if it used it. Names of its own hide those of the library.
void add_older_functions(source::FileSet& files, std::uint32_t prelude_files, bool links_c, syntax::Tree& program,
                         diagnostics::Reporter& report) {
    std::set<std::string, std::less<>> own;
    for (std::size_t i = 0; i < program.items.size(); ++i)
        if (const std::string* name = declared_name(program.items[i], links_c); name != nullptr && program.unit_of[i] == 0)
            own.insert(*name);
    const auto is_called = [&](std::string_view name) {
        if (own.contains(name)) return false;
        for (std::uint32_t i = prelude_files; i < files.count(); ++i)
            if (files.file(i).text().find(name) != std::string::npos) return true;
        return false;
    };
    if (!std::ranges::any_of(check::older_functions(), is_called)) return;
    const auto older =
        std::ranges::find(kLibraries, std::string_view("older"), [](const EmbeddedText& l) { return std::string_view(l.name); });
    MELD_CHECK(older != kLibraries.end(), "there is no library `older`");
    program.shared_file = files.add("stdlib/older.meld", older->text);
    syntax::Tree library = syntax::parse(files, *program.shared_file, report);
    for (syntax::Item& item : library.items)
        if (const std::string* name = declared_name(item, links_c); name == nullptr || !own.contains(*name))
            program.add(std::move(item), 0);
}

// An item of the prelude, which has declarations and constants that are numbers.
syntax::Item copy_of(const syntax::Item& item) {
    if (const auto* declaration = std::get_if<syntax::Declaration>(&item)) return *declaration;
    const auto& constant = std::get<syntax::Constant>(item);
    const auto& value = std::get<syntax::IntLiteral>(constant.value->node);
    return syntax::Constant{constant.name, std::make_unique<syntax::Expr>(value, constant.value->span), constant.span};
}

// The prelude is most of what a question about a run has to parse, so it is parsed once for all that a process asks.
syntax::Tree parse_prelude(source::FileSet& files, diagnostics::Reporter& report) {
    // An editor may have another text in its place.
    if (files.file(0).text() != kPrelude) return syntax::parse(files, 0, report);
    static const syntax::Tree parsed = [] {
        source::FileSet alone;
        add_prelude(alone);
        diagnostics::Reporter nothing;
        syntax::Tree tree = syntax::parse(alone, 0, nothing);
        MELD_EXPECT(nothing.error_count() == 0 && tree.units.size() == 1 && tree.includes.empty());
        return tree;
    }();
    syntax::Tree tree;
    tree.units = parsed.units;
    tree.items.reserve(parsed.items.size());
    for (std::size_t i = 0; i < parsed.items.size(); ++i) tree.add(copy_of(parsed.items[i]), parsed.unit_of[i]);
    return tree;
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
    if (prelude_files > 0) parsed.prelude = parse_prelude(files, report);
    syntax::ParseOptions with_libraries = options;
    with_libraries.libraries = libraries();
    parsed.program = syntax::parse(files, file, report, with_libraries);
    add_older_functions(files, prelude_files, options.links_c, parsed.program, report);
    parsed.others = options.programs;
    parsed.links_c = options.links_c;
    return parsed;
}

check::Program check_program(const source::FileSet& files, std::uint32_t file, std::uint32_t prelude_files, ParsedProgram parsed,
                             diagnostics::Reporter& report) {
    const std::vector<syntax::Tree::Include> includes = std::move(parsed.program.includes);
    const std::vector<std::uint32_t> others = std::move(parsed.others);
    const check::Worlds worlds = parsed.worlds;
    const bool links_c = parsed.links_c;
    const lint::Graph graph = parsed.acyclic ? lint::Graph::Acyclic : lint::Graph::Any;
    const std::string lattice = std::move(parsed.lattice), ports = std::move(parsed.ports);
    syntax::Tree tree = std::move(parsed.prelude);
    tree.append(std::move(parsed.program));
    check::separate_modules(tree, prelude_files, report);
    const std::vector<diagnostics::Diagnostic> unused_names = lint::find_unused_names(files, tree, file);
    check::Program program = check::check(files, tree, prelude_files, report, worlds, links_c);
    lint::lint(program, file, unused_names, {.lattice = lattice, .ports = ports, .graph = graph}, report);
    program.name = std::filesystem::path(files.file(file).path()).stem().string();
    add_sources(files, file, others, includes, program);
    return program;
}

}  // namespace meld::front
