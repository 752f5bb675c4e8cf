#include "runtime/ask/debug/completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <system_error>
#include <utility>

#include "runtime/ask/debug/command.h"

namespace meld::debug {

namespace {

// More than anybody wants to see listed.
constexpr std::size_t kMostCatoms = 200, kMostFiles = 2000;

bool is_blank(char c) { return c == ' ' || c == '\t'; }

bool belongs_to_name(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-'; }

// Within a string of a body nothing is a name.
bool ends_in_string(std::string_view text) {
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (quoted && text[i] == '\\')
            ++i;
        else if (text[i] == '"')
            quoted = !quoted;
    }
    return quoted;
}

class Line {
  public:
    Line(std::string_view text, const Vocabulary& known) : text_(text), known_(known) {
        const std::size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
        const std::size_t end = std::min(text.find_first_of(" \t", begin), text.size());
        command_ = text.substr(begin, end - begin);
        arguments_ = end;
        in_command_ = end == text.size();
        word_ = in_command_ ? begin : text.find_last_of(" \t") + 1;
    }

    Completion complete() {
        if (in_command_) return words(word_, commands(), " ");
        const std::string_view form = arguments_of(command_);
        const auto takes = [&](std::string_view what) { return form.find(what) != std::string_view::npos; };
        const bool first = text_.find_first_not_of(" \t", arguments_) >= word_;
        if (text_.substr(word_).starts_with("--")) return words(word_, options(form), " ");
        const bool digit = word_ < text_.size() && text_[word_] >= '0' && text_[word_] <= '9';
        if (takes("RULE") && first) return words(word_, digit ? known_.lines : known_.rules, " ");
        if (takes("FILE") || takes("DIR")) return files();
        if (takes("COMMAND")) return words(word_, commands(), "");
        if (takes("BODY") || takes("FACT")) return in_body();
        if (takes("@N") && text_.substr(word_).starts_with('@')) return catoms(word_);
        if (takes("NAME")) return words(word_, takes("@N") ? known_.predicates : known_.heads, "");
        return {};
    }

  private:
    static std::vector<std::string> commands() {
        const auto names = command_names();
        return {names.begin(), names.end()};
    }
    // [--all] [--depth N] FACT
    static std::vector<std::string> options(std::string_view form) {
        std::vector<std::string> out;
        for (std::size_t at = 0; (at = form.find("--", at)) != std::string_view::npos;) {
            const std::size_t end = std::min(form.find_first_of(" ]|", at), form.size());
            out.emplace_back(form.substr(at, end - at));
            at = end;
        }
        return out;
    }

    // Those that begin with what stands there.
    Completion words(std::size_t begin, std::vector<std::string> all, std::string after) const {
        const std::string_view typed = text_.substr(begin);
        std::erase_if(all, [&](const std::string& word) { return !word.starts_with(typed); });
        std::ranges::sort(all);
        const auto twice = std::ranges::unique(all);
        all.erase(twice.begin(), twice.end());
        return {.begin = begin, .words = std::move(all), .after = std::move(after)};
    }

    Completion catoms(std::size_t at) const {
        Completion out{.begin = at + 1};
        if (known_.catoms) out.words = known_.catoms(text_.substr(at + 1));
        return out;
    }

    Completion in_body() const {
        if (ends_in_string(text_.substr(arguments_))) return {};
        std::size_t begin = text_.size();
        while (begin > arguments_ && belongs_to_name(text_[begin - 1])) --begin;
        if (begin > 0 && text_[begin - 1] == '@') return catoms(begin - 1);
        return words(begin, known_.predicates, "(");
    }

    // The rest of the line is a path, which may have blanks in it.
    Completion files() const {
        namespace fs = std::filesystem;
        std::size_t begin = arguments_;
        while (begin < text_.size() && is_blank(text_[begin])) ++begin;
        const std::string typed(text_.substr(begin));
        const std::size_t slash = typed.rfind('/');
        const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
        std::error_code error;
        std::vector<std::string> found;
        fs::directory_iterator at(fs::path(known_.folder) / (name == 0 ? "." : typed.substr(0, name)), error);
        for (; !error && at != fs::directory_iterator() && found.size() < kMostFiles; at.increment(error)) {
            std::string each = at->path().filename().string();
            if (each.starts_with('.') && !std::string_view(typed).substr(name).starts_with('.')) continue;
            std::error_code none;
            if (at->is_directory(none)) each += '/';
            found.push_back(std::move(each));
        }
        return words(begin + name, std::move(found), "");
    }

    std::string_view text_, command_;
    const Vocabulary& known_;
    std::size_t arguments_ = 0;  // Where the command's name ends.
    std::size_t word_ = 0;       // Where the last word begins.
    bool in_command_ = false;
};

}  // namespace

Completion complete(std::string_view line, const Vocabulary& vocabulary) { return Line(line, vocabulary).complete(); }

std::vector<std::string> catoms_that_begin(std::string_view digits, std::uint64_t next_id,
                                           const std::function<bool(std::uint64_t)>& exists) {
    std::vector<std::string> out;
    const auto add = [&](std::uint64_t id) {
        if (out.size() < kMostCatoms && exists(id)) out.push_back(std::to_string(id));
    };
    if (digits.empty()) {
        for (std::uint64_t id = 0; id < next_id && out.size() < kMostCatoms; ++id) add(id);
        return out;
    }
    std::uint64_t typed = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), typed);
    if (error != std::errc{} || end != digits.data() + digits.size() || (digits.size() > 1 && digits[0] == '0')) return out;
    // Those with one digit more, then with two.
    for (std::uint64_t first = typed, count = 1; first < next_id && out.size() < kMostCatoms; first *= 10, count *= 10) {
        const std::uint64_t end_of_these = first + std::min(count, next_id - first);
        for (std::uint64_t id = first; id < end_of_these && out.size() < kMostCatoms; ++id) add(id);
        if (typed == 0 || first > next_id / 10) break;
    }
    return out;
}

}  // namespace meld::debug
