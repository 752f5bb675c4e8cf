// Code actions: the fixes that the compiler makes with its messages, as changes of files.
#include <algorithm>
#include <filesystem>
#include <tuple>

#include "compiler/lsp/describe.h"

namespace meld::lsp {

namespace {

bool is_before(Position a, Position b) { return std::tie(a.line, a.character) < std::tie(b.line, b.character); }
bool touch(Range a, Range b) { return !is_before(a.end, b.start) && !is_before(b.end, a.start); }

}  // namespace

std::vector<Action> actions(const Analysis& analysis, Range range) {
    const source::FileSet& files = analysis.files();
    // The prelude and the libraries are parts of the compiler; their paths are not those of files.
    const auto may_change = [&](std::uint32_t file) {
        return !analysis.is_prelude(file) && std::filesystem::path(files.file(file).path()).is_absolute();
    };
    std::vector<Action> found;
    for (const Message& message : analysis.messages()) {
        if (!touch(message.range, range)) continue;
        bool first = true;
        for (const diagnostics::Fix& fix : diagnostics::exact(files, message.fixes, may_change)) {
            Action& action = found.emplace_back(Action{.title = fix.title, .message = message, .preferred = first});
            for (const diagnostics::Edit& edit : fix.edits)
                action.edits[files.file(edit.span).path()].emplace_back(range_of(files, edit.span), edit.text);
            first = false;
        }
    }
    return found;
}

}  // namespace meld::lsp
