#include "runtime/base/files/output_paths.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

namespace meld {

namespace fs = std::filesystem;

namespace {

bool is_device(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::exists(status) && !fs::is_regular_file(status);
}

bool same_file(const std::string& a, const std::string& b) {
    if (is_standard_output(a) || is_standard_output(b)) return is_standard_output(a) && is_standard_output(b);
    if (is_device(a) || is_device(b)) return false;
    std::error_code error;
    if (fs::equivalent(a, b, error) && !error) return true;
    // At least one of them does not exist yet.
    const fs::path first = fs::weakly_canonical(fs::absolute(a), error);
    return !error && first == fs::weakly_canonical(fs::absolute(b), error) && !error;
}

}  // namespace

bool is_standard_output(const std::string& path) {
    if (path == "-" || path == "/dev/stdout") return true;
    struct stat named{}, standard{};
    if (stat(path.c_str(), &named) != 0 || fstat(STDOUT_FILENO, &standard) != 0) return false;
    // Terminals and other devices may be given several things on purpose.
    const bool one_stream = S_ISREG(standard.st_mode) || S_ISFIFO(standard.st_mode) || S_ISSOCK(standard.st_mode);
    return one_stream && named.st_dev == standard.st_dev && named.st_ino == standard.st_ino;
}

Result<void> check_distinct(std::span<const NamedPath> paths) {
    for (std::size_t i = 0; i < paths.size(); ++i) {
        for (std::size_t k = i + 1; k < paths.size(); ++k) {
            const NamedPath &a = paths[i], &b = paths[k];
            if (a.path.empty() || b.path.empty() || (a.use == NamedPath::Read && b.use == NamedPath::Read)) continue;
            if (!same_file(a.path, b.path)) continue;
            if (is_standard_output(a.path))
                return fail(fmt::format("{} and {} both write to standard output", a.option, b.option), "Give one of them a file");
            return fail(fmt::format("{} and {} are the same file, {}", a.option, b.option, b.path), "Give one of them another path");
        }
    }
    return {};
}

}  // namespace meld
