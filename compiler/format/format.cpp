// The formatter's pipeline: pieces, entries, lines, text; then the check that nothing was lost.
//
// Two things are aligned, as in the examples: the arrows of views in consecutive lines, and comments behind code that their author had
// aligned.
#include "compiler/format/format.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "compiler/format/layout.h"
#include "compiler/format/pieces.h"
#include "compiler/syntax/parse.h"
#include "runtime/base/assert.h"

namespace meld::format {

namespace {

// Heads of very different widths are not aligned: more blanks than this separate what belongs together.
constexpr std::size_t kMaxPadding = 12;

// ---- reading

// The pieces of the text, or nothing if it has mistakes. Includes are not followed, so the included files need not exist.
std::optional<std::vector<Piece>> read(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report) {
    const std::size_t errors = report.error_count();
    syntax::parse(files, file, report, {.follow_includes = false});
    if (report.error_count() > errors) return std::nullopt;
    diagnostics::Reporter again;
    std::vector<syntax::Token> tokens = syntax::scan(files.file(file), file, again);
    syntax::classify_words(tokens);
    return pieces_of(files.file(file), tokens);
}

// ---- laying out

class Writer {
  public:
    explicit Writer(std::vector<Entry> entries) {
        for (Entry& entry : entries) add_entry(std::move(entry));
        for (const Entry& entry : entries_) layouts_.emplace_back(entry.item);
    }

    std::vector<Line> run() {
        const std::vector<std::size_t> paddings = align_arrows();
        MELD_ASSERT(paddings.size() == entries_.size() && layouts_.size() == entries_.size(), "{} paddings of {} entries", paddings.size(),
                    entries_.size());
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            if (entries_[i].comment_alone()) {
                add_comment(entries_[i]);
            } else {
                add_item(entries_[i], layouts_[i].lines(paddings[i]));
            }
        }
        if (!lines_.empty()) lines_.front().blank_before = false;
        return std::move(lines_);
    }

  private:
    // A comment before an item of several lines gets a separate line, so that the item starts further left than its other lines.
    void add_entry(Entry entry) {
        const auto code = std::find_if(entry.item.begin(), entry.item.end(), [](const Piece& piece) { return !piece.comment(); });
        if (code != entry.item.begin() && code != entry.item.end() && Layout(entry.item).lines().size() > 1) {
            entries_.push_back({.item = {}, .comments = {entry.item.begin(), code}, .blank_before = entry.blank_before});
            entry.item.erase(entry.item.begin(), code);
            entry.blank_before = false;
        }
        entries_.push_back(std::move(entry));
    }

    // Axioms between views do not separate their alignment; a blank line or anything else ends a run of rules.
    bool is_axiom(std::size_t i) const {
        const auto arrow = [](const Piece& piece) { return piece.is(TokenKind::ViewArrow) || piece.is(TokenKind::LinearArrow); };
        const Entry& entry = entries_[i];
        const bool rule = std::any_of(entry.item.begin(), entry.item.end(), arrow);
        return !entry.item.empty() && !rule && entry.item.front().is(TokenKind::Name);
    }

    // How many blanks go before the arrow of each entry.
    std::vector<std::size_t> align_arrows() const {
        std::vector<std::size_t> paddings(entries_.size(), 0);
        Run run;
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            if (entries_[i].blank_before) run.end(paddings);
            if (const auto view = layouts_[i].view()) {
                if (!run.takes(*view)) run.end(paddings);
                run.add(i, *view);
            } else if (!is_axiom(i)) {
                run.end(paddings);
            }
        }
        run.end(paddings);
        return paddings;
    }

    // Views in consecutive lines that share a column for their arrows.
    struct Run {
        std::vector<std::pair<std::size_t, std::size_t>> heads = {};  // Entry and columns.
        std::size_t widest = 0;
        std::size_t narrowest = 0;
        std::size_t rest = 0;  // The maximum number of columns after a head.

        // A line that is too long already stays alone, so that it does not get longer.
        bool takes(const Layout::View& view) const {
            if (heads.empty()) return true;
            const std::size_t most = std::max(widest, view.head);
            const std::size_t behind = std::max(rest, view.widest_line - std::min(view.head, view.widest_line));
            return most - std::min(narrowest, view.head) <= kMaxPadding && most + behind <= kMaxColumns;
        }

        void add(std::size_t entry, const Layout::View& view) {
            narrowest = heads.empty() ? view.head : std::min(narrowest, view.head);
            widest = std::max(widest, view.head);
            rest = std::max(rest, view.widest_line - std::min(view.head, view.widest_line));
            heads.emplace_back(entry, view.head);
        }

