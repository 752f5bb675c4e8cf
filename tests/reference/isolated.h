// Runs something in a child process, so that an assertion, a crash or an endless loop of the compiler or the runtime is one
// more answer, and can be made small like any other.
#pragma once

#include <functional>
#include <string>

namespace meld::reference {

// What body() returns in the child; or "crash: ..." with what the child has said last, where it ended in another way or took
// longer than the limit.
std::string isolated(const std::function<std::string()>& body, unsigned limit_seconds = 120);

}  // namespace meld::reference
