// Linked into a program: lists every write to a file that it makes, in the order in which the kernel sees them, in the file named by
// WRITE_LOG. Whoever applies the first n of them has what a process killed after its n-th write leaves behind. Standard output is listed
// too, so that one knows what the program had said by then, and so are new names, with the name.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace {

enum class Kind : std::uint64_t { Write, Length, Said, Named };

// inode, kind, offset or length, bytes that follow.
struct Entry {
    std::uint64_t inode;
    Kind kind;
    std::uint64_t at, size_bytes;
};

template <class Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

void list(int descriptor, Kind kind, std::uint64_t at, const void* bytes, std::size_t size_bytes) {
    static const int log = [] {
        const char* path = std::getenv("WRITE_LOG");
        return path == nullptr ? -1 : open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    }();
    struct stat status{};
    if (log < 0 || fstat(descriptor, &status) != 0 || (!S_ISREG(status.st_mode) && kind != Kind::Said)) return;
    const Entry entry = {status.st_ino, kind, at, size_bytes};
    static const auto write_through = next<ssize_t(int, const void*, size_t)>("write");
    if (write_through(log, &entry, sizeof entry) != sizeof entry ||
        write_through(log, bytes, size_bytes) != static_cast<ssize_t>(size_bytes))
        std::abort();
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, size_t size_bytes) {
    static const auto call = next<ssize_t(int, const void*, size_t)>("write");
    const off_t at = descriptor == STDOUT_FILENO ? 0 : lseek(descriptor, 0, SEEK_CUR);
    const ssize_t written = call(descriptor, bytes, size_bytes);
    if (written > 0)
        list(descriptor, descriptor == STDOUT_FILENO ? Kind::Said : Kind::Write, static_cast<std::uint64_t>(at), bytes,
             static_cast<std::size_t>(written));
    return written;
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size_bytes, off64_t at) {
    static const auto call = next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
    const ssize_t written = call(descriptor, bytes, size_bytes, at);
    if (written > 0) list(descriptor, Kind::Write, static_cast<std::uint64_t>(at), bytes, static_cast<std::size_t>(written));
    return written;
}
ssize_t pwrite(int descriptor, const void* bytes, size_t size_bytes, off_t at) { return pwrite64(descriptor, bytes, size_bytes, at); }

int ftruncate64(int descriptor, off64_t length) noexcept {
    static const auto call = next<int(int, off64_t)>("ftruncate64");
    const int result = call(descriptor, length);
    if (result == 0) list(descriptor, Kind::Length, static_cast<std::uint64_t>(length), nullptr, 0);
    return result;
}
int ftruncate(int descriptor, off_t length) noexcept { return ftruncate64(descriptor, length); }

int fallocate64(int descriptor, int mode, off64_t offset, off64_t length) {
    static const auto call = next<int(int, int, off64_t, off64_t)>("fallocate64");
    const int result = call(descriptor, mode, offset, length);
    if (result == 0 && mode == 0) list(descriptor, Kind::Length, static_cast<std::uint64_t>(offset + length), nullptr, 0);
    return result;
}
int fallocate(int descriptor, int mode, off_t offset, off_t length) { return fallocate64(descriptor, mode, offset, length); }

int rename(const char* from, const char* to) noexcept {
    static const auto call = next<int(const char*, const char*)>("rename");
    const int file = open(from, O_RDONLY | O_CLOEXEC);
    const int result = call(from, to);
    if (result == 0 && file >= 0) list(file, Kind::Named, 0, to, std::strlen(to));
    if (file >= 0) close(file);
    return result;
}

}  // extern "C"
