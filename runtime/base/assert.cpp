#include "runtime/base/assert.h"

#include <cstdio>
#include <cstdlib>

namespace meld {

void assertion_failed(const char* kind, const char* condition, const char* file, int line, const std::string& values) {
    std::fprintf(stderr, "%s:%d: internal error: %s failed: %s%s%s\nThis is a bug in Claymeld, not in your program.\n", file, line, kind,
                 condition, values.empty() ? "" : ": ", values.c_str());
    std::fflush(nullptr);
    std::_Exit(70);
}

}  // namespace meld
