#include "runtime/base/files/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/files/partial_outputs.h"
#include "runtime/base/process/copied_process.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/liveness.h"

namespace meld {

namespace {

constexpr std::size_t kBufferBytes = 1 << 16;
// As much as keeps a disk busy.
constexpr std::uint64_t kBeginBytes = 1 << 23;
constexpr int kMostLinks = 40;

// "/dev/stdout" and the other names of this process's descriptors. Reopening them would overwrite a redirected file from its start.
std::optional<int> descriptor_named(std::string_view path) {
    if (path == "-" || path == "/dev/stdout") return STDOUT_FILENO;
    if (path == "/dev/stderr") return STDERR_FILENO;
    for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
        if (!path.starts_with(folder)) continue;
        int number = -1;
        const char* const end = path.data() + path.size();
        const auto read = std::from_chars(path.data() + folder.size(), end, number);
        if (read.ec == std::errc{} && read.ptr == end && number >= 0) return number;
    }
    return std::nullopt;
}

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

// The path with all links followed, for a file that may not exist yet, like the target of a dangling link. Sets errno and returns nothing
// if the folder does not exist.
std::optional<std::string> resolve(std::string path) {
    for (int links = 0; links < kMostLinks; ++links) {
        std::error_code error;
        const std::filesystem::path folder =
            std::filesystem::canonical(path.starts_with('/') ? folder_of(path) : "./" + folder_of(path), error);
        if (error) {
            errno = error.value();
            return std::nullopt;
        }
        const std::string here = (folder / path.substr(path.rfind('/') + 1)).string();
        const std::filesystem::path next = std::filesystem::read_symlink(here, error);
        if (error) return here;
        path = (folder / next).string();
    }
    errno = ELOOP;
    return std::nullopt;
}

// `folder/run.part-3f2a91c04b7d65e8.vtkhdf` for `folder/run.vtkhdf`: the extension stays, so that programs recognize the file.
std::string name_beside(const std::string& target) {
    std::uint64_t number = 0;
    // Unpredictable, so that nobody can create a file of this name in advance; O_EXCL makes sure.
    if (getrandom(&number, sizeof number, 0) != sizeof number) number = static_cast<std::uint64_t>(getpid());
    const std::filesystem::path path(target);
    return folder_of(target) + fmt::format("{}.part-{:016x}{}", path.stem().string().substr(0, kMostOfAName), number,
                                           path.extension().string().substr(0, 255 - kMostOfAName - 22));
}

// Whether a file is one that may have been written beside the target, by its name alone.
bool is_name_beside(const std::string& target, const std::string& name) {
    constexpr std::size_t kDigits = 16;
    const std::string like = name_beside(target).substr(folder_of(target).size());
    const std::size_t number =
        std::filesystem::path(target).stem().string().substr(0, kMostOfAName).size() + std::string_view(".part-").size();
    return name.size() == like.size() && name.compare(0, number, like, 0, number) == 0 &&
           name.compare(number + kDigits, std::string::npos, like, number + kDigits) == 0 &&
           name.find_first_not_of("0123456789abcdef", number) >= number + kDigits;
}

// The lock on a target. What a killed process has left there of a file that nobody has seen goes.
Result<OutputLock> take_lock(const std::string& target, const std::string& shown) {
    Result<OutputLock> lock = OutputLock::take(target, shown);
    if (lock && is_name_beside(target, lock->left_behind())) unlink((folder_of(target) + lock->left_behind()).c_str());
    return lock;
}

}  // namespace

Error cannot_write(const std::string& path, int error_number) {
    Error error{fmt::format("cannot write {}: {}", path, std::generic_category().message(error_number))};
    error.code = ExitCode::LimitHit;
    switch (error_number) {
        case ENOSPC:
        case EDQUOT:
            error.suggestion = "Free some space";
            return error;
        case EFBIG:
            error.suggestion = "Raise the limit on the size of files (ulimit -f)";
            return error;
        case EPIPE:
            // The reader of `meldsim world FILE | head -n 1` has what it wanted: there is nothing to say.
            if (path == kStandardOutput) return {.problem = "", .code = error.code};
            error.suggestion = "Whoever was reading it has stopped";
            return error;
        case EIO:
        case ENOMEM:
            return error;
        case EBADF:
            error.suggestion = "It is closed";
            error.code = ExitCode::UsageOrWorld;
            return error;
        default:
            error.suggestion = "Choose a path in a folder that exists and can be written";
            error.code = ExitCode::UsageOrWorld;
            return error;
    }
}

