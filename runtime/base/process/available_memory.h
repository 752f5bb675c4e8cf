// How much memory this process may still have.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace meld {

struct AvailableMemory {
    std::uint64_t bytes = 0;  // 0: not known.
    std::string by = {};      // What leaves no more, as a message names it: "the machine", "the cgroup", "ulimit -v".
};

// The least of what the kernel can give without swapping, what the cgroups around this process leave (version 1 or 2), and what
// RLIMIT_AS and RLIMIT_DATA leave. `root` is a folder with `proc` and `sys`, / but for tests.
AvailableMemory available_memory(const std::string& root = "/");

// What something may take, and how a message says so: "16 GiB are allowed by [limits] memory", "3 GiB are left by the cgroup".
struct MemoryLimit {
    std::uint64_t bytes = 0;  // 0: none.
    std::string text = {};
    bool of_all = false;  // It counts what the processes have already.
};
// What a user allows, or what is available if that is 0.
MemoryLimit memory_limit(std::uint64_t allowed_bytes);

// What this process has in memory, and the most that it has had; 0: not known.
struct ResidentMemory {
    std::uint64_t now = 0, peak = 0;
};
ResidentMemory resident_memory(const std::string& root = "/");
// What a process has in memory that no other shares; 0: not known, or it has ended. `process` 0 is this one.
std::uint64_t own_memory(pid_t process);

}  // namespace meld
