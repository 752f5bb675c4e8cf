#include "runtime/driver/setup/scratch_folder.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdlib>
#include <system_error>

#include "runtime/base/files/output_file.h"
#include "runtime/base/process/interrupt.h"

namespace meld::driver {

namespace fs = std::filesystem;

Scratch::~Scratch() {
    std::error_code error;
    if (!path_.empty()) fs::remove_all(path_, error);
}

Result<void> Scratch::make(std::string_view name) {
    std::error_code error;
    std::string path = (fs::temp_directory_path(error) / fmt::format("{}-XXXXXX", name)).lexically_normal().string();
    interrupt::hold({SIGINT, SIGTERM, SIGHUP});
    if (error || ::mkdtemp(path.data()) == nullptr) return fail(fmt::format("cannot make a folder {}", path));
    path_ = path;
    leftovers_.emplace_back(path);
    return {};
}

Result<void> Scratch::write(const fs::path& file, std::string_view text) {
    std::vector<fs::path> folders;
    for (fs::path folder = file.parent_path(); folder != path_; folder = folder.parent_path()) {
        if (!folder.has_relative_path()) return fail(fmt::format("{} does not lie in {}", file.string(), path_.string()));
        folders.push_back(folder);
    }
    for (; !folders.empty(); folders.pop_back()) {
        std::error_code error;
        if (fs::create_directory(folders.back(), error)) leftovers_.emplace_back(folders.back().string());
    }
    expect(file);
    return write_file(file.string(), text);
}

}  // namespace meld::driver
