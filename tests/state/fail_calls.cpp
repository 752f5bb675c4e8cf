// Loaded into a program by LD_PRELOAD: calls that write a file fail. FAIL_PATH is a part of the file's path, FAIL_AT which of the calls
// fails, from 1; with FAIL_ON all later ones fail too, as on a disk that broke. FAIL_ERRNO is how. A call that fails is added to the
// file FAIL_LOG.
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

template <class Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int number(const char* name) {
    const char* text = std::getenv(name);
    return text == nullptr ? 0 : std::atoi(text);
}

// Whether this call is to fail; errno is set then.
bool fails(const char* call, const char* path) {
    static const char* const wanted = std::getenv("FAIL_PATH");
    static const int at = number("FAIL_AT"), error = number("FAIL_ERRNO");
    static const bool on = number("FAIL_ON") != 0;
    static std::atomic<int> calls{0};
    if (wanted == nullptr || std::strstr(path, wanted) == nullptr) return false;
    const int this_one = ++calls;
    if (this_one != at && !(on && this_one > at)) return false;
    if (const char* log = std::getenv("FAIL_LOG"); this_one == at && log != nullptr) {
        if (std::FILE* file = std::fopen(log, "a"); file != nullptr) {
            std::fprintf(file, "%s %s\n", call, path);
            std::fclose(file);
        }
    }
    errno = error;
    return true;
}

bool fails(const char* call, int descriptor) {
    char link[64], path[PATH_MAX + 1];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t size = readlink(link, path, PATH_MAX);
    if (size < 0) return false;
    path[size] = '\0';
    return fails(call, path);
}

}  // namespace

extern "C" {

// A disk takes a part of what it cannot take as a whole.
ssize_t write(int descriptor, const void* bytes, size_t size_bytes) {
    static const auto call = next<ssize_t(int, const void*, size_t)>("write");
    if (!fails("write", descriptor)) return call(descriptor, bytes, size_bytes);
    const int error = errno;
    if (call(descriptor, bytes, size_bytes / 2) < 0) return -1;
    errno = error;
    return -1;
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size_bytes, off64_t at) {
    static const auto call = next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
    return fails("pwrite", descriptor) ? -1 : call(descriptor, bytes, size_bytes, at);
}
ssize_t pwrite(int descriptor, const void* bytes, size_t size_bytes, off_t at) { return pwrite64(descriptor, bytes, size_bytes, at); }

int ftruncate64(int descriptor, off64_t length) noexcept {
    static const auto call = next<int(int, off64_t)>("ftruncate64");
    return fails("ftruncate", descriptor) ? -1 : call(descriptor, length);
}
int ftruncate(int descriptor, off_t length) noexcept { return ftruncate64(descriptor, length); }

int fallocate64(int descriptor, int mode, off64_t offset, off64_t length) {
    static const auto call = next<int(int, int, off64_t, off64_t)>("fallocate64");
    return fails("fallocate", descriptor) ? -1 : call(descriptor, mode, offset, length);
}
int fallocate(int descriptor, int mode, off_t offset, off_t length) { return fallocate64(descriptor, mode, offset, length); }

int fsync(int descriptor) {
    static const auto call = next<int(int)>("fsync");
    return fails("fsync", descriptor) ? -1 : call(descriptor);
}

int rename(const char* from, const char* to) noexcept {
    static const auto call = next<int(const char*, const char*)>("rename");
    return fails("rename", to) ? -1 : call(from, to);
}

int open64(const char* path, int flags, ...) {
    static const auto call = next<int(const char*, int, ...)>("open64");
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return (flags & O_CREAT) != 0 && fails("open", path) ? -1 : call(path, flags, mode);
}
int open(const char* path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    return open64(path, flags, mode);
}

}  // extern "C"
