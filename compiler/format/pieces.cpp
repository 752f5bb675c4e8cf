// The scanner drops comments, so they are found again in the gaps between its tokens; in a gap there is nothing else but white space.
#include "compiler/format/pieces.h"

#include <utility>

#include "runtime/base/assert.h"

namespace meld::format {

namespace {

constexpr std::size_t kTab = 8;

std::string without_blanks_at_line_ends(std::string_view text) {
    std::string result;
    for (const char letter : text) {
        if (letter == '\n') {
            while (!result.empty() && (result.back() == ' ' || result.back() == '\t' || result.back() == '\r')) result.pop_back();
        }
        result += letter;
    }
    while (!result.empty() && (result.back() == ' ' || result.back() == '\t' || result.back() == '\r')) result.pop_back();
    return result;
}

// The length of the comment that starts the text: to the end of its line, or of the outermost of nested ones.
std::size_t comment_size(std::string_view text) {
    if (!text.starts_with("/*")) {
        const std::size_t end = text.find('\n');
        return end == std::string_view::npos ? text.size() : end;
    }
    int depth = 0;
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
        const std::string_view two = text.substr(i, 2);
        if (two == "/*") ++depth;
        if (two == "*/") --depth;
        if (two == "/*" || two == "*/") ++i;
        if (depth == 0) return i + 1;
    }
    return text.size();
}

class Collector {
  public:
    explicit Collector(std::string_view text) : text_(text) {}

    std::vector<Piece> run(const std::vector<syntax::Token>& tokens) {
        for (const syntax::Token& token : tokens) {
            read_gap(token.span.begin);
            if (token.kind == TokenKind::End) break;
            add(Piece::Kind::Token, token.kind, token.span.end - token.span.begin);
        }
        return std::move(pieces_);
    }

  private:
    void read_gap(std::size_t end) {
        while (at_ < end) {
            const std::string_view rest = text_.substr(at_, end - at_);
            if (rest.starts_with("/*")) {
                add(Piece::Kind::BlockComment, TokenKind::End, comment_size(rest));
            } else if (rest.starts_with("//") || rest.starts_with(";;")) {
                add(Piece::Kind::LineComment, TokenKind::End, comment_size(rest));
            } else {
                skip(rest.front());
            }
        }
    }

    void skip(char letter) {
        apart_ = true;
        if (letter == '\n') ++newlines_;
        advance(letter);
        ++at_;
    }

    void advance(char letter) {
        if (letter == '\n') {
            column_ = code_end_ = 0;
        } else if (letter == '\t') {
            column_ = (column_ / kTab + 1) * kTab;
        } else if ((static_cast<unsigned char>(letter) & 0xc0) != 0x80) {
            ++column_;
        }
    }

    void add(Piece::Kind kind, TokenKind token, std::size_t size) {
        MELD_EXPECT(size > 0 && at_ + size <= text_.size(), "{} bytes at {} of {}", size, at_, text_.size());
        const std::string_view written = text_.substr(at_, size);
        Piece piece{.kind = kind,
                    .token = token,
                    .text = without_blanks_at_line_ends(written),
                    .newlines_before = newlines_,
                    .apart = apart_,
                    .column = column_,
                    .code_end = code_end_};
        // `[ <-` is one token, whose blanks mean nothing.
        if (token == TokenKind::NeighbourOpen) std::erase_if(piece.text, [](char letter) { return letter == ' ' || letter == '\t'; });
        pieces_.push_back(std::move(piece));
        for (const char letter : written) advance(letter);
        at_ += size;
        if (kind == Piece::Kind::Token) code_end_ = column_;
        newlines_ = 0;
        apart_ = kind != Piece::Kind::Token;
    }

    std::string_view text_;
    std::vector<Piece> pieces_;
    std::size_t at_ = 0;
    std::size_t column_ = 0;
    std::size_t code_end_ = 0;
    std::uint32_t newlines_ = 0;
    bool apart_ = false;
};

}  // namespace

std::vector<Piece> pieces_of(const source::File& file, const std::vector<syntax::Token>& tokens) {
    // A byte order mark is no gap.
    const std::string_view text = file.text();
    const std::size_t mark = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
    std::vector<syntax::Token> shifted = tokens;
    for (syntax::Token& token : shifted) {
        token.span.begin -= static_cast<std::uint32_t>(mark);
        token.span.end -= static_cast<std::uint32_t>(mark);
    }
    return Collector(text.substr(mark)).run(shifted);
}

std::size_t width(std::string_view text) {
    std::size_t columns = 0;
    for (const char letter : text) columns += (static_cast<unsigned char>(letter) & 0xc0) != 0x80 ? 1 : 0;
    return columns;
}

std::vector<Entry> entries_of(std::vector<Piece> pieces) {
    std::vector<Entry> entries;
    std::size_t at = 0;
    const auto is = [&](std::size_t index, TokenKind kind) { return index < pieces.size() && pieces[index].is(kind); };
    while (at < pieces.size()) {
        Entry entry;
        entry.blank_before = pieces[at].newlines_before > 1;
        // Comments are alone unless code follows them in their last line.
        std::size_t code = at;
        while (code < pieces.size() && pieces[code].comment() && (code == at || !pieces[code].own_line())) ++code;
        if (code > at && (code == pieces.size() || pieces[code].own_line())) {
            while (at < code) entry.comments.push_back(std::move(pieces[at++]));
            entries.push_back(std::move(entry));
            continue;
        }
        bool ended = false;
        while (at < pieces.size() && !ended) {
            const Piece& piece = pieces[at];
            // An include needs no full stop.
            const bool include = piece.is(TokenKind::IncludePath) ||
                                 (piece.is(TokenKind::String) && at > 0 && (is(at - 1, TokenKind::Include) || is(at - 1, TokenKind::Use)));
            const bool named = is(at + 1, TokenKind::Name) && pieces[at + 1].text == "as";
            ended = piece.is(TokenKind::Period) || (include && !named && !is(at + 1, TokenKind::Period));
            entry.item.push_back(std::move(pieces[at++]));
        }
        while (at < pieces.size() && pieces[at].comment() && !pieces[at].own_line()) entry.comments.push_back(std::move(pieces[at++]));
        MELD_ASSERT(!entry.item.empty(), "an entry of nothing at piece {}", at);
        entries.push_back(std::move(entry));
    }
    return entries;
}

}  // namespace meld::format
