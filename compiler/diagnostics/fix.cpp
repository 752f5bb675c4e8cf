#include "compiler/diagnostics/fix.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::diagnostics {

using Fit = Edit::Fit;

bool Edit::operator==(const Edit& other) const {
    return std::tie(span.file, span.begin, span.end, text, fit) ==
           std::tie(other.span.file, other.span.begin, other.span.end, other.text, other.fit);
}

// ---- the usual fixes

Fix write(Span span, std::string text, Fit fit) {
    // Of several lines the first says enough.
    std::string title = fmt::format("Write `{}`", text.substr(0, text.find('\n')));
    return {.title = std::move(title), .edits = {{span, std::move(text), fit}}};
}

Fix leave_out(Span span, std::string_view what, Fit fit) {
    return {.title = fmt::format("Leave out {}", what), .edits = {{span, "", fit}}};
}

Fix insert(Span place, std::string text) {
    const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
    std::string title = fmt::format("Insert `{}`", first == std::string::npos ? text : text.substr(first, last - first + 1));
    return {.title = std::move(title), .edits = {{{place.file, place.begin, place.begin}, std::move(text)}}};
}

Fix call_around(Span span, std::string_view function) {
    return {.title = fmt::format("Write `{}(...)`", function),
            .edits = {{{span.file, span.begin, span.begin}, std::string(function) + "("}, {{span.file, span.end, span.end}, ")"}}};
}

Fix safe(Fix fix) {
    fix.safe = true;
    return fix;
}

// ---- the text around them

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_space(char c) { return is_blank(c) || c == '\n'; }
bool is_of_name(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '?' || c == '\'';
}

// Steps over the text of one file.
class Fitting {
  public:
    explicit Fitting(std::string_view text) : text_(text) {}

    Edit exact(Edit edit) const {
        MELD_EXPECT(edit.span.begin <= edit.span.end && edit.span.end <= text_.size(), "bytes {} to {} of {}", edit.span.begin,
                    edit.span.end, text_.size());
        switch (std::exchange(edit.fit, Fit::Exact)) {
            case Fit::Exact:
                return edit;
            case Fit::Name:
                edit.span.end = past(edit.span.begin, is_of_name);
                return edit;
            case Fit::Word:
                return word(std::move(edit));
            case Fit::Element:
                return element(std::move(edit));
            case Fit::Sign:
                if (!starts_line(edit.span.begin)) edit.span.begin = before(edit.span.begin, is_blank);
                return edit;
            case Fit::Item:
                return item(std::move(edit));
            case Fit::Before:
                edit.span.end = edit.span.begin;
                edit.text += starts_line(edit.span.begin) ? line_end(before_line(edit.span.begin)) : " ";
                return edit;
            case Fit::After:
                return after(std::move(edit));
        }
        return edit;
    }

  private:
    template <class Is>
    std::uint32_t past(std::size_t at, Is is) const {
        while (at < text_.size() && is(text_[at])) ++at;
        return static_cast<std::uint32_t>(at);
    }
    template <class Is>
    std::uint32_t before(std::size_t at, Is is) const {
        while (at > 0 && is(text_[at - 1])) --at;
        return static_cast<std::uint32_t>(at);
    }
    bool has(std::size_t at, char c) const { return at < text_.size() && text_[at] == c; }
    // Where the line before ends.
    std::size_t before_line(std::size_t at) const {
        const std::size_t begin = before(at, is_blank);
        return begin == 0 ? 0 : begin - 1;
    }
    bool starts_line(std::size_t at) const {
        const std::size_t begin = before(at, is_blank);
        return begin == 0 || text_[begin - 1] == '\n';
    }
    bool ends_line(std::size_t at) const {
        at = past(at, is_blank);
        return at == text_.size() || text_[at] == '\n';
    }
    // As the lines around it end, of which one ends here.
    const char* line_end(std::size_t at) const { return at > 0 && text_[at - 1] == '\r' ? "\r\n" : "\n"; }
    bool ends_line_or_comment(std::size_t at) const { return ends_line(at) || text_.substr(past(at, is_blank)).starts_with("//"); }

    // The full stop of the item that ends here belongs to it.
    std::uint32_t behind_item(std::uint32_t end) const {
        const std::uint32_t stop = past(end, is_space);
        return has(stop, '.') ? stop + 1 : end;
    }

