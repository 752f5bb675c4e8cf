#include "runtime/comm/launch/shared_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace meld::comm {

namespace {

namespace fs = std::filesystem;

std::string base_folder() {
    const char* const chosen = std::getenv(SharedFolder::kVariable);
    return chosen != nullptr ? chosen : "/dev/shm";
}

std::string prefix() { return fmt::format("claymeld-{}-", geteuid()); }

// Locks the folder; −1 if somebody else has, or it is not ours.
int lock(const std::string& folder) {
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor < 0) return -1;
    struct stat status{};
    if (fstat(descriptor, &status) == 0 && status.st_uid == geteuid() && flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
    close(descriptor);
    return -1;
}

void remove(const std::string& folder) {
    std::error_code none;
    fs::remove_all(folder, none);
}

void remove_abandoned(const std::string& base) {
    std::error_code none;
    for (fs::directory_iterator each(base, none), end; !none && each != end; each.increment(none)) {
        if (!each->path().filename().string().starts_with(prefix())) continue;
        const int descriptor = lock(each->path().string());
        if (descriptor < 0) continue;
        remove(each->path().string());
        close(descriptor);
    }
}

}  // namespace

SharedFolder::SharedFolder() {
    const std::string base = base_folder();
    remove_abandoned(base);
    // A folder that is not locked yet may be taken for an abandoned one.
    for (int attempt = 0; attempt < 3 && path_.empty(); ++attempt) {
        std::string folder = base + "/" + prefix() + "XXXXXX";
        if (mkdtemp(folder.data()) == nullptr) return;
        descriptor_ = lock(folder);
        struct stat by_name{}, by_descriptor{};
        const bool there = descriptor_ >= 0 && lstat(folder.c_str(), &by_name) == 0 && fstat(descriptor_, &by_descriptor) == 0 &&
                           by_name.st_ino == by_descriptor.st_ino;
        if (there)
            path_ = folder;
        else if (descriptor_ >= 0)
            close(descriptor_);
    }
}

SharedFolder::~SharedFolder() {
    if (path_.empty()) return;
    remove(path_);
    close(descriptor_);
}

}  // namespace meld::comm
