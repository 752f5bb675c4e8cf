// An include is searched beside the including file, then in the library folders; a name without an extension may mean name.meld. `use`
// searches the library folders, then the compiler's own libraries, then beside the file.
#include "compiler/syntax/include_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::syntax {

namespace fs = std::filesystem;

using diagnostics::Kind;

namespace {

// Each file is read once, so only a chain of hundreds of files gets this far, and each level is a level of recursion.
constexpr int kMaxDepth = 200;

// One name for one file, however it is reached; a file that is not on disk is identified by its path.
std::string identity(const fs::path& path) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(path, error);
    return error ? path.lexically_normal().string() : canonical.string();
}

void add_candidates(const fs::path& path, const fs::path& base, std::vector<fs::path>& result) {
    result.push_back((base / path).lexically_normal());
    if (!path.has_extension()) result.push_back((base / path).lexically_normal().concat(".meld"));
}

std::optional<std::uint32_t> find_in_set(const source::FileSet& files, const fs::path& path) {
    for (std::size_t i = 0; i < files.count(); ++i) {
        const auto index = static_cast<std::uint32_t>(i);
        if (fs::path(files.file(index).path()).lexically_normal() == path) return index;
    }
    return std::nullopt;
}

// `use "gradient.meld"` means the library gradient too.
std::string library_name(const std::string& path) { return path.ends_with(".meld") ? path.substr(0, path.size() - 5) : path; }

}  // namespace

Includes::Includes(source::FileSet& files, std::vector<std::string> library_paths, std::vector<Library> libraries, std::uint32_t main_file)
    : files_(files), library_paths_(std::move(library_paths)), libraries_(std::move(libraries)) {
    add_program(main_file);
}

void Includes::add_program(std::uint32_t file) {
    MELD_EXPECT(file < files_.count(), "there is no file {}", file);
    by_identity_[identity(files_.file(file).path())] = file;
    modules_[file] = 0;
    read_.emplace(file, 0);
}

std::optional<std::uint32_t> Includes::module_of(std::uint32_t file) const {
    const auto found = modules_.find(file);
    return found == modules_.end() ? std::nullopt : std::optional(found->second);
}

bool Includes::enter(source::Span where, diagnostics::Reporter& report) {
    if (depth_ >= kMaxDepth) {
        report.add(Kind::IncludeFailed, where, fmt::format("includes are nested more than {} files deep", kMaxDepth)).help =
            "include the files side by side";
        return false;
    }
    ++depth_;
    return true;
}

std::optional<std::uint32_t> Includes::find(Lookup lookup, std::uint32_t from, const std::string& path, source::Span where,
                                            diagnostics::Reporter& report) {
    MELD_EXPECT(from < files_.count(), "there is no file {}", from);
    const auto failed = [&](std::string message, std::string help, const std::string& near = "") {
        auto& diagnostic = report.add(Kind::IncludeFailed, where, std::move(message));
        diagnostic.help = std::move(help);
        // An import names its file with or without quotes.
        const bool quoted = files_.text(where).starts_with('"');
        if (!near.empty()) diagnostic.fixes = {diagnostics::write(where, quoted ? fmt::format("\"{}\"", near) : near)};
        return std::nullopt;
    };
    if (path.empty()) return failed("this include names no file", "include \"file.meld\".");
    if (path.find('\0') != std::string::npos) return failed("a path cannot contain a NUL byte", "");
    if (meant_) {
        if (found_ < meant_->size() && (*meant_)[found_]) return (*meant_)[found_++];
        ++found_;
        if (const auto library = open_library(library_name(path))) return library;
        return failed(fmt::format("there is no file \"{}\"", path), "");
    }
    const fs::path folder = fs::path(files_.file(from).path()).parent_path();
    std::vector<fs::path> beside, in_libraries;
    add_candidates(path, folder, beside);
    if (!fs::path(path).is_absolute())
        for (const std::string& library : library_paths_) add_candidates(path, library, in_libraries);

    std::string places;
    trouble_.clear();
    const auto search = [&](const std::vector<fs::path>& candidates) -> std::optional<std::uint32_t> {
        for (const fs::path& candidate : candidates) {
            bool exists = false;
            if (const auto file = open(candidate.string(), exists)) return file;
            if (exists) return std::nullopt;
            places += (places.empty() ? "" : ", ") + candidate.string();
        }
        return std::nullopt;
    };
    std::optional<std::uint32_t> file = search(lookup == Lookup::Use ? in_libraries : beside);
    if (!file && trouble_.empty() && lookup == Lookup::Use) file = open_library(library_name(path));
    if (!file && trouble_.empty()) file = search(lookup == Lookup::Use ? beside : in_libraries);
    if (!file && trouble_.empty() && lookup == Lookup::Import) file = open_library(library_name(path));
    if (file) return file;
    if (!trouble_.empty()) return failed(trouble_, help_);
    if (lookup == Lookup::Use) {
        unknown_library(path, where, report);
        return std::nullopt;
    }
    std::string help = "looked for " + places;
    const std::string near = lookup == Lookup::Import ? nearest_library(path) : "";
    if (!near.empty()) help += fmt::format("; did you mean the library `{}`?", near);
    return failed(fmt::format("there is no file \"{}\"", path), std::move(help), near);
}

// The file of this path, read if it is not in the set; `exists` is set, and trouble_ says why, if it is there and cannot be read.
std::optional<std::uint32_t> Includes::open(const std::string& candidate, bool& exists) {
    std::error_code error;
    const std::optional<std::uint32_t> known = find_in_set(files_, candidate);
    // A path that cannot be checked, for lack of permission, may exist: reading it tells why it cannot be read.
    exists = known || fs::status(candidate, error).type() != fs::file_type::not_found;
    if (!exists) return std::nullopt;
    const auto [place, first] = by_identity_.try_emplace(identity(candidate), 0);
    if (!first) return place->second;
    if (known) return place->second = *known;
    const auto read = files_.read(candidate);
    if (read) return place->second = *read;
    by_identity_.erase(place);
    trouble_ = read.error().problem;
    help_ = read.error().suggestion;
    return std::nullopt;
}

std::optional<std::uint32_t> Includes::open_library(const std::string& name) {
    const auto found = std::find_if(libraries_.begin(), libraries_.end(), [&](const Library& library) { return library.name == name; });
    if (found == libraries_.end()) return std::nullopt;
    // No path on disk begins like this.
    const auto [place, first] = by_identity_.try_emplace("library " + name, 0);
    if (first) place->second = files_.add("stdlib/" + name + ".meld", found->text);
    return place->second;
}

std::string Includes::nearest_library(const std::string& path) const {
    std::vector<std::string> names;
    for (const Library& library : libraries_) names.push_back(library.name);
    return diagnostics::nearest_name(library_name(path), names);
}

void Includes::unknown_library(const std::string& path, source::Span where, diagnostics::Reporter& report) const {
    std::string list;
    for (const Library& library : libraries_) list += (list.empty() ? "" : ", ") + library.name;
    const std::string near = nearest_library(path);
    const std::string have = list.empty() ? "" : "the libraries are " + list + "; ";
    auto& diagnostic = report.add(Kind::UnknownLibrary, where, fmt::format("there is no library \"{}\"", path));
    diagnostic.help = (near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near)) + have + "-I adds a folder with more";
    if (!near.empty()) diagnostic.fixes = {diagnostics::write(where, fmt::format("\"{}\"", near))};
}

}  // namespace meld::syntax
