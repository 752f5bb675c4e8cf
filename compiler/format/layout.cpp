// Continuation lines are aligned with the first part in their bracket, or with the first part after the arrow; if that is too far to the
// right, or nothing follows the bracket or arrow, they are indented by a step.
#include "compiler/format/layout.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "compiler/format/format.h"
#include "compiler/format/spacing.h"
#include "runtime/base/assert.h"

namespace meld::format {

namespace {

constexpr std::size_t kStep = 4;
// Lines are aligned up to this column; further right there is no room left.
constexpr std::size_t kMaxHang = 48;

struct Bracket {
    std::size_t column = 0;       // Of the opening bracket itself.
    std::size_t content = 0;      // Where lines inside it start.
    std::size_t line_indent = 0;  // Of the line it stands in.
    bool hangs = false;           // Something follows it in its line.
};

}  // namespace

// Writes the pieces out line by line.
struct Layout::Render {
    const Layout& layout;
    std::size_t padding;
    std::vector<Line> lines = {};
    // What the next line depends on.
    struct State {
        std::vector<Bracket> brackets = {};
        std::size_t next = 0;    // The piece behind those written.
        std::size_t indent = 0;  // Of the line.
        std::size_t column = 0;  // Behind what is written of it.
        std::size_t body_column = kStep;
    } state = {};

    void run() {
        for (std::size_t i = 0; i < layout.item_.size(); i = state.next) line(i);
    }

    // Writes the line that starts with this piece.
    void line(std::size_t first) {
        MELD_EXPECT(first < layout.item_.size(), "piece {} of {}", first, layout.item_.size());
        start_line(first);
        do place(state.next++);
        while (state.next < layout.item_.size() && !layout.breaks_[state.next]);
    }

    void start_line(std::size_t i) {
        state.next = i;
        lines.push_back({.blank_before = i > 0 && layout.item_[i].newlines_before > 1});
        state.indent = i == 0 ? 0 : indent_of(i);
        state.column = 0;
        append(std::string(state.indent, ' '));
    }

    void append(std::string_view text) {
        lines.back().code += text;
        const std::size_t newline = text.rfind('\n');
        state.column = newline == std::string_view::npos ? state.column + width(text) : width(text.substr(newline + 1));
    }

    std::size_t indent_of(std::size_t i) const {
        const Piece& piece = layout.item_[i];
        if (!state.brackets.empty()) {
            const Bracket& bracket = state.brackets.back();
            const bool outer = closes_bracket(piece) || piece.is(TokenKind::Bar);
            if (outer) return bracket.hangs ? bracket.column : bracket.line_indent;
            return bracket.content;
        }
        if (i == layout.arrow_ || layout.arrow_ == layout.item_.size()) return kStep;
        return i < layout.arrow_ ? 0 : state.body_column;
    }

    bool last_in_line(std::size_t i) const {
        return i + 1 == layout.item_.size() || layout.breaks_[i + 1] || layout.item_[i + 1].kind == Piece::Kind::LineComment;
    }

    void place(std::size_t i) {
        const Piece& piece = layout.item_[i];
        const bool first = lines.back().code.size() == state.indent;
        if (piece.kind == Piece::Kind::LineComment && !first) {
            lines.back().comment = piece;
            return;
        }
        if (!first && layout.gaps_[i].blank) append(" ");
        if (i == layout.arrow_ && !first) append(std::string(padding, ' '));
        if (closes_bracket(piece) && !state.brackets.empty()) state.brackets.pop_back();
        const std::size_t column = state.column;
        append(piece.text);
        if (i == layout.arrow_) set_body_column(i);
        if (opens_bracket(piece)) state.brackets.push_back(opened(i, column));
    }

    void set_body_column(std::size_t i) {
        MELD_EXPECT(i == layout.arrow_ && padding <= state.column, "{} blanks before column {}", padding, state.column);
        const std::size_t column = state.column + 1;
        // Padding does not affect line breaks, so aligned rules are laid out as they would be alone.
        state.body_column = last_in_line(i) || column - padding > kMaxHang ? kStep : column;
    }

