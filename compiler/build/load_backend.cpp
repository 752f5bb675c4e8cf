// Finds the library relative to the program, so that both can be moved together. A run path in the program would not work: dlopen uses that
// of its caller, which under a sanitizer is the sanitizer's library.
#include "compiler/build/load_backend.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>

namespace meld {
namespace {

std::string backend_path() {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::filesystem::path folder = program.parent_path().parent_path() / "lib" / "claymeld";
    const std::filesystem::path beside = folder / kBackendLibrary;
    return std::filesystem::exists(beside, error) ? beside.string() : std::string(kBackendLibrary);
}

Result<const Backend*> open_backend() {
    void* handle = ::dlopen(backend_path().c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* entry = handle == nullptr ? nullptr : ::dlsym(handle, kBackendEntry);
    if (entry == nullptr) {
        const char* reason = ::dlerror();
        return fail(fmt::format("cannot open the compiler backend ({})", reason == nullptr ? "unknown reason" : reason),
                    "Keep lib/claymeld/libmeld_backend.so next to bin/meldc and install libclang-cpp19");
    }
    return reinterpret_cast<decltype(&meld_backend)>(entry)();
}

}  // namespace

Result<const Backend*> load_backend() {
    static const Result<const Backend*> backend = open_backend();
    return backend;
}

}  // namespace meld
