#include "compiler/front/carried.h"

#include <utility>

#include "compiler/check/check.h"
#include "compiler/front/body.h"
#include "compiler/front/front_end.h"
#include "runtime/base/assert.h"

namespace meld::front {

namespace {

Result<std::optional<syntax::Rule>> body_of_rule(source::FileSet& files, const Asked& asked, diagnostics::Reporter& report) {
    std::optional<std::vector<syntax::Rule>> rules = parse_rules(files, files.add(asked.file, asked.text), report);
    if (!rules) return std::nullopt;
    MELD_EXPECT(asked.rule < rules->size(), "rule {} of {}", asked.rule, rules->size());
    syntax::Rule rule = std::move((*rules)[asked.rule]);
    rule.arrow = syntax::Arrow::Question;
    rule.head.clear();
    return rule;
}

}  // namespace

Result<check::Program> check_carried(source::FileSet& files, const Carried& carried, const Asked& asked, diagnostics::Reporter& report) {
    MELD_EXPECT(carried.programs > 0 && carried.programs <= carried.sources.size(), "{} programs in {} sources", carried.programs,
                carried.sources.size());
    const std::uint32_t prelude_files = add_prelude(files);
    const auto own = static_cast<std::uint32_t>(files.count());
    for (const check::Program::Source& source : carried.sources) files.add(source.path, source.text, source::File::From::Disk);
    std::vector<std::optional<std::uint32_t>> meant = carried.includes;
    for (std::optional<std::uint32_t>& file : meant)
        if (file) *file += own;
    std::vector<std::uint32_t> others;
    for (std::uint32_t i = 1; i < carried.programs; ++i) others.push_back(own + i);
    ParsedProgram parsed = parse_program(files, own, prelude_files, report, {.meant = std::move(meant), .programs = std::move(others)});
    if (!asked.text.empty()) {
        Result<std::optional<syntax::Rule>> question =
            asked.file.empty() ? parse_body(files, asked.text, report) : body_of_rule(files, asked, report);
        if (!question) return tl::unexpected<Error>(question.error());
        if (!*question) return check::Program{};
        parsed.program.add(std::move(**question), 0);
    }
    syntax::Tree tree = std::move(parsed.prelude);
    tree.append(std::move(parsed.program));
    check::separate_modules(tree, prelude_files, report);
    return check::check(files, tree, prelude_files, report, carried.worlds);
}

}  // namespace meld::front
