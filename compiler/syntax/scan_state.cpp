// Values of tokens, and the mistakes that a scanner can find.
#include "compiler/syntax/scan_state.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::syntax {

using diagnostics::Kind;

namespace {

// After this many characters that start no token the file is assumed not to be Meld, and the rest is not reported.
constexpr std::size_t kMaxUnexpected = 20;

// One past the largest int: legal only as the digits of the smallest one.
constexpr std::uint64_t kTwoTo63 = std::uint64_t{1} << 63;

// What Meld writes for a sign of papers, word processors or other languages; empty if that is not known.
std::string_view in_meld(std::string_view written) {
    static constexpr std::pair<std::string_view, std::string_view> kSigns[] = {
        {"#", "//"},           {"\\+", "not "},        {"\xc2\xa0", " "},      {"\xe2\x80\x93", "-"},
        {"\xe2\x88\x92", "-"}, {"\xe2\x89\xa0", "<>"}, {"\xe2\x89\xa4", "<="}, {"\xe2\x89\xa5", ">="},
        {"\xc3\x97", "*"},     {"\xe2\x88\xa7", ","}};
    for (const auto& [sign, meld] : kSigns)
        if (written == sign) return meld;
    return "";
}

}  // namespace

Token& ScanState::push(TokenKind kind) {
    MELD_EXPECT(begin_ <= end_ && (tokens_.empty() || tokens_.back().span.end <= begin_), "a token from {} to {}", begin_, end_);
    Token token;
    token.kind = kind;
    token.span = span();
    token.first_on_line = at_line_start_;
    token.damaged = damaged_;
    tokens_.push_back(std::move(token));
    at_line_start_ = false;
    damaged_ = false;
    return tokens_.back();
}

diagnostics::Diagnostic& ScanState::wrong(Kind kind, Span where, std::string message) {
    damaged_ = true;
    return report_.add(kind, where, std::move(message));
}

void ScanState::number_out_of_range(std::string_view limits) {
    wrong(Kind::NumberOutOfRange, span(), "this number does not fit").help = limits;
}

void ScanState::integer(TokenKind kind, const char* written, const char* digits) {
    MELD_EXPECT(kind == TokenKind::Int || kind == TokenKind::Catom, "`{}` is not an int", written);
    Token& token = push(kind);
    token.text = written;
    const std::string_view view(digits);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), value);
    const std::uint64_t largest = kind == TokenKind::Int ? kTwoTo63 : static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (error != std::errc() || value > largest) {
        number_out_of_range("an int lies between -9223372036854775808 and 9223372036854775807");
        token.text = kind == TokenKind::Int ? "0" : "@0";
        return;
    }
    token.integer = static_cast<std::int64_t>(value);
}

void ScanState::real(const char* written) {
    Token& token = push(TokenKind::Float);
    token.text = written;
    const std::string_view view(written);
    double value = 0;
    std::from_chars(view.data(), view.data() + view.size(), value);
    // from_chars leaves 0 for numbers that are too large or too small; strtod distinguishes them.
    if (value == 0) value = std::strtod(written, nullptr);
    if (!std::isfinite(value)) {
        number_out_of_range("a float is at most 1.797e308");
        token.text = "0.0";
        value = 0;
    }
    token.real = value;
}

void ScanState::bad_number() {
    wrong(Kind::UnexpectedCharacter, span(), "this is neither a number nor a name").help =
        "a name starts with a letter; put a blank or an operator between a number and a name";
    // A number stands in for it, so that the rule around it is not reported as well.
    push(TokenKind::Int).text = "0";
}

void ScanState::run_argument(const char* written) {
    Token& token = push(TokenKind::RunArgument);
    MELD_EXPECT(std::string_view(written).starts_with("@arg"), "`{}` is not a run argument", written);
    const std::string_view digits = std::string_view(written).substr(4);
    token.integer = digits.size() == 1 && digits[0] != '0' ? digits[0] - '0' : 0;
    if (token.integer != 0) return;
    wrong(Kind::UnexpectedCharacter, span(), "there is no run argument with this number").help = "run arguments are @arg1 to @arg9";
    token.integer = 1;
}

void ScanState::delay(const char* written) {
    Token& token = push(TokenKind::Delay);
    const std::string_view whole(written);
    // Blanks may stand around the plus.
    const std::size_t number = whole.find_first_of("0123456789");
    MELD_EXPECT(number != std::string_view::npos && number > 0, "`{}` is not a delay", written);
    // A negative delay is invalid, which is reported where delays are checked.
    const bool negative = whole[number - 1] == '-';
    token.real = (negative ? -1 : 1) * std::strtod(written + number, nullptr);
    // strtod takes the e of a unit as an exponent; a delay has none.
    const std::size_t unit = whole.find_first_not_of("0123456789.", number);
    token.text = unit == std::string_view::npos ? "" : std::string(whole.substr(unit));
    if (!std::isfinite(token.real)) {
        number_out_of_range("give the delay in seconds, @+2s");
        token.real = 0;
    }
    if (token.text.empty() || token.text == "s" || token.text == "ms") return;
    wrong(Kind::UnexpectedCharacter, span(), fmt::format("`{}` is not a unit of time", token.text)).help =
        "write @+2s for seconds, @+250ms for milliseconds, @+3 for ticks";
    token.text = "s";
}

void ScanState::computed_delay() {
    wrong(Kind::SyntaxError, span(), "a delay is a literal number: nothing is computed in it").help =
        "write @+3 for ticks, @+250ms or @+2s for times; to wait for a computed number of ticks,\n"
        "count down: `wait(A, N), N > 0 -o wait(A, N - 1)@+1.`";
    // A delay replaces it, so that the rule around it is not reported as well.
    push(TokenKind::Delay).real = 1;
}

