#include "runtime/driver/session/open_link.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>

namespace meld::driver {

namespace {

bool is_set(const char* variable) {
    const char* const value = std::getenv(variable);
    return value != nullptr && *value != '\0';
}

}  // namespace

bool OpenedLink::can_open() { return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"); }

OpenedLink::OpenedLink(const std::string& link) {
    std::error_code error;
    constexpr std::string_view kSuffix = ".html";
    std::string path = (std::filesystem::temp_directory_path(error) / "meldsim-view-XXXXXX").string() + std::string(kSuffix);
    const int file = error ? -1 : ::mkostemps(path.data(), static_cast<int>(kSuffix.size()), O_CLOEXEC);
    if (file < 0) return;
    path_ = path;
    leftover_ = Leftover(path_);
    const std::string text =
        fmt::format("<!doctype html><meta http-equiv=\"refresh\" content=\"0;url={0}\"><a href=\"{0}\">{0}</a>\n", link);
    const bool written = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    ::close(file);
    if (!written) return;
    posix_spawn_file_actions_t quietly;
    posix_spawn_file_actions_init(&quietly);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        posix_spawn_file_actions_addopen(&quietly, stream, "/dev/null", O_RDWR, 0);
    std::array<char*, 3> words = {const_cast<char*>("xdg-open"), path_.data(), nullptr};
    pid_t child = 0;
    static_cast<void>(::posix_spawnp(&child, "xdg-open", &quietly, nullptr, words.data(), environ));
    posix_spawn_file_actions_destroy(&quietly);
}

OpenedLink::~OpenedLink() {
    if (!path_.empty()) ::unlink(path_.c_str());
}

}  // namespace meld::driver
