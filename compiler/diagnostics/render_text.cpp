// Diagnostics for people: the sentence, the place, the source lines with what matters underlined, and the help.
#include <algorithm>
#include <tuple>
#include <utility>

#include "compiler/diagnostics/diagnostics.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::diagnostics {

namespace {

// Longer source lines are cut around what is underlined; 100 columns and the gutter fit the usual terminal.
constexpr std::size_t kMaxColumns = 100;
constexpr std::size_t kTabColumns = 4;

struct Style {
    Colour colour;
    std::string paint(std::string_view code, std::string_view text) const {
        if (colour == Colour::Never || text.empty()) return std::string(text);
        return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
    }
    std::string gutter(std::string_view text) const { return paint("1;34", text); }
    std::string strong(std::string_view text) const { return paint("1", text); }
};

std::string_view severity_colour(Severity severity) {
    return severity == Severity::Error ? "1;31" : severity == Severity::Warning ? "1;33" : "1;36";
}

// A source line as it is shown: one string per column, so that tabs and multi-byte characters can be cut and underlined. What a
// terminal would obey is a question mark.
struct ShownLine {
    std::vector<std::string> columns;
    // The first shown column of each byte, and one more for the end of the line.
    std::vector<std::size_t> column_of_byte;
};

ShownLine show_line(std::string_view line) {
    ShownLine shown;
    while (!line.empty()) {
        const std::size_t size = visible_character(line);
        const std::size_t taken = std::max<std::size_t>(1, size);
        shown.column_of_byte.insert(shown.column_of_byte.end(), taken, shown.columns.size());
        if (line.front() == '\t') {
            do shown.columns.emplace_back(" ");
            while (shown.columns.size() % kTabColumns != 0);
        } else {
            shown.columns.emplace_back(size == 0 ? "?" : line.substr(0, size));
        }
        line.remove_prefix(taken);
    }
    shown.column_of_byte.push_back(shown.columns.size());
    return shown;
}

struct Mark {
    std::size_t begin_byte;
    std::size_t end_byte;
    char stroke;
    std::string text;
};

struct MarkedLine {
    std::uint32_t file;
    std::uint32_t number;
    std::vector<Mark> marks;
};

// Adds the marks of one span: on its line, or on its first and last line.
void mark_span(std::vector<MarkedLine>& lines, const source::FileSet& files, Span span, char stroke, const std::string& text) {
    const source::File& file = files.file(span);
    const source::Place begin = file.place(span.begin);
    const source::Place end = file.place(std::max(span.begin, span.end));
    const auto line_of = [&](std::uint32_t number) -> MarkedLine& {
        for (MarkedLine& line : lines) {
            if (line.file == span.file && line.number == number) return line;
        }
        lines.push_back({span.file, number, {}});
        return lines.back();
    };
    if (begin.line == end.line || (end.line == begin.line + 1 && end.column == 1)) {
        const std::size_t end_byte = begin.line == end.line ? end.column - 1 : file.line(begin.line).size();
        line_of(begin.line).marks.push_back({begin.column - 1, end_byte, stroke, text});
        return;
    }
    line_of(begin.line).marks.push_back({begin.column - 1, file.line(begin.line).size(), stroke, "from here ..."});
    const std::string_view last = file.line(end.line);
    const std::size_t indent = std::min<std::size_t>(last.find_first_not_of(" \t"), end.column - 1);
    line_of(end.line).marks.push_back({indent, end.column - 1, stroke, text.empty() ? "... to here" : "... to here: " + text});
}

// The columns [first, last) of a long line that show its first mark with something around it.
std::pair<std::size_t, std::size_t> window(const ShownLine& shown, std::size_t mark_begin, std::size_t mark_end) {
    const std::size_t count = shown.columns.size();
    if (count <= kMaxColumns) return {0, count};
    const std::size_t length = std::min(mark_end - mark_begin, kMaxColumns);
    const std::size_t before = (kMaxColumns - length) / 2;
    const std::size_t first = std::min(mark_begin > before ? mark_begin - before : 0, count - kMaxColumns);
    return {first, first + kMaxColumns};
}

class TextPage {
  public:
    TextPage(const source::FileSet& files, Style style) : files_(files), style_(style) {}

