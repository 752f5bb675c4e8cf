// The few standard headers that a module may include, written with the compiler's own type macros, so that compiling a module needs no C or
// C++ library on the machine and reads nothing from disk.
#pragma once

namespace meld {

struct FreestandingHeader {
    const char* name;
    const char* text;
};

inline constexpr FreestandingHeader kFreestandingHeaders[] = {
    {"stdint.h", R"(#pragma once
typedef __INT8_TYPE__ int8_t;
typedef __INT16_TYPE__ int16_t;
typedef __INT32_TYPE__ int32_t;
typedef __INT64_TYPE__ int64_t;
typedef __UINT8_TYPE__ uint8_t;
typedef __UINT16_TYPE__ uint16_t;
typedef __UINT32_TYPE__ uint32_t;
typedef __UINT64_TYPE__ uint64_t;
typedef __INTPTR_TYPE__ intptr_t;
typedef __UINTPTR_TYPE__ uintptr_t;
typedef __INTMAX_TYPE__ intmax_t;
typedef __UINTMAX_TYPE__ uintmax_t;
#define INT8_MAX __INT8_MAX__
#define INT16_MAX __INT16_MAX__
#define INT32_MAX __INT32_MAX__
#define INT64_MAX __INT64_MAX__
#define INT8_MIN (-__INT8_MAX__ - 1)
#define INT16_MIN (-__INT16_MAX__ - 1)
#define INT32_MIN (-__INT32_MAX__ - 1)
#define INT64_MIN (-__INT64_MAX__ - 1)
#define UINT8_MAX __UINT8_MAX__
#define UINT16_MAX __UINT16_MAX__
#define UINT32_MAX __UINT32_MAX__
#define UINT64_MAX __UINT64_MAX__
#define SIZE_MAX __SIZE_MAX__
#define INT64_C(c) __INT64_C(c)
#define UINT64_C(c) __UINT64_C(c)
#define __INT64_C_JOIN(c, suffix) c##suffix
#define __INT64_C(c) __INT64_C_JOIN(c, L)
#define __UINT64_C(c) __INT64_C_JOIN(c, UL)
)"},
    {"stddef.h", R"(#pragma once
typedef __SIZE_TYPE__ size_t;
typedef __PTRDIFF_TYPE__ ptrdiff_t;
#define NULL nullptr
#define offsetof(type, member) __builtin_offsetof(type, member)
)"},
    {"string.h", R"(#pragma once
#include <stddef.h>
extern "C" {
void* memcpy(void* to, const void* from, size_t size);
void* memmove(void* to, const void* from, size_t size);
void* memset(void* to, int value, size_t size);
int memcmp(const void* left, const void* right, size_t size);
}
)"},
    {"cstdint", R"(#pragma once
#include <stdint.h>
namespace std {
using ::int8_t, ::int16_t, ::int32_t, ::int64_t, ::uint8_t, ::uint16_t, ::uint32_t, ::uint64_t;
using ::intptr_t, ::uintptr_t, ::intmax_t, ::uintmax_t;
}
)"},
    {"cstddef", R"(#pragma once
#include <stddef.h>
namespace std {
using ::size_t, ::ptrdiff_t;
using nullptr_t = decltype(nullptr);
enum class byte : unsigned char {};
}
)"},
    {"cstring", R"(#pragma once
#include <string.h>
namespace std {
using ::memcpy, ::memmove, ::memset, ::memcmp, ::size_t;
}
)"},
};

}  // namespace meld
