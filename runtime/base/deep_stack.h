// A stack of fixed size for programs that walk trees by recursion, and one response to running out of memory.
#pragma once

#include <functional>
#include <string>

namespace meld {

// Calls `program` on a thread with a stack of 512 MB, or of a share of what RLIMIT_AS leaves, so that the depth of recursion does not
// depend on `ulimit -s`; threads that it starts get such stacks too. Pages that are never touched take no memory. Returns what `program`
// returns. Call it once, from main(). From then on an allocation that fails, or a thread that cannot be started, prints one line that
// begins with `name` and ends the process with ExitCode::LimitHit.
int with_deep_stack(const std::string& name, const std::function<int()>& program);

// Installs the same response to a failed allocation, without the stack. `name` must live as long as the process.
void end_when_memory_runs_out(const std::string& name);

}  // namespace meld
