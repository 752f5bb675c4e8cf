// The analysis of one open program: its text and its includes, checked, with the meaning of every name.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/lsp/items.h"
#include "compiler/lsp/occurrences.h"
#include "compiler/lsp/text.h"
#include "compiler/plan/plan.h"

namespace meld::lsp {

// Texts of open files by their absolute, normalized paths. They replace those on disk.
using OpenTexts = std::map<std::string, std::string>;

struct Place {
    std::string path;  // Of a file on disk; empty for the prelude.
    Range range;
};

struct Message {
    Range range;
    diagnostics::Severity severity;
    std::string code;
    std::string text;
    // Related places, with a note for each.
    std::vector<std::pair<Place, std::string>> related;
    bool without_use;  // Editors show such names in grey.
    std::vector<diagnostics::Fix> fixes = {};
};

class Analysis {
  public:
    // Analyses the open program at `path`. Never fails: unreadable files are reported as in `meldc check`.
    Analysis(const std::string& path, const OpenTexts& open);

    // The mistakes of the program. A mistake in an included file is shown where the file is included.
    std::vector<Message> messages() const;

    // The name at a position of the program's own file.
    const Occurrence* at(Position position) const;
    // All occurrences of a symbol in the program's files; the prelude is one of them.
    std::vector<std::pair<std::uint32_t, const Occurrence*>> all(const Symbol& symbol) const;
    // Where it is declared; for a variable, its first occurrence.
    std::optional<std::pair<std::uint32_t, const Occurrence*>> declaration(const Symbol& symbol) const;

    const source::FileSet& files() const { return files_; }
    const source::File& root() const { return files_.file(root_); }
    std::uint32_t root_index() const { return root_; }
    bool is_prelude(std::uint32_t file) const { return file < prelude_files_; }
    // The files that are part of the program.
    const std::map<std::uint32_t, FileTokens>& tokens() const { return tokens_; }
    const std::vector<Occurrence>& occurrences(std::uint32_t file) const { return occurrences_.at(file); }
    const Declared& declared() const { return declared_; }
    bool uses(const std::string& path) const;
    // The file that an include of the program's own file names.
    std::optional<std::uint32_t> included(const std::string& name) const;

    const check::Program& program() const { return program_; }
    // Computed when first asked for; nothing if the program has mistakes.
    const plan::Plan* plan() const;

    std::string item_text(std::uint32_t file, std::size_t item) const { return lsp::item_text(files_.file(file), tokens_.at(file), item); }
    std::string doc(std::uint32_t file, std::size_t item) const { return doc_comment(files_.file(file), tokens_.at(file), item); }
    Place place(source::Span span) const;

  private:
    void add_file(std::uint32_t file);
    Span shown_at(Span span) const;

    source::FileSet files_;
    std::uint32_t prelude_files_ = 0;
    std::uint32_t root_ = 0;
    diagnostics::Reporter report_;
    check::Program program_;
    mutable std::optional<plan::Plan> plan_;
    std::map<std::uint32_t, FileTokens> tokens_;
    std::map<std::uint32_t, std::vector<Occurrence>> occurrences_;
    // Which file each file is included from, and where.
    std::map<std::uint32_t, Span> included_at_;
    Declared declared_;
};

}  // namespace meld::lsp