        void end(std::vector<std::size_t>& paddings) {
            for (const auto& [entry, head] : heads) paddings[entry] = widest - head;
            *this = {};
        }
    };

    void add_comment(const Entry& entry) {
        MELD_EXPECT(entry.comment_alone() && !entry.comments.empty(), "{} comments and {} pieces", entry.comments.size(),
                    entry.item.size());
        const Piece& comment = entry.comments.front();
        const bool goes_on = !entry.blank_before && comment.column > 0 && !lines_.empty() && lines_.back().comment &&
                             lines_.back().comment->column == comment.column && entry.comments.size() == 1;
        Line line{.blank_before = entry.blank_before};
        if (goes_on) {
            line.comment = comment;
        } else {
            line.code = joined(entry.comments);
        }
        lines_.push_back(std::move(line));
    }

    void add_item(const Entry& entry, std::vector<Line> lines) {
        MELD_EXPECT(!lines.empty(), "{} pieces on no line", entry.item.size());
        lines.front().blank_before = entry.blank_before;
        if (!entry.comments.empty()) {
            lines.back().comment = entry.comments.front();
            lines.back().comment->text = joined(entry.comments);
        }
        for (Line& line : lines) lines_.push_back(std::move(line));
    }

    static std::string joined(const std::vector<Piece>& comments) {
        std::string text;
        for (const Piece& comment : comments) text += (text.empty() ? "" : " ") + comment.text;
        return text;
    }

    std::vector<Entry> entries_;
    std::vector<Layout> layouts_;
    std::vector<Line> lines_;
};

std::size_t last_width(const std::string& code) { return width(std::string_view(code).substr(code.rfind('\n') + 1)); }

// The column for the comments after lines first..last, which were in one column: that column, or after the longest line.
std::size_t comment_column(const std::vector<Line>& lines, std::size_t first, std::size_t last) {
    MELD_EXPECT(first < last && last <= lines.size(), "lines {} to {} of {}", first, last, lines.size());
    std::size_t behind = 0;
    bool aligned = false;
    for (std::size_t i = first; i < last; ++i) {
        const Piece& comment = *lines[i].comment;
        if (lines[i].code.empty()) continue;
        behind = std::max(behind, last_width(lines[i].code) + 2);
        aligned = aligned || comment.column > comment.code_end + 2;
    }
    return aligned ? std::max(behind, lines[first].comment->column) : behind;
}

std::string text_of(const std::vector<Line>& lines) {
    std::string text;
    std::size_t column = 0;
    std::size_t aligned_until = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].blank_before) text += '\n';
        text += lines[i].code;
        if (lines[i].comment) {
            if (i >= aligned_until) {
                aligned_until = i + 1;
                const auto alike = [&](const Line& line) {
                    return line.comment && !line.blank_before && line.comment->column == lines[i].comment->column;
                };
                while (aligned_until < lines.size() && alike(lines[aligned_until])) ++aligned_until;
                column = comment_column(lines, i, aligned_until);
            }
            MELD_ASSERT(column >= last_width(lines[i].code), "a comment in column {} of code", column);
            text.append(column - last_width(lines[i].code), ' ');
            text += lines[i].comment->text;
        }
        text += '\n';
    }
    return text;
}

// ---- checking

bool same(const Piece& a, const Piece& b) { return a.kind == b.kind && a.token == b.token && a.text == b.text; }

// The new text must have the pieces of the old one, and no mistake.
std::optional<Error> lost_something(const std::vector<Piece>& before, const source::FileSet& files, std::uint32_t file,
                                    const std::string& text) {
    source::FileSet made;
    const std::string& path = files.file(file).path();
    const std::uint32_t index = made.add(path, text);
    diagnostics::Reporter report;
    const auto after = read(made, index, report);
    if (after && after->size() == before.size() && std::equal(before.begin(), before.end(), after->begin(), same)) return std::nullopt;
    std::string where = "it would not be a program";
    if (after) {
        const auto [old_piece, new_piece] = std::mismatch(before.begin(), before.end(), after->begin(), after->end(), same);
        where = fmt::format("`{}` would become `{}`", old_piece == before.end() ? "" : old_piece->text,
                            new_piece == after->end() ? "" : new_piece->text);
    }
    return Error{fmt::format("{} was left alone, as formatting would change it: {}", path, where),
                 "This is a bug of meldc; please report it with the file", ExitCode::OurBug};
}

}  // namespace

Result<std::optional<std::string>> format(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report) {
    const auto pieces = read(files, file, report);
    if (!pieces) return std::nullopt;
    std::string text = text_of(Writer(entries_of(*pieces)).run());
    if (auto error = lost_something(*pieces, files, file, text)) return tl::unexpected<Error>(std::move(*error));
    return text;
}

}  // namespace meld::format
