// The children of a process and their state, as /proc has them.
#pragma once

#include <sys/types.h>

#include <string>
#include <utility>
#include <vector>

namespace meld::comm {

// Code that watches processes looks at them now and then. A longer time between two looks counts as this: while the watching process was
// stopped, the others may have been, too.
inline constexpr double kMaxBetweenLooks_s = 1;

// Whether it has been stopped, by a signal or a debugger.
bool is_stopped(pid_t process);

// Whether it has ended; its parent may not have waited for it yet.
bool has_ended(pid_t process);

// Its children, their children and so on, without those that have ended. It looks at all processes of the machine: microseconds each.
std::vector<pid_t> descendants_of(pid_t process);

// The file of a program; 0, 0 if there is none. It stays the same file when another takes its path.
using ProgramFile = std::pair<dev_t, ino_t>;
ProgramFile program_at(const std::string& path);
ProgramFile program_of(pid_t process);

// Whether it has a handler for the signal.
bool catches(pid_t process, int signal);

}  // namespace meld::comm
