// An include is looked for beside the file that names it, then in the library folders; a name without an ending may mean name.meld.
#include "compiler/syntax/include_path.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

namespace meld::syntax {

namespace fs = std::filesystem;

using diagnostics::Kind;

namespace {

// Each file is read once, so only a chain of hundreds of files gets this far, and each level is a level of recursion.
constexpr int kMaxDepth = 200;

// One name for one file, however it is reached; a file that is not on disk goes by its path.
std::string identity(const fs::path& path) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(path, error);
    return error ? path.lexically_normal().string() : canonical.string();
}

std::vector<fs::path> candidates(const fs::path& path, const fs::path& folder, const std::vector<std::string>& library_paths) {
    std::vector<fs::path> result;
    const auto add = [&](const fs::path& base) {
        result.push_back((base / path).lexically_normal());
        if (!path.has_extension()) result.push_back((base / path).lexically_normal().concat(".meld"));
    };
    add(folder);
    if (path.is_absolute()) return result;
    for (const std::string& library : library_paths) add(library);
    return result;
}

std::optional<std::uint32_t> find_in_set(const source::FileSet& files, const fs::path& path) {
    for (std::size_t i = 0; i < files.count(); ++i) {
        const auto index = static_cast<std::uint32_t>(i);
        if (fs::path(files.file(index).path()).lexically_normal() == path) return index;
    }
    return std::nullopt;
}

}  // namespace

Includes::Includes(std::vector<std::string> library_paths, const std::string& first_file) : library_paths_(std::move(library_paths)) {
    read_.insert(identity(first_file));
}

std::optional<std::uint32_t> Includes::open(source::FileSet& files, std::uint32_t from, const std::string& path, source::Span where,
                                            diagnostics::Reporter& report) {
    const auto failed = [&](std::string message, std::string help) {
        report.add(Kind::IncludeFailed, where, std::move(message)).help = std::move(help);
        return std::nullopt;
    };
    if (path.empty()) return failed("this include names no file", "include \"file.meld\".");
    if (path.find('\0') != std::string::npos) return failed("a path holds no NUL byte", "");
    if (depth_ >= kMaxDepth) return failed(fmt::format("includes are nested more than {} files deep", kMaxDepth), "include the files side by side");
    std::string places;
    for (const fs::path& candidate : candidates(path, fs::path(files.file(from).path()).parent_path(), library_paths_)) {
        std::error_code error;
        const bool on_disk = fs::exists(candidate, error);
        std::optional<std::uint32_t> file = find_in_set(files, candidate);
        if (!file && !on_disk) {
            places += (places.empty() ? "" : ", ") + candidate.string();
            continue;
        }
        if (!read_.insert(identity(candidate)).second) return std::nullopt;
        if (!file) {
            auto read = files.read(candidate.string());
            if (!read) return failed(read.error().problem, read.error().suggestion);
            file = *read;
        }
        ++depth_;
        return file;
    }
    return failed(fmt::format("there is no file \"{}\"", path), "looked for " + places);
}

}  // namespace meld::syntax
