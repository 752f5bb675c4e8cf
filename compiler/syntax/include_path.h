// Which file an include means, to which unit its names belong, and which files have been read.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"

namespace meld::syntax {

// A library that needs no file on disk: use "name".
struct Library {
    std::string name;
    std::string text;
};

// How a file is named: `include` searches beside the including file first, `use` in the library folders and among the compiler's own
// libraries first, `import` like `include` and then among those libraries.
enum class Lookup { Include, Use, Import };

class Includes {
  public:
    // library_paths: folders searched after the including file's own; main_file is read already, as unit 0.
    Includes(source::FileSet& files, std::vector<std::string> library_paths, std::vector<Library> libraries, std::uint32_t main_file);

    // Another program, whose items are those of unit 0 too.
    void add_program(std::uint32_t file);

    // From now on find() gives these files of the set, one after the other, and searches nothing; none: a library of the compiler.
    void mean(std::vector<std::optional<std::uint32_t>> files) { meant_ = std::move(files); }

    // Searches the files of the set, then the disk. Nothing if there is none, which is reported at `where`.
    std::optional<std::uint32_t> find(Lookup lookup, std::uint32_t from, const std::string& path, source::Span where,
                                      diagnostics::Reporter& report);

    // Whether this file has not been read into this unit; from now on it counts as read.
    bool first_time(std::uint32_t file, std::uint32_t unit) { return read_.emplace(file, unit).second; }
    bool is_read(std::uint32_t file, std::uint32_t unit) const { return read_.contains({file, unit}); }
    // The unit of a file that is a module.
    std::optional<std::uint32_t> module_of(std::uint32_t file) const;
    void set_module(std::uint32_t file, std::uint32_t unit) { modules_[file] = unit; }
    // Whether the unit has no instance of this file by this name yet; from now on it has.
    bool first_instance(std::uint32_t file, std::uint32_t user, const std::string& alias) {
        return instances_.emplace(file, user, alias).second;
    }

    // One file inside another. False if that is too deep, which is reported.
    bool enter(source::Span where, diagnostics::Reporter& report);
    void leave() { --depth_; }

  private:
    std::optional<std::uint32_t> open(const std::string& candidate, bool& exists);
    std::optional<std::uint32_t> open_library(const std::string& name);
    std::string nearest_library(const std::string& path) const;
    void unknown_library(const std::string& path, source::Span where, diagnostics::Reporter& report) const;

    source::FileSet& files_;
    std::vector<std::string> library_paths_;
    std::vector<Library> libraries_;
    std::map<std::string, std::uint32_t> by_identity_;
    std::map<std::uint32_t, std::uint32_t> modules_;
    std::set<std::pair<std::uint32_t, std::uint32_t>> read_;
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::string>> instances_;
    std::string trouble_, help_;
    int depth_ = 0;
    std::optional<std::vector<std::optional<std::uint32_t>>> meant_;
    std::size_t found_ = 0;  // How many of them.
};

}  // namespace meld::syntax