    void diagnostic(const Diagnostic& diagnostic) {
        const KindInfo& kind = info(diagnostic.kind);
        const std::string_view colour = severity_colour(kind.severity);
        out_ += style_.paint(colour, fmt::format("{}[{}]", severity_name(kind.severity), kind.code));
        out_ += style_.strong(": " + visible(diagnostic.message)) + "\n";
        std::vector<MarkedLine> lines;
        mark_span(lines, files_, diagnostic.span, '^', "");
        for (const Label& label : diagnostic.labels) mark_span(lines, files_, label.span, '-', label.text);
        gutter_width_ = 1;
        for (const MarkedLine& line : lines) gutter_width_ = std::max(gutter_width_, std::to_string(line.number).size());
        const source::Place place = files_.begin(diagnostic.span);
        out_ += fmt::format("{}{} {}:{}:{}\n", std::string(gutter_width_, ' '), style_.gutter("-->"),
                            visible(files_.file(diagnostic.span).path()), place.line, place.column);
        source_lines(diagnostic.span.file, lines, colour);
        help(diagnostic.help);
    }
    std::string take() { return std::exchange(out_, {}); }

  private:
    // The lines of the diagnostic's own file in order, then those of other files.
    void source_lines(std::uint32_t main_file, std::vector<MarkedLine>& lines, std::string_view colour) {
        std::sort(lines.begin(), lines.end(), [&](const MarkedLine& a, const MarkedLine& b) {
            return std::tuple(a.file != main_file, a.file, a.number) < std::tuple(b.file != main_file, b.file, b.number);
        });
        empty_gutter();
        std::uint32_t file = main_file;
        std::uint32_t last_number = 0;
        for (const MarkedLine& line : lines) {
            if (line.file != file) {
                out_ += fmt::format("{}{} {}:{}\n", std::string(gutter_width_, ' '), style_.gutter(":::"),
                                    visible(files_.file(line.file).path()), line.number);
                file = line.file;
            } else if (last_number != 0 && line.number > last_number + 1) {
                out_ += style_.gutter("...") + "\n";
            }
            last_number = line.number;
            source_line(line, colour);
        }
    }

    void source_line(const MarkedLine& line, std::string_view colour) {
        const ShownLine shown = show_line(files_.file(line.file).line(line.number));
        const auto column = [&](std::size_t byte) { return shown.column_of_byte[std::min(byte, shown.column_of_byte.size() - 1)]; };
        const Mark& main = line.marks.front();
        const auto [first, last] = window(shown, column(main.begin_byte), column(main.end_byte));
        std::string text = first > 0 ? "..." : "";
        for (std::size_t i = first; i < last; ++i) text += shown.columns[i];
        if (last < shown.columns.size()) text += "...";
        out_ += style_.gutter(fmt::format("{:>{}} |", line.number, gutter_width_)) + " " + text + "\n";
        for (const Mark& mark : line.marks) {
            const std::size_t begin = std::clamp(column(mark.begin_byte), first, last);
            const std::size_t end = std::clamp(column(mark.end_byte), begin, last);
            const std::string strokes(std::max<std::size_t>(1, end - begin), mark.stroke);
            const std::string label = mark.text.empty() ? strokes : strokes + " " + visible(mark.text);
            out_ += style_.gutter(std::string(gutter_width_ + 1, ' ') + "|") + " " + std::string(begin - first + (first > 0 ? 3 : 0), ' ') +
                    style_.paint(mark.stroke == '^' ? colour : "1;34", label) + "\n";
        }
    }

    void help(const std::string& text) {
        if (text.empty()) return;
        empty_gutter();
        std::size_t begin = 0;
        while (begin <= text.size()) {
            const std::size_t end = std::min(text.find('\n', begin), text.size());
            const std::string lead = begin == 0 ? style_.gutter("=") + " " + style_.strong("help:") : std::string("       ");
            out_ += std::string(gutter_width_ + 1, ' ') + lead + " " + visible(text.substr(begin, end - begin)) + "\n";
            begin = end + 1;
        }
    }

    void empty_gutter() { out_ += style_.gutter(std::string(gutter_width_ + 1, ' ') + "|") + "\n"; }

    const source::FileSet& files_;
    Style style_;
    std::size_t gutter_width_ = 1;
    std::string out_;
};

}  // namespace

std::string render_text(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics, Colour colour) {
    TextPage page(files, Style{colour});
    std::string result;
    for (const Diagnostic& diagnostic : diagnostics) {
        page.diagnostic(diagnostic);
        if (!result.empty()) result += "\n";
        result += page.take();
    }
    return result;
}

std::string render_errors(const source::FileSet& files, const Reporter& report) {
    std::vector<Diagnostic> errors = report.sorted();
    std::erase_if(errors, [](const Diagnostic& d) { return info(d.kind).severity != Severity::Error; });
    std::string text = render_text(files, errors, Colour::Never);
    while (text.ends_with('\n')) text.pop_back();
    return text;
}

}  // namespace meld::diagnostics
