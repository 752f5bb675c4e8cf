#include "runtime/ask/dap/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace meld::dap {

namespace {

constexpr std::string_view kBlanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(kBlanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

// Of which names of predicates are made.
constexpr std::string_view kWord = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-?";
bool in_word(char c) { return kWord.find(c) != std::string_view::npos; }

// Calls back with each character outside of strings, its place, and how many brackets are open around it.
template <class Call>
void each_outside(std::string_view text, const Call& call) {
    int depth = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\') ++i;
            quoted = c != '"';
            continue;
        }
        quoted = c == '"';
        if (c == ')' || c == ']' || c == '}') --depth;
        call(c, i, depth);
        if (c == '(' || c == '[' || c == '{') ++depth;
    }
}

// What stands between the commas that no bracket is around.
std::vector<std::string_view> parts_of(std::string_view text) {
    std::vector<std::string_view> out;
    std::size_t begin = 0;
    each_outside(text, [&](char c, std::size_t at, int depth) {
        if (c != ',' || depth != 0) return;
        out.push_back(trimmed(text.substr(begin, at - begin)));
        begin = at + 1;
    });
    out.push_back(trimmed(text.substr(begin)));
    return out;
}

// Where the first bracket that opens is closed.
std::size_t closing(std::string_view text, std::size_t open) {
    std::size_t found = std::string_view::npos;
    each_outside(text, [&](char c, std::size_t at, int depth) {
        if (c == ')' && depth == 0 && at > open) found = std::min(found, at);
    });
    return found;
}

}  // namespace

Result<Json> ask_line(Run& run, std::string_view text) {
    std::string line(trimmed(text));
    if (line.empty()) return fail("there is nothing to ask");
    if (line.size() > kMaxLine_bytes)
        return fail(fmt::format("{} bytes are too long for a line: there may be {}", line.size(), kMaxLine_bytes));
    for (char& c : line)
        if (static_cast<unsigned char>(c) < ' ') c = ' ';
    return run.ask(line);
}

std::string_view first_word(std::string_view line) {
    line = trimmed(line);
    return line.substr(0, std::min(line.find_first_of(kBlanks), line.size()));
}

Values bindings_in(std::string_view way) {
    Values out;
    for (const std::string_view pair : parts_of(way))
        if (const std::size_t equals = pair.find(" = "); equals != std::string_view::npos)
            out.emplace_back(trimmed(pair.substr(0, equals)), trimmed(pair.substr(equals + 3)));
    return out;
}

std::string with_values(std::string_view text, const Values& values) {
    std::string out;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size();) {
        std::size_t end = i;
        while (!quoted && end < text.size() && in_word(text[end]) && text[end] != '-') ++end;
        const std::string_view word = text.substr(i, std::max<std::size_t>(end - i, 1));
        if (word == "\"" && (i == 0 || text[i - 1] != '\\')) quoted = !quoted;
        const auto value = std::ranges::find(values, word, [](const auto& pair) { return std::string_view(pair.first); });
        out += value != values.end() ? value->second : std::string(word);
        i += word.size();
    }
    return out;
}

std::string_view head_of(std::string_view rule) {
    const std::size_t arrow = rule.find(":-");
    return arrow == std::string_view::npos ? std::string_view{} : trimmed(rule.substr(0, arrow));
}

std::vector<std::string> atoms_of(std::string_view rule) {
    std::vector<std::string> out;
    const std::size_t arrow = rule.find(":-");
    if (arrow == std::string_view::npos) return out;
    std::string_view body = trimmed(rule.substr(arrow + 2));
    if (body.ends_with('.')) body.remove_suffix(1);
    for (const std::string_view part : parts_of(body)) {
        const std::size_t open = part.find_first_not_of(kWord);
        if (open != std::string_view::npos && open > 0 && part[open] == '(' && closing(part, open) + 1 == part.size())
            out.emplace_back(part);
    }
    return out;
}

std::string_view word_before(std::string_view text, std::size_t place) {
    place = std::min(place, text.size());
    std::size_t begin = place;
    while (begin > 0 && in_word(text[begin - 1])) --begin;
    return text.substr(begin, place - begin);
}

std::size_t byte_offset(std::string_view text, std::size_t units) {
    std::size_t at = 0;
    for (std::size_t seen = 0; at < text.size() && seen < units; ++at) {
        const auto byte = static_cast<unsigned char>(text[at]);
        // The first byte of a character counts for all of it; one of four bytes is two units.
        if ((byte & 0xc0) != 0x80) seen += byte >= 0xf0 ? 2 : 1;
        while (at + 1 < text.size() && (static_cast<unsigned char>(text[at + 1]) & 0xc0) == 0x80) ++at;
    }
    return at;
}

std::string_view catom_in(std::string_view text) {
    text = trimmed(text);
    if (text.size() < 2 || text.size() > 20 || text.front() != '@') return {};
    text.remove_prefix(1);
    return std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; }) ? text : std::string_view{};
}

}  // namespace meld::dap
