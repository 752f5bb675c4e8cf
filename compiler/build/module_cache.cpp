// Cache housekeeping. Nothing here may fail a compilation except that the folder or a file cannot be written.
#include "compiler/build/module_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "runtime/base/output_file.h"

namespace meld {
namespace {

namespace fs = std::filesystem;

const std::string kTemporaryPrefix = "tmp-";
// A compilation takes a fraction of a second; an hour allows for a stopped process.
constexpr std::chrono::hours kTemporaryLifetime{1};

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::string() : std::string(value);
}

struct CachedFile {
    fs::path path;
    fs::file_time_type used;
    std::uintmax_t size_bytes;
};

// The modules in the folder, oldest first; stale temporary files are removed on the way.
std::vector<CachedFile> list_modules(const std::string& folder) {
    std::vector<CachedFile> modules;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code gone;
        const fs::file_time_type used = entry->last_write_time(gone);
        const std::uintmax_t size_bytes = entry->file_size(gone);
        if (gone) continue;
        const std::string name = entry->path().filename().string();
        if (name.starts_with(kTemporaryPrefix)) {
            if (fs::file_time_type::clock::now() - used > kTemporaryLifetime) fs::remove(entry->path(), gone);
        } else if (entry->path().extension() == ".so") {
            modules.push_back({entry->path(), used, size_bytes});
        }
    }
    std::sort(modules.begin(), modules.end(),
              [](const CachedFile& a, const CachedFile& b) { return a.used != b.used ? a.used < b.used : a.path < b.path; });
    return modules;
}

}  // namespace

std::string default_cache_dir() {
    if (const std::string folder = environment("CLAYMELD_CACHE"); !folder.empty()) return folder;
    if (const std::string folder = environment("XDG_CACHE_HOME"); !folder.empty()) return folder + "/claymeld";
    if (const std::string home = environment("HOME"); !home.empty()) return home + "/.cache/claymeld";
    return fmt::format("/tmp/claymeld-{}", ::getuid());
}

Result<void> make_cache_dir(const std::string& folder) {
    std::error_code error;
    if (fs::is_directory(folder, error)) return {};
    fs::create_directories(folder, error);
    if (error)
        return fail(fmt::format("cannot make the module cache {} ({})", folder, error.message()),
                    "Set CLAYMELD_CACHE to a folder that can be written");
    fs::permissions(folder, fs::perms::owner_all, error);
    return {};
}

void evict(const std::string& folder, const std::string& keep, const CacheLimits& limits) {
    const std::vector<CachedFile> modules = list_modules(folder);
    std::size_t files = modules.size();
    std::uintmax_t size_bytes = 0;
    for (const CachedFile& module : modules) size_bytes += module.size_bytes;
    for (const CachedFile& module : modules) {
        if (files <= limits.files && size_bytes <= limits.size_bytes) return;
        if (module.path == fs::path(keep)) continue;
        std::error_code ignored;
        fs::remove(module.path, ignored);
        --files;
        size_bytes -= module.size_bytes;
    }
}

void touch(const std::string& path) { ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0); }

TemporaryFile::TemporaryFile(const std::string& folder, const std::string& suffix) {
    static std::atomic<unsigned> counter{0};
    path_ = fmt::format("{}/{}{}-{}{}", folder, kTemporaryPrefix, ::getpid(), counter++, suffix);
}

TemporaryFile::~TemporaryFile() {
    if (!published_) ::unlink(path_.c_str());
}

tl::unexpected<Error> TemporaryFile::failed(int error_number) const {
    Error error = cannot_write(path_, error_number);
    error.suggestion = "Set CLAYMELD_CACHE to a folder with space that can be written";
    return tl::unexpected(std::move(error));
}

Result<void> TemporaryFile::check_space(std::size_t size_bytes) const {
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (file < 0) return failed(errno);
    const int error = ::posix_fallocate(file, 0, static_cast<off_t>(size_bytes));
    ::close(file);
    ::unlink(path_.c_str());
    if (error != 0) return failed(error);
    return {};
}

Result<void> TemporaryFile::write(const std::string& bytes) const {
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0) return failed(errno);
    for (std::size_t done = 0; done < bytes.size();) {
        const ::ssize_t count = ::write(file, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) {
            auto error = failed(errno);
            ::close(file);
            return error;
        }
        done += static_cast<std::size_t>(count);
    }
    if (::close(file) != 0) return failed(errno);
    return {};
}

Result<void> TemporaryFile::publish(const std::string& final_path) {
    if (::rename(path_.c_str(), final_path.c_str()) != 0)
        return fail(fmt::format("cannot rename {} to {} ({})", path_, final_path, std::strerror(errno)),
                    "Set CLAYMELD_CACHE to a folder that can be written");
    published_ = true;
    return {};
}

}  // namespace meld
