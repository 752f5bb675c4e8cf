// Check first, open afterwards.
#include "runtime/module/load/module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>

namespace meld {
namespace {

tl::unexpected<Error> refuse(const std::string& path, const std::string& problem) {
    return fail(fmt::format("{}: {}", path, problem), "Recompile it: meldc compile PROGRAM.meld", ExitCode::ModuleRefused);
}

Result<ModuleNote> check(const std::string& path, std::uint32_t expected_abi_version) {
    const Result<std::string> file = read_module_file(path);
    if (!file) return tl::unexpected(file.error());
    Result<ModuleNote> note = read_module_note(as_bytes(*file));
    if (!note) return refuse(path, note.error().problem);
    if (note->abi_version != expected_abi_version)
        return refuse(path, fmt::format("built for ABI {}, this is ABI {}", note->abi_version, expected_abi_version));
    if (!host_runs(note->target))
        return refuse(path, fmt::format("built for a processor of level {}, which this machine is not", note->target));
    return note;
}

std::string linker_message() {
    const char* message = ::dlerror();
    return message == nullptr ? "unknown reason" : message;
}

}  // namespace

void Module::Close::operator()(void* handle) const { ::dlclose(handle); }

Result<Module> load_module(const std::string& path, std::uint32_t expected_abi_version) {
    Result<ModuleNote> note = check(path, expected_abi_version);
    if (!note) return tl::unexpected(note.error());
    Module module;
    module.path_ = path;
    module.note_ = *std::move(note);
    // A path without a slash would be searched for in the system's library folders.
    std::error_code ignored;
    module.handle_.reset(::dlopen(std::filesystem::absolute(path, ignored).c_str(), RTLD_NOW | RTLD_LOCAL));
    if (!module.handle_) return refuse(path, fmt::format("it cannot be opened ({})", linker_message()));
    using Entry = const void* (*)();
    const auto entry = reinterpret_cast<Entry>(::dlsym(module.handle_.get(), "claymeld_module"));
    if (entry == nullptr) return refuse(path, "it has no function claymeld_module");
    module.table_ = entry();
    if (module.table_ == nullptr) return refuse(path, "its claymeld_module() returned nothing");
    return module;
}

}  // namespace meld
