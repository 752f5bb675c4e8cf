#include "runtime/driver/setup/program_files.h"

#include <sys/stat.h>

#include <span>
#include <utility>

namespace meld::driver {

// Files that are not there are left out: libraries of the compiler never are, and others are while an editor replaces them.
ProgramFiles::Stamps ProgramFiles::look(const ModuleInfo& module, const std::string& program) {
    Stamps stamps;
    const auto add = [&](const std::string& path) {
        struct stat file{};
        if (::stat(path.c_str(), &file) == 0)
            stamps[path] = {file.st_mtim.tv_sec, file.st_mtim.tv_nsec, file.st_size, static_cast<std::uint64_t>(file.st_ino)};
    };
    add(program);
    for (const SourceInfo& source : std::span(module.sources, module.source_count)) add(source.path);
    return stamps;
}

bool ProgramFiles::changed(const ModuleInfo& module, const std::string& program) {
    Stamps now = look(module, program);
    const Stamps last = std::exchange(last_, now);
    // Another program may have other files.
    if (std::exchange(module_, &module) != &module) {
        known_ = std::move(now);
        return false;
    }
    if (now == known_ || now != last || now.size() < known_.size()) return false;
    known_ = std::move(now);
    return true;
}

}  // namespace meld::driver
