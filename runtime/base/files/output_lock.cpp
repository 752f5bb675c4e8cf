#include "runtime/base/files/output_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/process/interrupt.h"

namespace meld {

namespace {

constexpr std::string_view kBefore = ".", kBehind = ".claymeld-lock";

// What is written in the file: the holder on the first line, and what it has noted on the second.
std::string line_of(int descriptor, int line) {
    std::array<char, 512> text{};
    const ssize_t size = pread(descriptor, text.data(), text.size(), 0);
    std::string_view rest(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    const auto end = [&] { return std::min(rest.size(), rest.find('\n')); };
    for (; line > 0; --line) rest.remove_prefix(std::min(rest.size(), end() + 1));
    return std::string(rest.substr(0, end()));
}

std::string holder_of(int descriptor) {
    const std::string number = line_of(descriptor, 0);
    if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) return "another process";
    return fmt::format("process {}", number);
}

// Whether the file at this path is the open one; it is not if its last holder has removed it in the meantime.
bool still_there(const std::string& file, int descriptor) {
    struct stat by_name{}, by_descriptor{};
    return lstat(file.c_str(), &by_name) == 0 && fstat(descriptor, &by_descriptor) == 0 && by_name.st_dev == by_descriptor.st_dev &&
           by_name.st_ino == by_descriptor.st_ino;
}

}  // namespace

std::optional<std::string> OutputLock::locked_by(const std::string& name) {
    if (!name.starts_with(kBefore) || !name.ends_with(kBehind) || name.size() < kBefore.size() + kBehind.size()) return std::nullopt;
    return name.substr(kBefore.size(), name.size() - kBefore.size() - kBehind.size());
}

Result<OutputLock> OutputLock::take(const std::string& path, const std::string& shown) {
    const std::size_t name = path.rfind('/') + 1;
    const std::string file = fmt::format("{}{}{}{}", path.substr(0, name), kBefore, path.substr(name, kMostOfAName), kBehind);
    const interrupt::Undivided undivided;
    while (true) {
        const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644);
        if (descriptor < 0) return tl::unexpected(cannot_write(shown, errno));
        // Also true if the file system has no locks: then the file only shows that the folder can be written.
        const bool taken = flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
        if (!taken) {
            const std::string holder = holder_of(descriptor);
            ::close(descriptor);
            return fail(fmt::format("cannot write {}: {}, which still runs, is writing it", shown, holder),
                        "Wait until it ends, or choose another path");
        }
        if (!still_there(file, descriptor)) {
            ::close(descriptor);
            continue;
        }
        std::string left_behind = line_of(descriptor, 1);
        const std::string holder = fmt::format("{}\n", getpid());
        // On a full disk the lock still holds, but a second run does not learn who has it.
        [[maybe_unused]] const bool named =
            ftruncate(descriptor, 0) == 0 && pwrite(descriptor, holder.data(), holder.size(), 0) == static_cast<ssize_t>(holder.size());
        return OutputLock(file, descriptor, std::move(left_behind));
    }
}

void OutputLock::note(const std::string& name) const {
    // On a full disk nobody learns of it.
    const std::string text = fmt::format("{}\n{}\n", getpid(), name);
    [[maybe_unused]] const ssize_t written = pwrite(descriptor_, text.data(), text.size(), 0);
}

OutputLock::OutputLock(OutputLock&& other) noexcept
    : leftover_(std::move(other.leftover_)),
      file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      left_behind_(std::move(other.left_behind_)) {}

OutputLock& OutputLock::operator=(OutputLock&& other) noexcept {
    std::swap(leftover_, other.leftover_);
    std::swap(file_, other.file_);
    std::swap(descriptor_, other.descriptor_);
    std::swap(left_behind_, other.left_behind_);
    return *this;
}

// Removed while it is held, so that it never belongs to another process.
OutputLock::~OutputLock() {
    if (descriptor_ < 0) return;
    const interrupt::Undivided undivided;
    if (still_there(file_, descriptor_)) unlink(file_.c_str());
    ::close(descriptor_);
    leftover_ = {};
}

}  // namespace meld
