// Runs a function in a child process: for work that a damaged file may crash.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "runtime/base/error.h"

namespace meld::model {

struct ChildLimits {
    std::uint64_t memory_bytes = std::uint64_t{4} << 30;  // In addition to what this process has.
    std::uint64_t processor_s = 600;
    std::uint64_t answer_bytes = std::uint64_t{2} << 30;
};

// Calls `work` in a copy of this process and returns what it returns there; its side effects are lost. Errors: the copy cannot be made; it
// crashes, as `crashed` says with the reason behind it; it exceeds a limit.
Result<std::string> run_in_child(const std::function<std::string()>& work, const std::string& crashed, const ChildLimits& limits);

}  // namespace meld::model