bool OutputFile::names_stream(const std::string& path) {
    struct stat status{};
    return descriptor_named(path) || (stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode));
}

Result<OutputFile> OutputFile::open(const std::string& path, Appears appears, Durability durability) {
    const auto failed = [&](int error_number) { return tl::unexpected(cannot_write(path, error_number)); };
    if (const std::optional<int> standard = descriptor_named(path)) {
        OutputFile file(path == "-" ? kStandardOutput : path, durability);
        file.stream_ = true;
        // Text that the process has printed there comes first.
        std::fflush(nullptr);
        file.descriptor_ = fcntl(*standard, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        if (file.descriptor_ < 0) return tl::unexpected(cannot_write(file.shown_, errno));
        return file;
    }
    struct stat status{};
    if (stat(path.c_str(), &status) == 0) {
        if (S_ISDIR(status.st_mode)) return failed(EISDIR);
        if (!S_ISREG(status.st_mode)) {
            OutputFile file(path, durability);
            file.stream_ = true;
            const liveness::WritesToStream writes;
            file.descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
            if (file.descriptor_ < 0) return failed(errno);
            return file;
        }
    } else if (errno != ENOENT) {
        return failed(errno);
    }
    const std::optional<std::string> target = resolve(path);
    if (!target) return failed(errno);
    if (target->ends_with('/')) return failed(EISDIR);
    return open_regular(path, *target, appears, durability);
}

Result<OutputFile> OutputFile::open_regular(const std::string& shown, const std::string& target, Appears appears, Durability durability) {
    OutputFile file(shown, durability);
    file.target_ = target;
    file.appears_ = appears;
    auto lock = take_lock(target, shown);
    if (!lock) return tl::unexpected(lock.error());
    file.lock_ = std::move(*lock);
    struct stat status{};
    if (stat(target.c_str(), &status) == 0) {
        // Renaming would bypass the protection of the file itself.
        if (faccessat(AT_FDCWD, target.c_str(), W_OK, AT_EACCESS) != 0) return tl::unexpected(cannot_write(shown, errno));
        if (status.st_uid != geteuid() && geteuid() != 0)
            return fail(fmt::format("cannot write {}: it belongs to another user, and would not any more", shown), "Choose another path");
        return file;
    }
    if (appears == Appears::AtOnce) {
        const interrupt::Undivided undivided;
        file.descriptor_ = ::open(target.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (file.descriptor_ < 0) return tl::unexpected(cannot_write(shown, errno));
        file.at_target_ = true;
        file.leftover_ = Leftover(target);
    }
    return file;
}

Result<OutputFile> OutputFile::reopen(const std::string& path, const std::string& place, std::uint64_t size, Durability durability) {
    const std::optional<std::string> target = resolve(path);
    if (!target) return tl::unexpected(cannot_write(path, errno));
    OutputFile file(path, durability);
    file.target_ = *target;
    file.appears_ = Appears::OnceReadable;
    file.appeared_ = true;
    // It stays, whatever becomes of this run.
    file.written_ = true;
    auto lock = take_lock(*target, path);
    if (!lock) return tl::unexpected(lock.error());
    file.lock_ = std::move(*lock);
    std::error_code none;
    file.at_target_ = place == *target || !std::filesystem::exists(place, none);
    file.beside_ = place;
    file.descriptor_ = ::open(file.at_target_ ? target->c_str() : place.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
    struct stat status{};
    if (file.descriptor_ < 0 || fstat(file.descriptor_, &status) != 0 || !S_ISREG(status.st_mode) ||
        static_cast<std::uint64_t>(status.st_size) < size)
        return fail(fmt::format("cannot go on with {}: {}", path, file.descriptor_ < 0 ? "it is gone" : "it is shorter than it was"),
                    "Put it back as the run left it");
    file.offset_ = size;
    return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : shown_(std::move(other.shown_)),
      target_(std::move(other.target_)),
      beside_(std::move(other.beside_)),
      lock_(std::move(other.lock_)),
      leftover_(std::move(other.leftover_)),
      durability_(other.durability_),
      appears_(other.appears_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      stream_(other.stream_),
      at_target_(other.at_target_),
      appeared_(other.appeared_),
      written_(other.written_),
      committed_(other.committed_),
      error_(other.error_),
      reserved_(other.reserved_),
      offset_(other.offset_),
      begun_(other.begun_),
      waiting_(std::move(other.waiting_)) {}

OutputFile::~OutputFile() {
    if (descriptor_ < 0) return;
    if (stays() && !committed_) give_to_system();
    ::close(descriptor_);
    if (!stream_ && !stays()) unlink(at_target_ ? target_.c_str() : beside_.c_str());
}

void OutputFile::set_error(int error_number) {
    if (error_ == 0) error_ = error_number;
}

// The file beside the target, under an unused name, with the mode and owner of the file that it will replace.
bool OutputFile::make_file() {
    if (descriptor_ >= 0 || error_ != 0) return error_ == 0;
    struct stat status{};
    const bool replaces = stat(target_.c_str(), &status) == 0;
    const interrupt::Undivided undivided;
    do {
        beside_ = name_beside(target_);
        if (appears_ == Appears::Whole && lock_) lock_->note(beside_.substr(folder_of(target_).size()));
        descriptor_ = ::open(beside_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, replaces ? 0600 : 0666);
    } while (descriptor_ < 0 && errno == EEXIST);
    if (descriptor_ < 0) set_error(errno);
    if (descriptor_ < 0) return false;
    leftover_ = Leftover(beside_);
    if (!replaces) return error_ == 0;
    const bool other_owner = status.st_uid != geteuid() || status.st_gid != getegid();
    // A group that this user is not in cannot be kept; the mode then gives the new group no more rights than it gave to all.
    const bool owned = !other_owner || fchown(descriptor_, status.st_uid, status.st_gid) == 0;
    const mode_t group = owned ? S_IRWXG : (status.st_mode & S_IRWXO) << 3;
    if (fchmod(descriptor_, status.st_mode & (S_IRWXU | S_IRWXO | group)) != 0) set_error(errno);
    return error_ == 0;
}

void OutputFile::give_to_system() {
    put(waiting_);
    waiting_.clear();
}

void OutputFile::put(std::string_view text) {
    if (text.empty() || !make_file()) return;
    liveness::beat();
    std::optional<liveness::WritesToStream> writes;
    if (stream_) writes.emplace();
    if (!stream_ && lseek(descriptor_, static_cast<off_t>(offset_), SEEK_SET) < 0) set_error(errno);
    if (error_ == 0 && !write_all(descriptor_, text)) set_error(errno != 0 ? errno : EIO);
    offset_ += text.size();
    note_written();
    // What must get to the disk anyway begins now, while more is made. Whether it gets there is what fsync says.
    if (stream_ || durability_ == Durability::Process || offset_ < begun_ + kBeginBytes) return;
    sync_file_range(descriptor_, static_cast<off_t>(begun_), static_cast<off_t>(offset_ - begun_), SYNC_FILE_RANGE_WRITE);
    begun_ = offset_;
}

void OutputFile::note_written() {
    written_ = true;
    if (stays()) leftover_ = {};
}

void OutputFile::write(std::string_view text) {
    MELD_EXPECT(!committed_);
    if (error_ != 0) return;
    if (text.size() >= kBufferBytes) {
        give_to_system();
        return put(text);
    }
    waiting_ += text;
    if (waiting_.size() >= kBufferBytes) give_to_system();
}

Result<void> OutputFile::reserve(std::uint64_t bytes) {
    MELD_EXPECT(!stream_);
    if (bytes == 0) return {};
    int result = make_file() ? 0 : -1;
    while (error_ == 0 && (result = fallocate(descriptor_, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes))) != 0 && errno == EINTR) {
    }
    reserved_ = result == 0;
    if (result != 0 && (errno == ENOSPC || errno == EDQUOT || errno == EFBIG)) set_error(errno);
    if (error_ != 0) return tl::unexpected(cannot_write(shown_, error_));
    return {};
}

void OutputFile::replace_from(std::uint64_t offset, std::string_view text) {
    MELD_EXPECT(!stream_);
    give_to_system();
    offset_ = offset;
    write(text);
    give_to_system();
    if (error_ == 0 && ftruncate(descriptor_, static_cast<off_t>(offset_)) != 0) set_error(errno);
}

Result<void> OutputFile::flush() {
    give_to_system();
    // Pipes and terminals cannot be synchronized, which is not an error.
    if (error_ == 0 && descriptor_ >= 0 && !stream_ && durability_ == Durability::Machine && fsync(descriptor_) != 0) set_error(errno);
    if (error_ != 0) return tl::unexpected(cannot_write(shown_, error_));
    return {};
}

Result<std::string> OutputFile::read_end(std::size_t most) {
    MELD_EXPECT(!stream_);
    give_to_system();
    std::string end(std::min<std::uint64_t>(most, offset_), '\0');
    if (end.empty()) return end;
    const ssize_t read = error_ == 0 ? pread(descriptor_, end.data(), end.size(), static_cast<off_t>(offset_ - end.size())) : -1;
    if (read != static_cast<ssize_t>(end.size())) return fail(fmt::format("cannot read {}", shown_));
    return end;
}

Result<std::string> OutputFile::place() {
    MELD_EXPECT(!stream_);
    if (!make_file()) return tl::unexpected(cannot_write(shown_, error_));
    return at_target_ ? target_ : beside_;
}

Result<void> OutputFile::appear() {
    MELD_EXPECT(appears_ == Appears::OnceReadable && !stream_ && !committed_);
    if (appeared_) return {};
    make_file();
    if (auto flushed = flush(); !flushed) return flushed;
    const interrupt::Undivided undivided;
    appeared_ = true;
    if (stays()) leftover_ = {};
    struct stat status{};
    // What was there before stays until commit().
    if (stat(target_.c_str(), &status) == 0) return {};
    if (rename(beside_.c_str(), target_.c_str()) != 0) {
        set_error(errno);
        return tl::unexpected(cannot_write(shown_, error_));
    }
    at_target_ = true;
    if (!stays()) leftover_ = Leftover(target_);
    return {};
}

Result<void> OutputFile::commit() {
    MELD_EXPECT(!committed_);
    const interrupt::Undivided undivided;
    if (!stream_) make_file();
    give_to_system();
    // What was reserved and is not needed.
    if (reserved_ && error_ == 0 && ftruncate(descriptor_, static_cast<off_t>(offset_)) != 0) set_error(errno);
    if (auto flushed = flush(); !flushed) return flushed;
    if (!stream_ && !at_target_ && rename(beside_.c_str(), target_.c_str()) != 0) {
        set_error(errno);
        return tl::unexpected(cannot_write(shown_, error_));
    }
    committed_ = true;
    leftover_ = {};
    if (stream_ || durability_ == Durability::Process) return {};
    return sync_name();
}

// Makes sure that the new name is in the folder on the disk.
Result<void> OutputFile::sync_name() {
    const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0 || fsync(folder) != 0) set_error(errno);
    if (folder >= 0) ::close(folder);
    if (error_ != 0) return tl::unexpected(cannot_write(shown_, error_));
    return {};
}

Result<void> OutputFile::sync() {
    if (auto flushed = flush(); !flushed || stream_) return flushed;
    if (durability_ == Durability::Process && descriptor_ >= 0 && fsync(descriptor_) != 0) set_error(errno);
    if (error_ != 0) return tl::unexpected(cannot_write(shown_, error_));
    return sync_name();
}

Result<void> write_file(const std::string& path, std::string_view text) {
    auto file = OutputFile::open(path, Appears::Whole);
    if (!file) return tl::unexpected(file.error());
    file->write(text);
    return file->commit();
}

std::set<std::string> partial_outputs_of(const std::string& target) {
    std::set<std::string> found;
    const std::optional<std::string> place = resolve(target);
    if (!place) return found;
    std::error_code error;
    for (std::filesystem::directory_iterator at(std::filesystem::path(*place).parent_path().empty() ? "." : folder_of(*place), error), end;
         !error && at != end; at.increment(error))
        if (const std::string name = at->path().filename().string(); is_name_beside(*place, name)) found.insert(folder_of(*place) + name);
    return found;
}

}  // namespace meld
