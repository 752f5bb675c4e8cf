#include "runtime/results/hdf5/disk_space.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <fmt/format.h>
#include <cerrno>
#include <cstring>

#include "runtime/base/units.h"

namespace meld::record {

namespace {

// A file that is closed at the end of its scope.
class File {
  public:
    explicit File(const std::string& path) : descriptor_(open(path.c_str(), O_WRONLY | O_CLOEXEC)) {}
    ~File() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    int descriptor() const { return descriptor_; }

  private:
    int descriptor_;
};

std::optional<std::string> look_at_free_space(int descriptor, std::uint64_t bytes) {
    struct statvfs disk = {};
    if (fstatvfs(descriptor, &disk) != 0) return std::nullopt;
    const std::uint64_t available = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
    if (available >= bytes) return std::nullopt;
    return fmt::format("no space: {} are needed, {} are free", format_bytes(bytes), format_bytes(available));
}

}  // namespace

std::optional<std::string> reserve_growth(const std::string& path, std::uint64_t bytes) {
    const File file(path);
    struct stat status = {};
    if (file.descriptor() < 0 || fstat(file.descriptor(), &status) != 0) return std::strerror(errno);
    const auto size_bytes = static_cast<std::uint64_t>(status.st_size);

    rlimit limit = {};
    if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && size_bytes + bytes > limit.rlim_cur)
        return fmt::format("no space: files may have {}, {} are needed", format_bytes(limit.rlim_cur), format_bytes(size_bytes + bytes));

    while (fallocate(file.descriptor(), 0, status.st_size, static_cast<off_t>(bytes)) != 0) {
        if (errno == EINTR) continue;
        if (errno == ENOSPC || errno == EDQUOT || errno == EFBIG) return fmt::format("no space: {} are needed", format_bytes(bytes));
        if (auto reason = look_at_free_space(file.descriptor(), bytes)) return reason;
        if (ftruncate(file.descriptor(), status.st_size + static_cast<off_t>(bytes)) != 0) return std::strerror(errno);
        break;
    }
    return std::nullopt;
}

}  // namespace meld::record
