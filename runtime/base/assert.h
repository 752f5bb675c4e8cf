// Assertions about our own code: preconditions, invariants and results. They never report a mistake of the user.
#pragma once

#include <fmt/format.h>

#include <string>

namespace meld {

// Prints the failed condition with its place and values, then ends the process with exit code 70 ("our own bug").
[[noreturn]] void assertion_failed(const char* kind, const char* condition, const char* file, int line, const std::string& values);

}  // namespace meld

// MELD_CHECK is always on. The other three say what a function expects, holds and ensures; they are on in debug builds.
#define MELD_CHECK_AS(kind, condition, ...)                                                              \
    do {                                                                                                 \
        if (!(condition)) [[unlikely]]                                                                   \
            ::meld::assertion_failed(kind, #condition, __FILE__, __LINE__, fmt::format("" __VA_ARGS__)); \
    } while (false)
#define MELD_CHECK(condition, ...) MELD_CHECK_AS("check", condition, __VA_ARGS__)

#ifdef CLAYMELD_ASSERTIONS
#define MELD_EXPECT(condition, ...) MELD_CHECK_AS("expect", condition, __VA_ARGS__)
#define MELD_ASSERT(condition, ...) MELD_CHECK_AS("assert", condition, __VA_ARGS__)
#define MELD_ENSURE(condition, ...) MELD_CHECK_AS("ensure", condition, __VA_ARGS__)
#else
#define MELD_EXPECT(condition, ...) static_cast<void>(sizeof(!(condition)))
#define MELD_ASSERT(condition, ...) static_cast<void>(sizeof(!(condition)))
#define MELD_ENSURE(condition, ...) static_cast<void>(sizeof(!(condition)))
#endif
