// From files to a tree: scans, parses item by item, and follows includes.
//
// Every item is added with its unit: the program, or the module of its file. `import` reads a file as a separate module.
//
// The grammar reads one item at a time, so that a mistake costs only one item: the parser continues after the next full stop, or, if a full
// stop was forgotten, reads the item again as if it were there.
#include "compiler/syntax/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <utility>

#include "compiler/syntax/include_path.h"
#include "compiler/syntax/item_parser.h"
#include "compiler/syntax/nesting.h"
#include "compiler/syntax/syntax_error.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

using diagnostics::Kind;

namespace {

// More mistakes than this in one file are not worth reading until these are cured.
constexpr int kMaxErrorsPerFile = 100;

std::uint32_t new_unit(std::uint32_t file, Unit unit, Includes& includes, Tree& tree) {
    const auto index = static_cast<std::uint32_t>(tree.units.size());
    tree.units.push_back(std::move(unit));
    includes.set_module(file, index);
    return index;
}

class FileParser {
  public:
    FileParser(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report, Includes* includes)
        : files_(files),
          file_(file),
          report_(report),
          includes_(includes),
          tokens_(scan(files.file(file), file, report)),
          build_(files.file(file), file),
          parser_(tokens_, build_) {
        classify_words(tokens_);
    }

    // The name in `module name.`, if the file has such a line.
    std::optional<Name> module_name() const {
        for (std::size_t i = 0; i + 2 < tokens_.size(); ++i)
            if (tokens_[i].kind == TokenKind::Module && tokens_[i + 1].kind == TokenKind::Name && tokens_[i + 2].kind == TokenKind::Period)
                return Builder::to_name(tokens_[i + 1]);
        return std::nullopt;
    }

    // Adds the items of the file to the tree as names of this unit.
    void run(std::uint32_t unit, Tree& tree) {
        MELD_EXPECT(unit < tree.units.size(), "there is no unit {}", unit);
        MELD_ASSERT(!tokens_.empty() && tokens_.back().kind == TokenKind::End, "the tokens of a file have no end");
        unit_ = unit;
        while (tokens_[at_].kind != TokenKind::End && error_count_ < kMaxErrorsPerFile) {
            if (read_include(tree)) continue;
            if (tokens_[at_].kind == TokenKind::Period) {
                stray_period();
                continue;
            }
            const std::size_t begin = at_, errors = report_.error_count();
            if (!nested_too_deep()) read_item(tree);
            MELD_ASSERT(at_ > begin && at_ < tokens_.size(), "token {} of {} after an item at {}", at_, tokens_.size(), begin);
            if (report_.error_count() > errors || is_damaged(begin, at_)) lose(begin, tree);
        }
        tree.lost_file = tree.lost_file || error_count_ >= kMaxErrorsPerFile;
    }

  private:
    std::uint32_t column(std::size_t index) const { return files_.file(file_).place(tokens_[index].span.begin).column; }

    // The names that a broken item may have declared. A rule declares none.
    void lose(std::size_t begin, Tree& tree) const {
        const auto declares = [](const Token& token) { return starts_declaration(token.kind); };
        const bool fact_first = (tokens_[begin].kind == TokenKind::Name || tokens_[begin].kind == TokenKind::Variable) && begin + 1 < at_ &&
                                tokens_[begin + 1].kind == TokenKind::LeftParen;
        const auto from = tokens_.begin() + static_cast<std::ptrdiff_t>(begin), to = tokens_.begin() + static_cast<std::ptrdiff_t>(at_);
        if (fact_first && std::none_of(from, to, declares)) return;
        for (std::size_t i = begin; i < at_; ++i)
            if (!tokens_[i].text.empty()) tree.lost.insert(tokens_[i].text);
    }

    std::size_t next_period(std::size_t index) const {
        MELD_EXPECT(index < tokens_.size(), "token {} of {}", index, tokens_.size());
        while (tokens_[index].kind != TokenKind::Period && tokens_[index].kind != TokenKind::End) ++index;
        return index;
    }

