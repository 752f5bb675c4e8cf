#include "runtime/show/library/view_library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "runtime/base/assert.h"
#include "runtime/show/library/cairo_calls.h"
#include "runtime/show/library/civetweb_calls.h"
#include "runtime/show/library/embree_calls.h"
#include "runtime/show/library/plugin/view_plugin.h"

namespace meld::show {

namespace {

std::string view_path() {
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::filesystem::path beside = program.parent_path().parent_path() / "lib" / "claymeld" / kViewLibrary;
    return std::filesystem::exists(beside, error) ? beside.string() : std::string(kViewLibrary);
}

Result<const ViewLibrary*> open_view() {
    // All of its libraries at once: otherwise the first picture would end the process.
    void* const handle = ::dlopen(view_path().c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const entry = handle == nullptr ? nullptr : ::dlsym(handle, kViewEntry);
    if (entry == nullptr) {
        const char* const reason = ::dlerror();
        return fail(fmt::format("this meldsim has no pictures and no viewer ({})", reason == nullptr ? "unknown reason" : reason),
                    "Install the package claymeld-view, or keep lib/claymeld/libmeld_view.so next to bin/meldsim");
    }
    return reinterpret_cast<decltype(&meld_view)>(entry)();
}

const Result<const ViewLibrary*>& view() {
    static const Result<const ViewLibrary*> library = open_view();
    return library;
}

const ViewLibrary& opened() {
    MELD_CHECK(view().has_value(), "a picture is made without need_view()");
    return **view();
}

}  // namespace

Result<void> need_view() {
    if (!view()) return tl::unexpected<Error>(view().error());
    return {};
}

const Embree& embree() { return *opened().embree; }
const Cairo& cairo() { return *opened().cairo; }
const Civetweb& civetweb() { return *opened().civetweb; }

}  // namespace meld::show