    Edit word(Edit edit) const {
        if (!edit.text.empty()) return edit;
        const auto is_gap = [](char c) { return c == ' ' || c == '\t'; };
        const std::uint32_t end = past(edit.span.end, is_gap);
        const auto name_follows = [&] { return edit.span.end < text_.size() && is_of_name(text_[edit.span.end]); };
        if (end > edit.span.end)
            edit.span.end = end;
        else if (!name_follows())
            edit.span.begin = before(edit.span.begin, is_gap);
        // not!p(A): what stands on both sides must not become one name.
        if (edit.span.begin > 0 && is_of_name(text_[edit.span.begin - 1]) && name_follows()) edit.text = " ";
        return edit;
    }

    Edit element(Edit edit) const {
        const std::uint32_t next = past(edit.span.end, is_space), last = before(edit.span.begin, is_space);
        if (has(next, ',')) {
            edit.span.end = past(next + 1, is_space);
            edit.text.clear();
        } else if (last > 0 && text_[last - 1] == ',' && !may_end_comment(last, edit.span.begin)) {
            edit.span.begin = last - 1;
            edit.text.clear();
        }
        return edit;
    }

    // Whether what stands before `end`, on an earlier line than `at`, may belong to a comment.
    bool may_end_comment(std::size_t end, std::size_t at) const {
        const std::string_view line = text_.substr(0, end).substr(before(end, [](char c) { return c != '\n'; }));
        return text_.substr(end, at - end).find('\n') != std::string_view::npos && line.find("//") != std::string_view::npos;
    }

    Edit item(Edit edit) const {
        edit.span.end = behind_item(edit.span.end);
        const bool lines = starts_line(edit.span.begin) && ends_line(edit.span.end);
        edit.span.end = past(edit.span.end, is_blank);
        if (!lines) return edit;
        edit.span.begin = before(edit.span.begin, is_blank);
        if (has(edit.span.end, '\n')) ++edit.span.end;
        return edit;
    }

    Edit after(Edit edit) const {
        std::uint32_t at = behind_item(edit.span.end);
        const bool line = ends_line_or_comment(at);
        if (line) at = past(at, [](char c) { return c != '\n'; });
        const char* const end = line_end(at);
        if (line && at > 0 && text_[at - 1] == '\r') --at;
        edit.span.begin = edit.span.end = at;
        edit.text.insert(0, line ? end : " ");
        return edit;
    }

    std::string_view text_;
};

}  // namespace

std::string_view name_at(const source::FileSet& files, Span span) {
    const std::string_view text = files.text(span);
    return text.substr(0, static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_of_name) - text.begin()));
}

std::vector<Fix> exact(const source::FileSet& files, const std::vector<Fix>& fixes, const std::function<bool(std::uint32_t)>& may_change) {
    std::vector<Fix> result;
    for (const Fix& fix : fixes) {
        if (fix.edits.empty() ||
            !std::all_of(fix.edits.begin(), fix.edits.end(), [&](const Edit& edit) { return may_change(edit.span.file); }))
            continue;
        Fix& one = result.emplace_back(Fix{.title = fix.title, .edits = {}, .safe = fix.safe});
        for (const Edit& edit : fix.edits) one.edits.push_back(Fitting(files.file(edit.span).text()).exact(edit));
    }
    return result;
}

bool Edits::fits(const Edit& edit) const {
    const auto next = edits_.lower_bound(edit.span.begin);
    if (next != edits_.end() && next->first == edit.span.begin) return next->second == edit;
    if (next != edits_.end() && next->first < edit.span.end) return false;
    return next == edits_.begin() || std::prev(next)->second.span.end <= edit.span.begin;
}

void Edits::add(const Edit& edit) {
    MELD_EXPECT(edit.fit == Fit::Exact && fits(edit), "an edit at {} in the way of another", edit.span.begin);
    edits_.emplace(edit.span.begin, edit);
}

std::string Edits::applied(const std::string& text) const {
    std::string result;
    std::size_t copied = 0;
    for (const auto& [begin, edit] : edits_) {
        result.append(text, copied, begin - copied);
        result += edit.text;
        copied = edit.span.end;
    }
    return result.append(text, copied);
}

}  // namespace meld::diagnostics
