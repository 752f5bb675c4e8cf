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

// The same without the stack, for programs that MPI starts threads in: first what an allocation that fails does, then a call in which
// limits of containers and of threads end the process likewise.
void end_when_memory_runs_out(const std::string& name);
int ending_when_memory_runs_out(const std::function<int()>& program);
// For allocations that do not throw, on any thread.
[[noreturn]] void memory_has_run_out();

}  // namespace meld
