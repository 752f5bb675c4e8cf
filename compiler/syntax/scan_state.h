// The actions of the scanner's rules: they build tokens, and report invalid characters. One object per scanned file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/syntax/tokens.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

class ScanState {
  public:
    ScanState(std::uint32_t file, std::uint32_t begin, diagnostics::Reporter& report)
        : file_(file), begin_(begin), end_(begin), report_(report) {}

    // Called before every rule: the next `size` bytes are what the rule matched.
    void advance(std::size_t size) {
        MELD_EXPECT(size > 0, "a rule that matches nothing, at {}", end_);
        begin_ = end_;
        end_ += static_cast<std::uint32_t>(size);
    }
    void new_line() { at_line_start_ = true; }

    void plain(TokenKind kind) { push(kind); }
    void word(TokenKind kind, const char* text) { push(kind).text = text; }
    // `written` is the whole token, `digits` its number.
    void integer(TokenKind kind, const char* written, const char* digits);
    void real(const char* written);
    void bad_number();
    void run_argument(const char* written);
    void delay(const char* written);
    // @+N, @+(N + 1), or nothing after the plus.
    void computed_delay();
    // A line that is a comment in another language.
    void foreign_comment();
    void include_path(std::string_view written);
    void unexpected_character(std::string_view written, std::string_view help = {});
    void single_quotes();

    void open_comment();
    // True when the outermost comment is closed.
    bool close_comment();
    void comment_never_ends();

    void open_text();
    void text_piece(const char* bytes, std::size_t size) { text_.append(bytes, size); }
    void text_byte(const char* hex_digits);
    void text_escape(char letter);
    void close_text();
    // The line, or the file, ended before the closing quote.
    void text_never_ends(bool at_line_end);

    std::vector<Token> take_tokens();

  private:
    Span span() const { return {file_, begin_, end_}; }
    Token& push(TokenKind kind);
    void number_out_of_range(std::string_view limits);
    diagnostics::Diagnostic& wrong(diagnostics::Kind kind, Span where, std::string message);

    std::uint32_t file_;
    std::uint32_t begin_;
    std::uint32_t end_;
    diagnostics::Reporter& report_;
    bool at_line_start_ = true;
    std::vector<Token> tokens_;
    // The opening positions of the comments around the present place, outermost first.
    std::vector<std::uint32_t> comments_;
    std::uint32_t text_begin_ = 0;
    std::string text_;
    std::size_t unexpected_count_ = 0;
    // A mistake was reported since the last token.
    bool damaged_ = false;
};

// The generated scanner (scan.l): feeds the text to the state.
void run_scanner(ScanState& state, std::string_view text);

}  // namespace meld::syntax
