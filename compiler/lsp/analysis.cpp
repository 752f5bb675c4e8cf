// The front end of the compiler does the checking; names are looked up in the tokens, so there is an answer even where the front end
// stopped.
#include "compiler/lsp/analysis.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "compiler/front/front_end.h"
#include "compiler/lsp/prelude_file.h"
#include "runtime/base/assert.h"

namespace meld::lsp {

namespace fs = std::filesystem;

namespace {

bool is_without_use(diagnostics::Kind kind) {
    using diagnostics::Kind;
    return kind == Kind::NeverRead || kind == Kind::UnusedName || kind == Kind::UnusedParameter;
}

}  // namespace

Analysis::Analysis(const std::string& path, const OpenTexts& open) {
    MELD_EXPECT(open.contains(path), "{} is not open", path);
    std::uint32_t checked = 0;
    if (is_prelude_file(path)) {
        // The prelude is checked in its usual place, without a program after it, because it would otherwise declare everything twice.
        files_.add(path, open.at(path));
        prelude_files_ = 1;
        checked = files_.add("", "");
    } else {
        prelude_files_ = front::add_prelude(files_);
        for (const auto& [name, text] : open) {
            const std::uint32_t index = files_.add(name, text);
            if (name == path) root_ = checked = index;
        }
    }
    front::ParsedProgram parsed = front::parse_program(files_, checked, prelude_files_, report_, {});
    program_ = front::check_program(files_, checked, prelude_files_, std::move(parsed), report_);
    for (std::uint32_t i = 0; i < prelude_files_; ++i) add_file(i);
    if (!tokens_.contains(root_)) add_file(root_);
    for (const auto& [file, tokens] : tokens_) add_declared(tokens, declared_);
    for (const auto& [file, tokens] : tokens_) occurrences_[file] = find_occurrences(tokens, file, declared_);
}

// With the files it includes; files that were not found are not in the set.
void Analysis::add_file(std::uint32_t file) {
    MELD_EXPECT(file < files_.count() && !tokens_.contains(file), "file {} of {}", file, files_.count());
    const FileTokens& tokens = tokens_[file] = read_items(files_.file(file), file);
    for (const Item& item : tokens.items) {
        const bool named = item.kind == TokenKind::Include || item.kind == TokenKind::Use;
        if (item.kind != TokenKind::IncludePath && !(named && item.begin + 1 < item.end)) continue;
        const Token& name = tokens.tokens[item.begin + (named ? 1 : 0)];
        const fs::path path = (fs::path(files_.file(file).path()).parent_path() / name.text).lexically_normal();
        for (std::uint32_t i = 0; i < files_.count(); ++i) {
            const fs::path known = fs::path(files_.file(i).path()).lexically_normal();
            if ((known != path && known != fs::path(path).concat(".meld")) || tokens_.contains(i)) continue;
            included_at_[i] = name.span;
            add_file(i);
        }
    }
}

std::optional<std::uint32_t> Analysis::included(const std::string& name) const {
    for (const auto& [file, where] : included_at_) {
        if (where.file == root_ && files_.text(where).find(name) != std::string_view::npos) return file;
    }
    return std::nullopt;
}

bool Analysis::uses(const std::string& path) const {
    return std::any_of(tokens_.begin(), tokens_.end(),
                       [&](const auto& entry) { return !is_prelude(entry.first) && files_.file(entry.first).path() == path; });
}

Place Analysis::place(Span span) const { return {is_prelude(span.file) ? "" : files_.file(span).path(), range_of(files_, span)}; }

// The include in the program's own file through which a place of another file is reached.
Span Analysis::shown_at(Span span) const {
    while (span.file != root_) {
        const auto where = included_at_.find(span.file);
        if (where == included_at_.end()) return {root_, 0, 0};
        span = where->second;
    }
    return span;
}

std::vector<Message> Analysis::messages() const {
    std::vector<Message> messages;
    for (const diagnostics::Diagnostic& diagnostic : report_.sorted()) {
        const diagnostics::KindInfo& kind = diagnostics::info(diagnostic.kind);
        Message message{range_of(files_, shown_at(diagnostic.span)),
                        kind.severity,
                        std::string(kind.code),
                        diagnostic.message,
                        {},
                        is_without_use(diagnostic.kind),
                        diagnostic.fixes};
        if (diagnostic.span.file != root_) message.related.emplace_back(place(diagnostic.span), diagnostic.message);
        for (const diagnostics::Label& label : diagnostic.labels) message.related.emplace_back(place(label.span), label.text);
        if (!diagnostic.help.empty()) message.text += "\nhelp: " + diagnostic.help;
        messages.push_back(std::move(message));
    }
    return messages;
}

const Occurrence* Analysis::at(Position position) const {
    const std::size_t offset = offset_of(root().text(), position);
    // A cursor right after a name still means the name.
    const Occurrence* best = nullptr;
    for (const Occurrence& occurrence : occurrences_.at(root_)) {
        if (occurrence.span.begin <= offset && offset <= occurrence.span.end) best = &occurrence;
    }
    return best;
}

std::vector<std::pair<std::uint32_t, const Occurrence*>> Analysis::all(const Symbol& symbol) const {
    std::vector<std::pair<std::uint32_t, const Occurrence*>> found;
    for (const auto& [file, list] : occurrences_) {
        for (const Occurrence& occurrence : list) {
            if (occurrence.symbol == symbol) found.emplace_back(file, &occurrence);
        }
    }
    return found;
}

std::optional<std::pair<std::uint32_t, const Occurrence*>> Analysis::declaration(const Symbol& symbol) const {
    const auto found = all(symbol);
    // A program may declare a predicate of the prelude again: its own declaration is the one to show.
    for (auto one = found.rbegin(); one != found.rend(); ++one) {
        if (one->second->role == Role::Declaration) return *one;
    }
    if (symbol.kind == SymbolKind::Variable && !found.empty()) return found.front();
    return std::nullopt;
}

const plan::Plan* Analysis::plan() const {
    if (report_.has_errors()) return nullptr;
    if (!plan_) plan_ = plan::make_plan(program_);
    return &*plan_;
}

}  // namespace meld::lsp