void ScanState::foreign_comment() {
    if (++unexpected_count_ > kMaxUnexpected) return;
    auto& diagnostic = report_.add(Kind::UnexpectedCharacter, {file_, begin_, begin_ + 1}, "`#` starts no comment");
    diagnostic.fixes = {diagnostics::safe(diagnostics::write(diagnostic.span, "//"))};
    diagnostic.help =
        unexpected_count_ == kMaxUnexpected ? "more of these are not shown; is this file a Meld program?" : "comments start with `//`";
}

void ScanState::include_path(std::string_view written) {
    MELD_EXPECT(!written.empty(), "an include of nothing at {}", begin_);
    Token& token = push(TokenKind::IncludePath);
    const bool quoted = written.back() == '"' || written.back() == '>';
    if (quoted) {
        const std::size_t open = written.find_first_of("\"<");
        MELD_ASSERT(open + 2 <= written.size(), "`{}` has one quote", written);
        token.text = written.substr(open + 1, written.size() - open - 2);
        return;
    }
    token.text = written.substr(written.find('#') + 1);
    if (!token.text.empty() && token.text.back() == '.') token.text.pop_back();
}

void ScanState::unexpected_character(std::string_view written, std::string_view help) {
    damaged_ = true;
    if (++unexpected_count_ > kMaxUnexpected) return;
    auto& diagnostic =
        wrong(Kind::UnexpectedCharacter, span(),
              fmt::format("{} nothing in Meld", end_ - begin_ == 1 || help.empty() ? "this character starts" : "this means"));
    diagnostic.help = help;
    if (const std::string_view meld = in_meld(written); !meld.empty()) diagnostic.fixes = {diagnostics::write(span(), std::string(meld))};
    if (unexpected_count_ == kMaxUnexpected) diagnostic.help = "more of these are not shown; is this file a Meld program?";
}

void ScanState::single_quotes() {
    auto& diagnostic = wrong(Kind::UnexpectedCharacter, span(), "a string has double quotes, not single ones");
    diagnostic.help = R"(write "text", in double quotes)";
    diagnostic.fixes = {{.title = "Write double quotes", .edits = {{{file_, begin_, begin_ + 1}, "\""}, {{file_, end_ - 1, end_}, "\""}}}};
    // A text stands in for it, so that the rule around it is not reported as well.
    push(TokenKind::String);
}

void ScanState::open_comment() { comments_.push_back(begin_); }

bool ScanState::close_comment() {
    MELD_EXPECT(!comments_.empty(), "no comment is open at {}", begin_);
    comments_.pop_back();
    return comments_.empty();
}

void ScanState::comment_never_ends() {
    MELD_EXPECT(!comments_.empty(), "no comment is open at {}", end_);
    const Span inner{file_, comments_.back(), comments_.back() + 2};
    const Span outer{file_, comments_.front(), comments_.front() + 2};
    auto& diagnostic = wrong(Kind::UnterminatedComment, inner, "this comment never ends");
    diagnostic.help = "close it with */; comments nest, so each /* needs its own */";
    if (comments_.size() > 1) diagnostic.labels = {{outer, "it stands inside this one"}};
}

void ScanState::open_text() {
    text_begin_ = begin_;
    text_.clear();
}

void ScanState::text_byte(const char* hex_digits) {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(hex_digits, hex_digits + 2, value, 16);
    MELD_EXPECT(error == std::errc() && end == hex_digits + 2, "not two hexadecimal digits at {}", begin_);
    text_ += static_cast<char>(value);
}

void ScanState::text_escape(char letter) {
    switch (letter) {
        case 'n':
            text_ += '\n';
            return;
        case 't':
            text_ += '\t';
            return;
        case 'r':
            text_ += '\r';
            return;
        case '"':
        case '\\':
            text_ += letter;
            return;
        default: {
            auto& diagnostic = wrong(Kind::UnexpectedCharacter, span(), "there is no such escape in a string");
            diagnostic.help = R"(escapes are \n \t \r \" \\ and \x41 for a byte; a backslash itself is \\)";
            diagnostic.fixes = {diagnostics::insert(span(), "\\")};
        }
    }
}

void ScanState::close_text() {
    MELD_EXPECT(text_begin_ < end_, "a string from {} to {}", text_begin_, end_);
    begin_ = text_begin_;
    push(TokenKind::String).text = std::move(text_);
    text_.clear();
}

void ScanState::text_never_ends(bool at_line_end) {
    const std::uint32_t text_end = at_line_end ? end_ - 1 : end_;
    auto& diagnostic = wrong(Kind::UnterminatedString, {file_, text_begin_, text_end}, "this string has no closing quote");
    diagnostic.help = R"(a string ends on the line where it starts; write \n for a new line)";
    // Brackets and a full stop at the end of the line are more likely those of the rule.
    const std::size_t last = text_.find_last_not_of(" \t\r.)]}");
    const std::size_t behind = last == std::string::npos ? 0 : text_.size() - last - 1;
    const auto quote = static_cast<std::uint32_t>(text_end - std::min<std::size_t>(behind, text_end - text_begin_ - 1));
    diagnostic.fixes = {{.title = "Close the string", .edits = {{{file_, quote, quote}, "\""}}}};
    const std::uint32_t resume = end_;
    end_ = text_end;
    close_text();
    end_ = resume;
    if (at_line_end) new_line();
    tokens_.back().damaged = true;
    damaged_ = false;
}

std::vector<Token> ScanState::take_tokens() {
    begin_ = end_;
    push(TokenKind::End);
    return std::move(tokens_);
}

}  // namespace meld::syntax
