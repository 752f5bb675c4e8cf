// Token names, the test whether a file is text at all, and the scan of a whole file.
#include "compiler/syntax/tokens.h"

#include <algorithm>

#include <array>
#include <limits>

#include "compiler/syntax/scan_state.h"

namespace meld::syntax {

namespace {

constexpr std::array<std::string_view, 2> kTable[] = {
#define MELD_TOKEN(name, description) {#name, description},
#include "compiler/syntax/tokens.def"
#include "runtime/base/assert.h"
#undef MELD_TOKEN
};

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

}  // namespace

std::string_view kind_name(TokenKind kind) { return kTable[static_cast<std::size_t>(kind)][0]; }
std::string_view description(TokenKind kind) { return kTable[static_cast<std::size_t>(kind)][1]; }

bool starts_declaration(TokenKind kind) {
    switch (kind) {
        case TokenKind::Type:
        case TokenKind::Const:
        case TokenKind::Fun:
        case TokenKind::Extern:
        case TokenKind::Node:
        case TokenKind::Import:
        case TokenKind::Export:
        case TokenKind::Module:
        case TokenKind::Hint:
        case TokenKind::Include:
        case TokenKind::IncludePath:
        case TokenKind::Use:
            return true;
        default:
            return false;
    }
}

bool is_atom(TokenKind kind) {
    switch (kind) {
        case TokenKind::Name:
        case TokenKind::Variable:
        case TokenKind::Anonymous:
        case TokenKind::Int:
        case TokenKind::Float:
        case TokenKind::String:
        case TokenKind::Catom:
            return true;
        default:
            return false;
    }
}

bool is_closing(TokenKind kind) {
    return kind == TokenKind::RightParen || kind == TokenKind::RightBracket || kind == TokenKind::RightBrace;
}

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

std::size_t utf8_sequence_size(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const auto follows = [&](std::size_t i) { return (byte(i) & 0xc0) == 0x80; };
    const unsigned lead = byte(0);
    if (lead < 0x80) return lead == 0 ? 0 : 1;
    if (lead >= 0xc2 && lead <= 0xdf) return follows(1) ? 2 : 0;
    if (lead >= 0xe0 && lead <= 0xef) {
        const bool overlong = lead == 0xe0 && byte(1) < 0xa0;
        const bool surrogate = lead == 0xed && byte(1) > 0x9f;
        return follows(1) && follows(2) && !overlong && !surrogate ? 3 : 0;
    }
    if (lead >= 0xf0 && lead <= 0xf4) {
        const bool overlong = lead == 0xf0 && byte(1) < 0x90;
        const bool too_large = lead == 0xf4 && byte(1) > 0x8f;
        return follows(1) && follows(2) && follows(3) && !overlong && !too_large ? 4 : 0;
    }
    return 0;
}

std::size_t text_end(std::string_view text) {
    std::size_t offset = 0;
    while (offset < text.size()) {
        const std::size_t size = utf8_sequence_size(text.substr(offset));
        if (size == 0) break;
        offset += size;
    }
    MELD_ENSURE(offset <= text.size(), "{} of {} bytes", offset, text.size());
    return offset;
}

std::vector<Token> scan(const source::File& file, std::uint32_t file_index, diagnostics::Reporter& report) {
    const std::string_view text = file.text();
    MELD_EXPECT(text.size() <= std::numeric_limits<std::uint32_t>::max(), "a file of {} bytes", text.size());
    const std::size_t good = text_end(text);
    const std::size_t begin = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
    ScanState state(file_index, static_cast<std::uint32_t>(begin), report);
    if (good == text.size()) {
        run_scanner(state, text.substr(begin));
        return state.take_tokens();
    }
    const auto bad = static_cast<std::uint32_t>(good);
    report
        .add(diagnostics::Kind::InvalidText, {file_index, bad, bad + 1},
             text[good] == '\0' ? "a program cannot contain a NUL byte" : "this byte is not UTF-8 text")
        .help = "save the file as UTF-8 text; none of it was read";
    return state.take_tokens();
}

}  // namespace meld::syntax
