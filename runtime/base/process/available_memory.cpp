#include "runtime/base/process/available_memory.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "runtime/base/units.h"

namespace meld {

namespace {

// The number that a file begins with; none for "max" and files that are not there.
std::optional<std::uint64_t> number_in(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::uint64_t number = 0;
    return file >> number ? std::optional(number) : std::nullopt;
}

// The number in the line of a file that begins with `name`.
std::optional<std::uint64_t> number_named(const std::filesystem::path& path, const std::string& name) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string first;
        std::uint64_t number = 0;
        if (words >> first >> number && first == name) return number;
    }
    return std::nullopt;
}

class Least {
  public:
    void limit(std::uint64_t most, std::uint64_t used, const char* by) {
        const std::uint64_t left = most > used ? most - used : 1;
        if (least_.bytes != 0 && least_.bytes <= left) return;
        least_ = {left, by};
    }
    const AvailableMemory& least() const { return least_; }

  private:
    AvailableMemory least_;
};

// A group and all those around it: each has a limit of its own. What the page cache holds can be had back.
void limit_by_groups(const std::filesystem::path& mount, const std::string& group, const char* most, const char* used, const char* cache,
                     Least& out) {
    std::filesystem::path folder = mount / std::filesystem::path(group).relative_path();
    while (true) {
        const auto limit = number_in(folder / most), taken = number_in(folder / used);
        const std::uint64_t cached = number_named(folder / "memory.stat", cache).value_or(0);
        // Version 1 writes a number near the end of 64 bits where there is no limit.
        if (limit && taken && *limit < std::uint64_t{1} << 60) out.limit(*limit, *taken - std::min(*taken, cached), "the cgroup");
        if (folder == mount || !folder.has_relative_path()) return;
        folder = folder.parent_path();
    }
}

void limit_by_cgroups(const std::filesystem::path& root, Least& out) {
    std::ifstream groups(root / "proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        // "0::/user.slice" is of version 2, "9:memory:/user.slice" of version 1.
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) continue;
        const std::string controllers = line.substr(first + 1, second - first - 1), group = line.substr(second + 1);
        if (controllers.empty())
            limit_by_groups(root / "sys/fs/cgroup", group, "memory.max", "memory.current", "inactive_file", out);
        else if (("," + controllers + ",").find(",memory,") != std::string::npos)
            limit_by_groups(root / "sys/fs/cgroup/memory", group, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file",
                            out);
    }
}

void limit_by_resource(int resource, const std::filesystem::path& status, const char* used, const char* by, Least& out) {
    rlimit limit{};
    if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
    out.limit(limit.rlim_cur, number_named(status, used).value_or(0) * 1024, by);
}

}  // namespace

AvailableMemory available_memory(const std::string& root) {
    const std::filesystem::path top = root;
    Least out;
    if (const auto kib = number_named(top / "proc/meminfo", "MemAvailable:")) out.limit(*kib * 1024, 0, "the machine");
    limit_by_cgroups(top, out);
    limit_by_resource(RLIMIT_AS, top / "proc/self/status", "VmSize:", "ulimit -v", out);
    limit_by_resource(RLIMIT_DATA, top / "proc/self/status", "VmData:", "ulimit -d", out);
    return out.least();
}

MemoryLimit memory_limit(std::uint64_t allowed_bytes) {
    if (allowed_bytes > 0) return {allowed_bytes, fmt::format("{} are allowed by [limits] memory", format_bytes(allowed_bytes)), true};
    const AvailableMemory available = available_memory();
    return {available.bytes, fmt::format("{} are {}", format_bytes(available.bytes),
                                         available.by == "the machine" ? "available" : "left by " + available.by)};
}

ResidentMemory resident_memory(const std::string& root) {
    const std::filesystem::path status = std::filesystem::path(root) / "proc/self/status";
    return {number_named(status, "VmRSS:").value_or(0) * 1024, number_named(status, "VmHWM:").value_or(0) * 1024};
}

std::uint64_t own_memory(pid_t process) {
    const std::string of = process == 0 ? "self" : std::to_string(process);
    return number_named(fmt::format("/proc/{}/status", of), "RssAnon:").value_or(0) * 1024;
}

}  // namespace meld
