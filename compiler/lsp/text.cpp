// UTF-8 inside, UTF-16 outside: a character beyond the basic plane has four bytes here and two units there.
#include "compiler/lsp/text.h"

#include <algorithm>

#include "runtime/base/assert.h"

namespace meld::lsp {

namespace {

// UTF-16 units of the character that starts with this byte; 0 inside a character.
int units(char letter) {
    const auto byte = static_cast<unsigned char>(letter);
    if ((byte & 0xc0) == 0x80) return 0;
    return byte >= 0xf0 ? 2 : 1;
}

}  // namespace

Position position_of(const source::File& file, std::uint32_t offset) {
    MELD_EXPECT(offset <= file.text().size(), "byte {} of {}", offset, file.text().size());
    const source::Place place = file.place(offset);
    const std::string_view before = file.line(place.line).substr(0, place.column - 1);
    Position position{static_cast<int>(place.line) - 1, 0};
    for (const char letter : before) position.character += units(letter);
    return position;
}

Range range_of(const source::FileSet& files, Span span) {
    return {position_of(files.file(span), span.begin), position_of(files.file(span), span.end)};
}

std::size_t offset_of(std::string_view text, Position position) {
    std::size_t offset = 0;
    for (int line = 0; line < position.line; ++line) {
        const std::size_t newline = text.find('\n', offset);
        if (newline == std::string_view::npos) return text.size();
        offset = newline + 1;
    }
    int column = 0;
    while (offset < text.size() && text[offset] != '\n') {
        const int next = column + units(text[offset]);
        if (units(text[offset]) > 0 && next > position.character) break;
        column = next;
        ++offset;
    }
    // A carriage return belongs to the line's end.
    if (offset > 0 && offset < text.size() && text[offset] == '\n' && text[offset - 1] == '\r') --offset;
    return offset;
}

void apply_change(std::string& text, std::optional<Range> range, std::string_view replacement) {
    if (!range) {
        text = replacement;
        return;
    }
    const std::size_t begin = offset_of(text, range->start);
    const std::size_t end = std::max(begin, offset_of(text, range->end));
    MELD_ASSERT(begin <= end && end <= text.size(), "bytes {} to {} of {}", begin, end, text.size());
    text.replace(begin, end - begin, replacement);
}

}  // namespace meld::lsp