    Bracket opened(std::size_t i, std::size_t column) const {
        const bool inner_blank = i + 1 < layout.item_.size() && layout.gaps_[i + 1].blank;
        const std::size_t content = state.column + (inner_blank ? 1 : 0);
        const bool hangs = !last_in_line(i) && column <= kMaxHang + kStep + padding;
        return {column, hangs ? content : state.indent + kStep, state.indent, hangs};
    }
};

Layout::Layout(const std::vector<Piece>& item) : item_(item), gaps_(gaps_of(item)), breaks_(item.size(), false), arrow_(item.size()) {
    for (std::size_t i = 0; i < item.size(); ++i) {
        const bool arrow = item[i].is(TokenKind::ViewArrow) || item[i].is(TokenKind::LinearArrow);
        if (arrow && gaps_[i].depth == 0 && arrow_ == item.size()) arrow_ = i;
        if (i == 0) continue;
        // After a line comment the line ends, whatever follows.
        const bool must = item[i - 1].kind == Piece::Kind::LineComment;
        const bool wanted = item[i].own_line() && (gaps_[i].may_break || item[i].comment());
        breaks_[i] = must || wanted;
    }
    break_at_arrow();
    break_long_lines();
}

namespace {

// The cost of ending a line before a piece: the fewer open brackets the better; then by the pieces around it. Nothing: never.
std::optional<int> badness(const std::vector<Piece>& item, const std::vector<Gap>& gaps, std::size_t i) {
    const bool definition = item.front().is(TokenKind::Const) || item.front().is(TokenKind::Fun);
    if (!gaps[i].may_break || closes_bracket(item[i])) return std::nullopt;
    const Piece& before = item[i - 1];
    const auto rank = [&] {
        switch (item[i].token) {
            case TokenKind::Bar:
            case TokenKind::Then:
            case TokenKind::Else:
            case TokenKind::Otherwise:
                return 0;
            case TokenKind::And:
            case TokenKind::Or:
                return 2;
            case TokenKind::Plus:
            case TokenKind::Minus:
            case TokenKind::Append:
                return 4;
            case TokenKind::Star:
            case TokenKind::Slash:
                return 5;
            default:
                break;
        }
        if (before.is(TokenKind::Bar)) return 3;
        if (before.is(TokenKind::Comma) || before.is(TokenKind::Semicolon)) return 1;
        if (before.is(TokenKind::Equal) && gaps[i].depth == 0 && definition) return 3;
        return opens_bracket(before) ? 7 : 6;
    };
    return item[i].comment() ? std::nullopt : std::optional<int>(8 * gaps[i].depth + rank());
}

}  // namespace

// A rule that consumes is first broken before its arrow; a view after its arrow if the head leaves no room below.
void Layout::break_at_arrow() {
    if (arrow_ == item_.size()) return;
    Render render{*this, 0};
    while (render.state.next <= arrow_) render.line(render.state.next);
    if (render.state.column <= kMaxColumns) return;
    if (item_[arrow_].is(TokenKind::LinearArrow)) {
        breaks_[arrow_] = arrow_ > 0;
    } else if (render.state.body_column == kStep && arrow_ + 1 < item_.size()) {
        breaks_[arrow_ + 1] = true;
    }
}

void Layout::break_long_lines() {
    Render render{*this, 0};
    while (render.state.next < item_.size()) {
        const Render::State at_start = render.state;
        const std::size_t first = render.state.next;
        render.start_line(first);
        std::size_t best = 0;
        int least = std::numeric_limits<int>::max();
        bool too_long = false;
        // Of equally good places, the last that keeps the line short enough; if there is none, the first.
        do {
            const std::size_t i = render.state.next;
            const auto here = i > first ? badness(item_, gaps_, i) : std::nullopt;
            if (too_long && best > 0) break;
            if (here && *here <= least) {
                best = i;
                least = *here;
            }
            render.place(render.state.next++);
            too_long = render.state.column > kMaxColumns;
        } while (render.state.next < item_.size() && !breaks_[render.state.next]);
        if (!too_long || best == 0) continue;
        breaks_[best] = true;
        render.state = at_start;
        render.lines.pop_back();
        render.line(first);
    }
}

std::optional<Layout::View> Layout::view() const {
    if (arrow_ == 0 || arrow_ + 1 >= item_.size() || !item_[arrow_].is(TokenKind::ViewArrow)) return std::nullopt;
    for (std::size_t i = 1; i <= arrow_ + 1; ++i) {
        if (breaks_[i]) return std::nullopt;
    }
    View view{0, 0};
    for (std::size_t i = 0; i < arrow_; ++i) view.head += width(item_[i].text) + (i > 0 && gaps_[i].blank ? 1 : 0);
    for (const Line& line : lines()) view.widest_line = std::max(view.widest_line, width(line.code));
    return view;
}

std::vector<Line> Layout::lines(std::size_t padding) const {
    Render render{*this, padding};
    render.run();
    return std::move(render.lines);
}

}  // namespace meld::format
