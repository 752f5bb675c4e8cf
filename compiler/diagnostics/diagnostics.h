// Diagnostics are data: a kind from one table, a span, labels on other places, a help line. Rendered last.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/diagnostics/fix.h"
#include "compiler/source/source.h"

namespace meld::diagnostics {

using source::Span;

enum class Severity { Error, Warning, Note };
std::string_view severity_name(Severity severity);

// One value per row of kinds.def; each row has a code (E0301), a severity, a title, and a page for `meldc explain`.
enum class Kind {
#define MELD_KIND(name, code, severity, title) name,
#include "compiler/diagnostics/kinds.def"
#undef MELD_KIND
};

struct KindInfo {
    std::string_view name;
    std::string_view code;
    Severity severity;
    std::string_view title;
};
const KindInfo& info(Kind kind);
// The kind with this code or name, or nullptr.
const KindInfo* find_kind(std::string_view code);
std::vector<KindInfo> all_kinds();

struct Label {
    Span span;
    std::string text;
};

struct Diagnostic {
    Kind kind;
    Span span;
    // One sentence without a full stop, about this particular case.
    std::string message;
    std::vector<Label> labels = {};
    // Text to write instead, or what to do; may be empty.
    std::string help = {};
    // The same cures as changes of the text, the best first; empty where only the author knows what to write.
    std::vector<Fix> fixes = {};

    // The help and the fix for a name that is nearly this one.
    void did_you_mean(const std::string& name, Span written, Edit::Fit fit = Edit::Fit::Exact);
};

// Collects diagnostics. A compilation reports all mistakes it finds; equal spans and kinds are reported once.
class Reporter {
  public:
    // Adds one and returns it, so that labels, help and fixes can be attached: report.add(Kind::X, span, "...").help = "...". It stays
    // where it is, so that a pass may complete it when it knows more.
    Diagnostic& add(Kind kind, Span span, std::string message) { return add({.kind = kind, .span = span, .message = std::move(message)}); }
    Diagnostic& add(Diagnostic diagnostic);
    bool has_errors() const { return error_count_ > 0; }
    // How many errors there are, repeats counted once.
    std::size_t error_count() const { return error_count_; }
    // In source order (file, begin), without repeats.
    std::vector<Diagnostic> sorted() const;

  private:
    std::deque<Diagnostic> diagnostics_;
    std::set<std::tuple<Kind, std::uint32_t, std::uint32_t, std::uint32_t>> seen_;
    std::size_t error_count_ = 0;
};

enum class Colour { Never, Always };

// "error[E0301]: message", the source line underlined with the main text, labelled lines, help.
std::string render_text(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics, Colour colour);
// The errors alone, without colour and without the end of their last line: the problem that an Error tells.
std::string render_errors(const source::FileSet& files, const Reporter& report);
// One JSON array of the messages of any number of programs. Each object has code, severity, message, path, line, column, end_line,
// end_column, labels, help, and those fixes that change only files on disk.
class JsonMessages {
  public:
    void add(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics);
    std::string text() const;

  private:
    std::string objects_;
};
std::string render_json(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics);

// The candidate nearest to the given name, or "" if none is near enough to suggest.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);
// Words as a sentence lists them: "max, min and sum".
std::string in_words(const std::vector<std::string>& words);

}  // namespace meld::diagnostics
