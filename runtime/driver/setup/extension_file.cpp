#include "runtime/driver/setup/extension_file.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>

#include "runtime/base/version.h"

namespace meld::driver {
namespace {

Result<void> add_extension(const std::string& file, sim::Registry& registry) {
    // For a name without a slash dlopen would use its search path.
    const std::string path = std::filesystem::absolute(file).string();
    // It would also wait for a pipe without a writer.
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) return fail(fmt::format("there is no file {}", file));
    if (!std::filesystem::is_regular_file(status)) return fail(fmt::format("the extension {} is not a file", file));
    void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) {
        const char* reason = ::dlerror();
        return fail(fmt::format("cannot open the extension {} ({})", file, reason == nullptr ? "unknown reason" : reason),
                    "Build it with claymeld_add_extension");
    }
    const auto version = reinterpret_cast<const char* (*)()>(::dlsym(handle, "claymeld_extension_version"));
    const auto add = reinterpret_cast<void (*)(sim::Registry&)>(::dlsym(handle, "claymeld_extension"));
    if (version == nullptr || add == nullptr)
        return fail(fmt::format("{} is not an extension", file), "Define CLAYMELD_EXTENSION in it", ExitCode::ModuleRefused);
    if (std::string_view(version()) != kVersion)
        return fail(fmt::format("the extension {} was built for Claymeld {}, and this is {}", file, version(), kVersion), "Build it again",
                    ExitCode::ModuleRefused);
    add(registry);
    return {};
}

}  // namespace

Result<void> add_extensions(const std::vector<std::string>& files, sim::Registry& registry) {
    for (const std::string& file : files)
        if (Result<void> added = add_extension(file, registry); !added) return added;
    return {};
}

}  // namespace meld::driver
