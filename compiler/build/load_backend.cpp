// Where the program finds its backend is in its RUNPATH, which cmake/MeldBuild.cmake sets.
#include "compiler/build/load_backend.h"

#include <dlfcn.h>
#include <fmt/format.h>

namespace meld {
namespace {

Result<const Backend*> open_backend() {
    void* handle = ::dlopen(kBackendLibrary, RTLD_LAZY | RTLD_LOCAL);
    void* entry = handle == nullptr ? nullptr : ::dlsym(handle, kBackendEntry);
    if (entry == nullptr) {
        const char* reason = ::dlerror();
        return fail(fmt::format("cannot open the compiler backend ({})", reason == nullptr ? "unknown reason" : reason),
                    "Keep lib/libmeld_backend.so next to bin/meldc and install libclang-cpp19");
    }
    return reinterpret_cast<decltype(&meld_backend)>(entry)();
}

}  // namespace

Result<const Backend*> load_backend() {
    static const Result<const Backend*> backend = open_backend();
    return backend;
}

}  // namespace meld
