// Cures that a program can apply: changes of the program's text, made where the message is made. How a change fits into the text around it,
// its commas, blanks and line ends, is worked out when it is shown or applied, since only the files know.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/source.h"

namespace meld::diagnostics {

using source::Span;

// The text takes the place of the span.
struct Edit {
    Span span;
    std::string text;
    enum class Fit {
        Exact,    // Of these bytes.
        Name,     // Of the name that the span begins with.
        Word,     // Of the word and, if the text is empty, of the blanks next to it.
        Element,  // The span goes from a list with one of its commas; only one that stands alone becomes the text.
        Sign,     // Of these bytes and of the blanks before them, unless they start a line.
        Item,     // The declaration or rule goes with its full stop, and its lines if nothing else stands on them.
        Before,   // A line of its own before the item that the span begins with; nothing is replaced.
        After,    // The same behind the item that the span ends with.
    } fit = Fit::Exact;

    bool operator==(const Edit& other) const;
};

struct Fix {
    // What it does, as an editor shows it: "Write `dist`".
    std::string title;
    std::vector<Edit> edits;
    // A program that compiles means the same after it, and one that does not has no other reading. So `meldc check --fix` may apply it
    // without asking; all others are guesses, or say what only the author can know.
    bool safe = false;
};

// The name that the span begins with, as the program writes it.
std::string_view name_at(const source::FileSet& files, Span span);

Fix write(Span span, std::string text, Edit::Fit fit = Edit::Fit::Exact);
// `what` is shown: "`virtual`", "this declaration".
Fix leave_out(Span span, std::string_view what, Edit::Fit fit);
Fix insert(Span place, std::string text);
// f(...) around what stands there.
Fix call_around(Span span, std::string_view function);
Fix safe(Fix fix);

// The fixes of which every edit is in a file that may be changed, with exact edits.
std::vector<Fix> exact(const source::FileSet& files, const std::vector<Fix>& fixes, const std::function<bool(std::uint32_t)>& may_change);

// Exact edits of one file that are not in each other's way.
class Edits {
  public:
    // Whether it could be added: no other one changes a byte that it changes, or inserts where it does. An equal one is no hindrance.
    bool fits(const Edit& edit) const;
    void add(const Edit& edit);
    std::string applied(const std::string& text) const;

  private:
    std::map<std::uint32_t, Edit> edits_;  // By where they begin.
};

}  // namespace meld::diagnostics
