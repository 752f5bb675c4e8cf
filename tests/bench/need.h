// The value of a result; the program ends with the message where there is none.
#pragma once

#include <fmt/format.h>

#include <cstdlib>

#include "runtime/base/error.h"

namespace meld::bench {

inline void need(const Result<void>& result) {
    if (result) return;
    fmt::print(stderr, "{}\n", result.error().message());
    std::exit(static_cast<int>(result.error().code));
}

template <class T>
T need(Result<T> result) {
    if (!result) need(Result<void>(tl::unexpected(result.error())));
    return std::move(*result);
}

}  // namespace meld::bench
