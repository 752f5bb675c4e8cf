#include "runtime/base/output_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>
#include <utility>

#include "runtime/base/interrupt.h"
#include "runtime/base/output_file.h"

namespace meld {

namespace {

constexpr std::string_view kBefore = ".", kBehind = ".claymeld-lock";

// The holder of the lock, as written in the file.
std::string holder_of(int descriptor) {
    std::array<char, 24> text{};
    const ssize_t size = pread(descriptor, text.data(), text.size(), 0);
    const std::string_view number(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    if (number.empty() || number.find_first_not_of("0123456789\n") != std::string_view::npos) return "another process";
    return fmt::format("process {}", number.substr(0, number.find('\n')));
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
        const std::string holder = fmt::format("{}\n", getpid());
        // On a full disk the lock still holds, but a second run does not learn who has it.
        [[maybe_unused]] const bool named =
            ftruncate(descriptor, 0) == 0 && pwrite(descriptor, holder.data(), holder.size(), 0) == static_cast<ssize_t>(holder.size());
        return OutputLock(file, descriptor);
    }
}

OutputLock::OutputLock(OutputLock&& other) noexcept
    : leftover_(std::move(other.leftover_)), file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

OutputLock& OutputLock::operator=(OutputLock&& other) noexcept {
    std::swap(leftover_, other.leftover_);
    std::swap(file_, other.file_);
    std::swap(descriptor_, other.descriptor_);
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
