#include "runtime/comm/launch/child_processes.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>

namespace meld::comm {

namespace {

struct Status {
    char state = '?';  // As the kernel calls it: 'Z' has ended and not been waited for; '?' if it cannot be seen.
    pid_t parent = 0;
};

Status status_of(pid_t process) {
    std::ifstream file(fmt::format("/proc/{}/stat", process));
    std::ostringstream text;
    text << file.rdbuf();
    Status status;
    // The name before it may hold anything, also a parenthesis.
    const std::size_t end = text.str().rfind(") ");
    if (end != std::string::npos) std::istringstream(text.str().substr(end + 2)) >> status.state >> status.parent;
    return status;
}

std::optional<pid_t> number(const std::string& name) {
    pid_t value = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), value);
    return error == std::errc{} && end == name.data() + name.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

bool is_stopped(pid_t process) {
    const char state = status_of(process).state;
    return state == 'T' || state == 't';
}

bool has_ended(pid_t process) {
    const char state = status_of(process).state;
    return state == '?' ? kill(process, 0) != 0 && errno == ESRCH : state == 'Z' || state == 'X';
}

std::vector<pid_t> descendants_of(pid_t process) {
    std::multimap<pid_t, pid_t> children;
    std::error_code none;
    for (std::filesystem::directory_iterator entry("/proc", none), end; !none && entry != end; entry.increment(none)) {
        const std::optional<pid_t> pid = number(entry->path().filename().string());
        if (!pid) continue;
        const Status status = status_of(*pid);
        if (status.state != 'Z' && status.state != '?') children.emplace(status.parent, *pid);
    }
    std::vector<pid_t> all;
    const auto add_children_of = [&](pid_t parent) {
        const auto [first, last] = children.equal_range(parent);
        for (auto child = first; child != last; ++child) all.push_back(child->second);
    };
    add_children_of(process);
    for (std::size_t i = 0; i < all.size(); ++i) add_children_of(all[i]);
    return all;
}

ProgramFile program_at(const std::string& path) {
    struct stat status{};
    return stat(path.c_str(), &status) == 0 ? ProgramFile{status.st_dev, status.st_ino} : ProgramFile{};
}

ProgramFile program_of(pid_t process) { return program_at(fmt::format("/proc/{}/exe", process)); }

bool catches(pid_t process, int signal) {
    constexpr std::string_view key = "SigCgt:";
    std::ifstream file(fmt::format("/proc/{}/status", process));
    for (std::string line; std::getline(file, line);) {
        if (!line.starts_with(key)) continue;
        const std::uint64_t caught = std::strtoull(line.c_str() + key.size(), nullptr, 16);
        return (caught >> (signal - 1) & 1) != 0;
    }
    return false;
}

}  // namespace meld::comm