    // include "f".  #include <f>  include #f  use "library".  use "library" as name.  The full stop after it may be omitted. Without
    // `includes_` it is skipped.
    bool read_include(Tree& tree) {
        const TokenKind kind = tokens_[at_].kind;
        const bool with_text = (kind == TokenKind::Include || kind == TokenKind::Use) && tokens_[at_ + 1].kind == TokenKind::String;
        if (kind != TokenKind::IncludePath && !with_text) return false;
        const std::size_t path = with_text ? at_ + 1 : at_;
        at_ = path + 1;
        const std::optional<Name> alias = with_text ? read_alias() : std::nullopt;
        if (tokens_[at_].kind == TokenKind::Period) ++at_;
        tree.includes.push_back({tokens_[path].span, std::nullopt});
        if (includes_ == nullptr) return true;
        const auto included =
            includes_->find(kind == TokenKind::Use ? Lookup::Use : Lookup::Include, file_, tokens_[path].text, tokens_[path].span, report_);
        tree.includes.back().file = included;
        if (!included)
            tree.lost_file = true;
        else if (alias)
            read_instance(*included, *alias, tokens_[path].span, tree);
        else
            read_file(*included, tokens_[path].span, tree);
        return true;
    }

    // The `as name` behind a file.
    std::optional<Name> read_alias() {
        if (tokens_[at_].kind != TokenKind::Name || tokens_[at_].text != "as") return std::nullopt;
        const Token& name = tokens_[at_ + 1];
        if (name.kind == TokenKind::Name) {
            at_ += 2;
            return Builder::to_name(name);
        }
        ++error_count_;
        report_.add(Kind::SyntaxError, tokens_[at_].span, "there is no name behind this `as`").help =
            "a name begins with a lowercase letter, as in use \"gradient\" as near.";
        at_ = next_period(at_);
        return std::nullopt;
    }

    // The file once more, with names and facts of its own, whether or not it is a module.
    void read_instance(std::uint32_t file, const Name& alias, Span where, Tree& tree) {
        if (!includes_->first_instance(file, unit_, alias.text) || !includes_->enter(where, report_)) return;
        const auto unit = static_cast<std::uint32_t>(tree.units.size());
        const std::string& user = tree.units[unit_].name;
        tree.units.push_back({user.empty() ? alias.text : user + "-" + alias.text, alias.span, alias.text, unit_});
        if (includes_->first_time(file, unit)) FileParser(files_, file, report_, includes_).run(unit, tree);
        includes_->leave();
    }

    // A module has names of its own and is read once; the names of another file are those of the file that includes it.
    void read_file(std::uint32_t file, Span where, Tree& tree) {
        if (includes_->module_of(file) || includes_->is_read(file, unit_) || !includes_->enter(where, report_)) return;
        FileParser parser(files_, file, report_, includes_);
        std::uint32_t unit = unit_;
        if (const auto name = parser.module_name()) unit = new_unit(file, {name->text, name->span}, *includes_, tree);
        if (includes_->first_time(file, unit)) parser.run(unit, tree);
        includes_->leave();
    }

    void stray_period() {
        ++error_count_;
        auto& diagnostic = report_.add(Kind::SyntaxError, tokens_[at_].span, "there is nothing before this full stop");
        const std::size_t first = at_;
        while (tokens_[at_].kind == TokenKind::Period) ++at_;
        diagnostic.fixes = {
            safe(diagnostics::leave_out(tokens_[first].span.to(tokens_[at_ - 1].span), "the full stop", diagnostics::Edit::Fit::Word))};
    }

    bool nested_too_deep() {
        if (at_ < nesting_checked_until_) return false;
        nesting_checked_until_ = next_period(at_);
        const auto deep = too_deep(tokens_, at_, nesting_checked_until_, static_cast<std::size_t>(kMaxNesting));
        if (!deep) return false;
        ++error_count_;
        report_.add(Kind::NestingTooDeep, tokens_[*deep].span, fmt::format("this is nested more than {} levels deep", kMaxNesting)).help =
            "split it into several rules, or give parts of it names with X = e";
        at_ = nesting_checked_until_;
        if (tokens_[at_].kind == TokenKind::Period) ++at_;
        return true;
    }

    void read_item(Tree& tree) {
        const std::size_t begin = at_;
        if (const auto forgotten = swallowed_item()) return read_item_without_period(*forgotten, tree);
        const ItemTokens& item = parser_.item();
        if (parser_.parse(begin)) {
            at_ = item.end();
            return finish_item(tree);
        }
        const std::size_t stop = item.current();
        if (stop > begin && ends_before(stop, item.expected())) return read_item_without_period(stop, tree);
        build_.discard();
        report_stop({tokens_, begin, stop, item.expected(), starts_item(stop + 1, begin)});
        recover(begin, stop);
    }

    void finish_item(Tree& tree) {
        const std::size_t before = report_.error_count();
        if (auto item = build_.finish(report_)) tree.add(std::move(*item), unit_);
        if (report_.error_count() > before) ++error_count_;
    }

