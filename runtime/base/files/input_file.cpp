// The path is checked before it is opened, because opening a device may have effects; the open file is checked again, because another one
// may have taken its place. It is opened without waiting, because a pipe may have no writer.
#include "runtime/base/files/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "runtime/base/process/available_memory.h"
#include "runtime/base/units.h"

namespace meld {

namespace {

// The number of bytes read at a time from a source of unknown size.
constexpr std::size_t kBlock_bytes = 1 << 16;

constexpr std::uint64_t kLarge_bytes = 64 << 20;

tl::unexpected<Error> unreadable(const std::string& path, int error) {
    if (error == ENOENT || error == ENOTDIR) return fail(fmt::format("there is no file {}", path));
    return fail(fmt::format("{} cannot be read ({})", path, std::strerror(error)), error == EACCES ? "Check its permissions" : "");
}

tl::unexpected<Error> too_large(const std::string& path, std::uint64_t most_bytes) {
    return fail(fmt::format("{} is larger than {}, the most that is read", path, format_bytes(most_bytes)));
}

// Why a file of this mode is not read; empty if it is.
const char* objection(mode_t mode, InputKind kind) {
    if (S_ISREG(mode) || (S_ISFIFO(mode) && kind == InputKind::FileOrPipe)) return "";
    if (S_ISDIR(mode)) return "folder";
    if (S_ISFIFO(mode)) return "pipe";
    return S_ISSOCK(mode) ? "socket" : "device";
}

Result<void> check_kind(const std::string& path, const struct stat& status, InputKind kind) {
    const std::string what = objection(status.st_mode, kind);
    if (what.empty()) return {};
    return fail(fmt::format("{} is a {}, not a file", path, what), what == "folder" ? "" : "Write its content to a file first");
}

// A large file is read into memory only if there is so much.
Result<void> check_memory(const std::string& path, std::uint64_t bytes) {
    if (bytes < kLarge_bytes) return {};
    const MemoryLimit room = memory_limit(0);
    if (room.bytes == 0 || bytes <= room.bytes) return {};
    return fail(fmt::format("{} takes {} of memory, and {}", path, format_bytes(bytes), room.text), "", ExitCode::LimitHit);
}

class Descriptor {
  public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number() const { return number_; }

  private:
    int number_;
};

}  // namespace

Result<std::string> read_input(const std::string& path, std::uint64_t most_bytes, InputKind kind) {
    struct stat status{};
    if (path.find('\0') != std::string::npos) return unreadable(path.substr(0, path.find('\0')) + "\\0...", ENOENT);
    if (::stat(path.c_str(), &status) != 0) return unreadable(path, errno);
    if (const Result<void> fine = check_kind(path, status, kind); !fine) return tl::unexpected(fine.error());
    const int waiting = S_ISFIFO(status.st_mode) ? 0 : O_NONBLOCK;
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | waiting));
    if (file.number() < 0 || ::fstat(file.number(), &status) != 0) return unreadable(path, errno);
    if (const Result<void> fine = check_kind(path, status, kind); !fine) return tl::unexpected(fine.error());
    const auto told_bytes = static_cast<std::uint64_t>(std::max<off_t>(0, status.st_size));
    if (told_bytes > most_bytes) return too_large(path, most_bytes);
    if (const auto fits = check_memory(path, told_bytes); !fits) return tl::unexpected(fits.error());
    // One byte more than its size: the last read then finds the end without another block.
    std::string text(S_ISREG(status.st_mode) && told_bytes > 0 ? told_bytes + 1 : kBlock_bytes, '\0');
    for (std::size_t size_bytes = 0;;) {
        if (size_bytes == text.size()) text.resize(text.size() + std::max(text.size() / 2, kBlock_bytes));
        const ssize_t count = ::read(file.number(), text.data() + size_bytes, text.size() - size_bytes);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return unreadable(path, errno);
        size_bytes += static_cast<std::size_t>(count);
        if (size_bytes > most_bytes) return too_large(path, most_bytes);
        if (count > 0) continue;
        text.resize(size_bytes);
        return text;
    }
}

}  // namespace meld
