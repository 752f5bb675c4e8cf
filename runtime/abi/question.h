// The view that answers a question about a run, by its name in a module: the compiler makes it of a Meld body (compiler/front/question.h),
// and `meldsim bisect` reads it. No program can write such a name.
#pragma once

#include <string_view>

namespace meld {

inline constexpr std::string_view kQuestion = "question@";

}  // namespace meld
