// Cache housekeeping. It fails a compilation only if the folder or a file cannot be written.
#include "compiler/build/module_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <system_error>
#include <vector>

#include "runtime/base/files/output_file.h"

namespace meld {
namespace {

namespace fs = std::filesystem;

const std::string kTemporaryPrefix = "tmp-";
// For what a process on another machine has left. A compilation takes a fraction of a second; an hour allows for a stopped process.
constexpr std::chrono::hours kTemporaryLifetime{1};

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? std::string() : std::string(value);
}

constexpr const char* kOtherFolder = "CLAYMELD_CACHE=FOLDER, or --cache FOLDER of meldc compile";

// From the system's user database; empty if it has none.
std::string home_of_user() {
    passwd entry{};
    passwd* found = nullptr;
    std::vector<char> texts(1 << 16);
    ::getpwuid_r(::geteuid(), &entry, texts.data(), texts.size(), &found);
    return found == nullptr || found->pw_dir == nullptr ? std::string() : std::string(found->pw_dir);
}

// The nearest folder above this one in which everybody may rename files of others; empty if there is none. The sticky bit, as on /tmp,
// forbids that.
std::string open_ancestor(const fs::path& folder) {
    std::error_code error;
    for (fs::path at = fs::canonical(folder, error); !error && at != at.parent_path(); at = at.parent_path()) {
        struct stat status{};
        const fs::path above = at.parent_path();
        if (::stat(above.c_str(), &status) == 0 && (status.st_mode & S_IWOTH) != 0 && (status.st_mode & S_ISVTX) == 0)
            return above.string();
    }
    return "";
}

// For the names of temporary files.
std::uint64_t unpredictable() {
    std::uint64_t bits = 0;
    if (::getrandom(&bits, sizeof bits, 0) != sizeof bits) bits = std::random_device{}();
    return bits;
}

// Where process numbers mean what they mean here: this machine since it started, and this container. The folder may be on several.
std::string place_of_processes() {
    std::string boot;
    std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
    std::error_code none;
    const std::string both = boot + fs::read_symlink("/proc/self/ns/pid", none).string();
    return fmt::format("{:016x}", XXH3_64bits(both.data(), both.size()));
}

// The names of temporary files that were made here begin so. The number of the process follows, by which others can tell whether it is
// still there.
const std::string& prefix_here() {
    static const std::string prefix = fmt::format("{}{}-", kTemporaryPrefix, place_of_processes());
    return prefix;
}

bool owner_is_dead(const std::string& name) {
    if (!name.starts_with(prefix_here())) return false;
    const long process = std::strtol(name.c_str() + prefix_here().size(), nullptr, 10);
    return process > 0 && ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
}

struct CachedFile {
    fs::path path;
    fs::file_time_type used;
    std::uintmax_t size_bytes;
    bool piece;
};

// The modules and pieces in the folder, oldest first; stale temporary files are removed on the way.
std::vector<CachedFile> list_files(const std::string& folder) {
    std::vector<CachedFile> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code gone;
        const fs::file_time_type used = entry->last_write_time(gone);
        const std::uintmax_t size_bytes = entry->file_size(gone);
        if (gone) continue;
        const std::string name = entry->path().filename().string();
        if (name.starts_with(kTemporaryPrefix)) {
            if (owner_is_dead(name) || fs::file_time_type::clock::now() - used > kTemporaryLifetime) fs::remove(entry->path(), gone);
        } else if (const fs::path kind = entry->path().extension(); kind == kModuleExtension || kind == kPieceExtension) {
            files.push_back({entry->path(), used, size_bytes, kind == kPieceExtension});
        }
    }
    std::sort(files.begin(), files.end(),
              [](const CachedFile& a, const CachedFile& b) { return a.used != b.used ? a.used < b.used : a.path < b.path; });
    return files;
}

}  // namespace

std::string default_cache_dir() {
    if (const std::string folder = environment("CLAYMELD_CACHE"); !folder.empty()) return folder;
    // A relative path would mean another folder for each working directory.
    if (const std::string folder = environment("XDG_CACHE_HOME"); folder.starts_with('/')) return folder + "/claymeld";
    std::string home = environment("HOME");
    if (!home.starts_with('/')) home = home_of_user();
    return home.starts_with('/') ? home + "/.cache/claymeld" : "";
}

Result<void> make_cache_dir(const std::string& folder) {
    const auto refuse = [&](const std::string& why, const std::string& cure) {
        return fail(fmt::format("the module cache {} cannot be used: {}", folder, why), cure);
    };
    if (folder.empty())
        return fail("there is no folder for compiled modules: neither HOME nor XDG_CACHE_HOME is set, and the user has no home",
                    fmt::format("Name a folder of your own: {}", kOtherFolder));
    std::error_code error;
    const fs::path path = fs::absolute(folder, error).lexically_normal();
    fs::create_directories(path.has_filename() ? path.parent_path() : path.parent_path().parent_path(), error);
    if (error || (::mkdir(path.c_str(), S_IRWXU) != 0 && errno != EEXIST))
        return fail(fmt::format("cannot make the module cache {} ({})", folder, error ? error.message() : std::strerror(errno)),
                    fmt::format("Name a folder that can be written: {}", kOtherFolder));
    struct stat status{};
    if (::stat(path.c_str(), &status) != 0) return refuse(std::strerror(errno), kOtherFolder);
    if (!S_ISDIR(status.st_mode)) return refuse("it is no folder", kOtherFolder);
    if (status.st_uid != ::geteuid())
        return refuse(fmt::format("it belongs to another user (number {}), whose modules would run as you", status.st_uid),
                      fmt::format("Name a folder of your own: {}", kOtherFolder));
    if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        return refuse("others may enter it, and a module in it is a program that runs as you", fmt::format("chmod 700 {}", folder));
    if (const std::string open = open_ancestor(path); !open.empty())
        return refuse(fmt::format("everybody may put another folder in its place, since {} is open to all", open),
                      fmt::format("Name a folder of your own: {}", kOtherFolder));
    return {};
}

void evict(const std::string& folder, const std::string& keep, const CacheLimits& limits) {
    const std::vector<CachedFile> files = list_files(folder);
    std::size_t modules = 0, pieces = 0;
    std::uintmax_t size_bytes = 0;
    for (const CachedFile& file : files) {
        size_bytes += file.size_bytes;
        ++(file.piece ? pieces : modules);
    }
    for (const CachedFile& file : files) {
        const bool crowded = file.piece ? pieces > limits.pieces : modules > limits.files;
        if ((!crowded && size_bytes <= limits.size_bytes) || file.path == fs::path(keep)) continue;
        // Another process may have begun to use it since.
        std::error_code gone;
        if (fs::last_write_time(file.path, gone) != file.used && !gone) continue;
        fs::remove(file.path, gone);
        --(file.piece ? pieces : modules);
        size_bytes -= file.size_bytes;
    }
}

void touch(const std::string& path) { ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0); }

TemporaryFile::TemporaryFile(const std::string& folder, const std::string& suffix) {
    path_ = fmt::format("{}/{}{}-{:016x}{}", folder, prefix_here(), ::getpid(), unpredictable(), suffix);
    leftover_ = Leftover(path_);
}

TemporaryFile::~TemporaryFile() {
    if (!published_) ::unlink(path_.c_str());
}

tl::unexpected<Error> TemporaryFile::failed(int error_number) const {
    const Error error = cannot_write(path_, error_number);
    return fail(error.problem, "Set CLAYMELD_CACHE to a folder with space that can be written", error.code);
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
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
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
    leftover_ = {};
    return {};
}

}  // namespace meld