    // The item contains something that the scanner has reported already.
    bool is_damaged(std::size_t begin, std::size_t stop) const {
        MELD_EXPECT(begin <= stop && stop < tokens_.size(), "tokens {} to {} of {}", begin, stop, tokens_.size());
        for (std::size_t i = begin; i <= stop; ++i) {
            if (tokens_[i].damaged) return true;
        }
        return false;
    }

    void report_stop(const Stop& stop) {
        ++error_count_;
        if (!is_damaged(stop.begin, stop.at)) report_syntax_error(stop, report_);
    }

    // A full stop would fit here, and the following text looks like the next item.
    bool ends_before(std::size_t stop, const std::vector<TokenKind>& expected) const {
        bool fits = false;
        for (const TokenKind kind : expected) fits = fits || kind == TokenKind::Period;
        return fits && starts_item(stop, at_);
    }

    // Whether this token, behind the item at `begin`, looks like the start of the next one, or is the end.
    bool starts_item(std::size_t index, std::size_t begin) const {
        if (index >= tokens_.size()) return true;
        const Token& token = tokens_[index];
        return token.kind == TokenKind::End || starts_declaration(token.kind) || (token.first_on_line && column(index) <= column(begin));
    }

    // A declaration is a row of words, so the grammar reads on over a forgotten full stop: type p(node) q(A) :- ...
    std::optional<std::size_t> swallowed_item() const {
        const TokenKind kind = tokens_[at_].kind;
        if (kind != TokenKind::Type && kind != TokenKind::Extern && kind != TokenKind::Import && kind != TokenKind::Hint)
            return std::nullopt;
        int depth = 0;
        for (std::size_t i = at_ + 1; tokens_[i].kind != TokenKind::Period && tokens_[i].kind != TokenKind::End; ++i) {
            const Token& token = tokens_[i];
            const bool behind_end = tokens_[i - 1].kind == TokenKind::RightParen || kind == TokenKind::Hint || kind == TokenKind::Import;
            const bool new_line = token.first_on_line && column(i) <= column(at_);
            if (depth == 0 && new_line && i > at_ + 1 && token.text != "while" && (behind_end || !ends_with_signature(i))) return i;
            if (token.kind == TokenKind::LeftParen || token.kind == TokenKind::StructOpen) ++depth;
            if (token.kind == TokenKind::RightParen) --depth;
        }
        return std::nullopt;
    }

    // `p(node).`: the rest of a declaration whose modifiers are on the line before.
    bool ends_with_signature(std::size_t index) const {
        if (tokens_[index].kind != TokenKind::Name || tokens_[index + 1].kind != TokenKind::LeftParen) return false;
        int depth = 0;
        for (std::size_t i = index + 1; tokens_[i].kind != TokenKind::Period && tokens_[i].kind != TokenKind::End; ++i) {
            if (tokens_[i].kind == TokenKind::LeftParen || tokens_[i].kind == TokenKind::StructOpen) ++depth;
            if (tokens_[i].kind == TokenKind::RightParen && --depth == 0) return tokens_[i + 1].kind == TokenKind::Period;
        }
        return false;
    }

    void read_item_without_period(std::size_t stop, Tree& tree) {
        MELD_EXPECT(stop > at_, "an item from {} to {}", at_, stop);
        build_.discard();
        ++error_count_;
        // A string without its closing quote may have swallowed the full stop, and `;` instead of it is a mistake of its own.
        if (!is_damaged(at_, stop) && tokens_[stop - 1].kind != TokenKind::Semicolon) report_missing_period(tokens_, at_, stop, report_);
        const std::size_t begin = at_;
        at_ = stop;
        if (parser_.parse(begin, stop)) return finish_item(tree);
        build_.discard();
        const std::size_t at = parser_.item().current();
        report_stop({tokens_, begin, at, parser_.item().expected(), starts_item(at + 1, begin)});
    }

    // After the next full stop, or at a declaration that starts on a new line before it. A string without its closing quote may have
    // swallowed the full stop; then at the first line that starts as far left as the item.
    void recover(std::size_t begin, std::size_t from) {
        MELD_EXPECT(begin <= from, "an item at {} stopped at {}", begin, from);
        const bool damaged = is_damaged(begin, from);
        at_ = from;
        while (tokens_[at_].kind != TokenKind::Period && tokens_[at_].kind != TokenKind::End) {
            const bool new_line = at_ > begin && tokens_[at_].first_on_line;
            if (new_line && (starts_declaration(tokens_[at_].kind) || (damaged && column(at_) <= column(begin)))) return;
            ++at_;
        }
        if (tokens_[at_].kind == TokenKind::Period) ++at_;
    }

