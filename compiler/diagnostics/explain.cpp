// Puts a page together from its parts. The parts are in pages.def and pages_of_rules.def, one entry for each row of kinds.def.
#include "compiler/diagnostics/explain.h"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace meld::diagnostics {

namespace {

struct Page {
    Kind kind;
    std::string_view meaning;
    std::string_view wrong;
    std::string_view cure;
    std::string_view right;
};

constexpr Page kPages[] = {
#define MELD_PAGE(name, meaning, wrong, cure, right) {Kind::name, meaning, wrong, cure, right},
#include "compiler/diagnostics/pages.def"
#include "compiler/diagnostics/pages_of_rules.def"
#undef MELD_PAGE
};

// The text behind its first line break, each line moved in.
std::string indented(std::string_view text) {
    std::string result;
    std::size_t begin = 0;
    while (begin < text.size()) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        result += "    ";
        result += text.substr(begin, end - begin);
        result += '\n';
        begin = end + 1;
    }
    return result;
}

}  // namespace

std::string explanation(Kind kind) {
    const KindInfo& row = info(kind);
    std::string page = fmt::format("{}: {} ({})\n\n", row.code, row.title, row.name);
    for (const Page& entry : kPages) {
        if (entry.kind != kind) continue;
        page += fmt::format("{}\n\n{}\n{}\n", entry.meaning, indented(entry.wrong), entry.cure);
        if (!entry.right.empty()) page += "\n" + indented(entry.right);
    }
    return page;
}

}  // namespace meld::diagnostics
