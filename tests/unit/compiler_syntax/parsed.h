// Helpers of the tests: a parsed program with its messages, and a tree written out with every bracket.
#pragma once

#include <string>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/parse.h"

namespace meld::syntax {

struct Parsed {
    source::FileSet files = {};
    diagnostics::Reporter report = {};
    Tree tree = {};

    std::vector<diagnostics::Diagnostic> messages() const { return report.sorted(); }
    std::string rendered() const { return diagnostics::render_text(files, report.sorted(), diagnostics::Colour::Never); }
    // "1:5 SyntaxError message", one a line.
    std::string brief() const {
        std::string result;
        for (const auto& message : messages()) {
            const auto place = files.begin(message.span);
            result += fmt::format("{}:{} {} {}\n", place.line, place.column, info(message.kind).name, message.message);
        }
        return result;
    }
};

// Files that programs of these tests import from; they hold nothing.
inline ParseOptions with_importable_files() { return {.libraries = {{"f", ""}, {"file", ""}, {"x", ""}}}; }

inline Parsed parsed(std::string text, const ParseOptions& options = with_importable_files()) {
    Parsed result;
    const std::uint32_t file = result.files.add("test.meld", std::move(text));
    result.tree = parse(result.files, file, result.report, options);
    return result;
}

// The expression with brackets around every operator, so that two trees are the same iff their outlines are.
std::string outline(const Expr& expr);

// The right side of `const x = ...`.
inline const Expr& constant_value(const Parsed& program) { return *std::get<Constant>(program.tree.items.at(0)).value; }

}  // namespace meld::syntax