    source::FileSet& files_;
    std::uint32_t file_;
    diagnostics::Reporter& report_;
    Includes* includes_;
    std::uint32_t unit_ = 0;
    std::vector<Token> tokens_;
    Builder build_;
    ItemParser parser_;
    std::size_t at_ = 0;
    std::size_t nesting_checked_until_ = 0;
    int error_count_ = 0;
};

// A file without `module` is a module with its file's name for those that import from it, with a number if that name is used.
Unit unit_named_after(std::uint32_t file, const std::string& path, const Tree& tree) {
    std::string name = std::filesystem::path(path).stem().string();
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') c = '-';
    if (name.empty() || !std::islower(static_cast<unsigned char>(name[0]))) name.insert(0, "file-");
    const auto taken = [&](const std::string& text) {
        return std::any_of(tree.units.begin(), tree.units.end(), [&](const Unit& unit) { return unit.name == text; });
    };
    std::string text = name;
    for (int number = 2; taken(text); ++number) text = fmt::format("{}-{}", name, number);
    return {text, {file, 0, 0}};
}

// Reads the files that are named by nothing but imports, and notes for each import whose names it asks for. A file that is part of the
// importing unit already is not read a second time.
void read_imports(source::FileSet& files, diagnostics::Reporter& report, Includes& includes, Tree& tree) {
    for (std::size_t i = 0; i < tree.items.size(); ++i) {
        MELD_ASSERT(tree.unit_of.size() == tree.items.size(), "{} items in {} units", tree.items.size(), tree.unit_of.size());
        const auto* import = std::get_if<Import>(&tree.items[i]);
        if (import == nullptr) continue;
        const Span where = import->path_span;
        const auto file = includes.find(Lookup::Import, where.file, import->path, where, report);
        tree.includes.push_back({where, file});
        std::uint32_t unit = tree.unit_of[i];
        if (file && !includes.is_read(*file, unit)) {
            if (const auto known = includes.module_of(*file)) {
                unit = *known;
            } else {
                FileParser parser(files, *file, report, &includes);
                const auto name = parser.module_name();
                unit = new_unit(*file, name ? Unit{name->text, name->span} : unit_named_after(*file, files.file(*file).path(), tree),
                                includes, tree);
                includes.first_time(*file, unit);
                parser.run(unit, tree);
            }
        }
        // Reading has added items, so the import may have moved.
        std::get<Import>(tree.items[i]).unit = file ? unit : Import::kNoUnit;
    }
}

// Every file belongs to the programs from which includes lead to it.
std::vector<std::uint64_t> programs_of_files(const source::FileSet& files, std::uint32_t first, const std::vector<std::uint32_t>& others,
                                             const Tree& tree) {
    std::vector<std::uint64_t> programs(files.count());
    programs[first] = 1;
    for (std::size_t i = 0; i < others.size(); ++i) programs[others[i]] |= std::uint64_t{2} << i;
    for (bool changed = true; changed;) {
        changed = false;
        for (const Tree::Include& include : tree.includes) {
            if (!include.file) continue;
            const std::uint64_t before = programs[*include.file];
            programs[*include.file] |= programs[include.where.file];
            changed = changed || programs[*include.file] != before;
        }
    }
    return programs;
}

}  // namespace

Tree parse(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report, const ParseOptions& options) {
    MELD_EXPECT(file < files.count(), "there is no file {}", file);
    Tree tree;
    tree.units.emplace_back();
    Includes includes(files, options.library_paths, options.libraries, file);
    if (options.meant) includes.mean(*options.meant);
    MELD_EXPECT(options.programs.size() < kMaxPrograms, "{} other programs", options.programs.size());
    for (const std::uint32_t program : options.programs) includes.add_program(program);
    FileParser(files, file, report, options.follow_includes ? &includes : nullptr).run(0, tree);
    for (const std::uint32_t program : options.programs)
        FileParser(files, program, report, options.follow_includes ? &includes : nullptr).run(0, tree);
    if (options.follow_includes) read_imports(files, report, includes, tree);
    if (!options.programs.empty()) tree.programs_of = programs_of_files(files, file, options.programs, tree);
    return tree;
}

std::string print_tokens(const source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report) {
    std::vector<Token> tokens = scan(files.file(file), file, report);
    classify_words(tokens);
    std::string result;
    for (const Token& token : tokens) {
        const source::Place place = files.begin(token.span);
        result += fmt::format("{}:{} {} {}", place.line, place.column, kind_name(token.kind), files.text(token.span));
        if (result.back() == ' ') result.pop_back();
        result += '\n';
    }
    return result;
}

}  // namespace meld::syntax
