// The cache is that of compiled modules. The file is made anew for every version of the text.
#include "compiler/lsp/prelude_file.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "compiler/driver/embedded.h"

namespace meld::lsp {

namespace fs = std::filesystem;

namespace {

fs::path folder() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') return fs::path(cache) / "claymeld";
    if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/') return fs::path(home) / ".cache" / "claymeld";
    return {};
}

bool holds(const fs::path& path, const std::string& text) {
    std::ifstream file(path, std::ios::binary);
    return file && std::string{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()} == text;
}

std::string written_path() {
    const fs::path base = folder();
    if (base.empty()) return "";
    const fs::path path = base / "prelude.meld";
    const std::string text = driver::kPrelude;
    if (holds(path, text)) return path.string();
    std::error_code error;
    fs::create_directories(base, error);
    const fs::path part = path.string() + "." + std::to_string(::getpid());
    std::ofstream(part, std::ios::binary) << text << std::flush;
    fs::rename(part, path, error);
    return !error && holds(path, text) ? path.string() : "";
}

}  // namespace

std::string prelude_path() {
    static const std::string path = written_path();
    return path;
}

bool is_prelude_file(const std::string& path) { return path == prelude_path() || path.ends_with("/stdlib/prelude.meld"); }

}  // namespace meld::lsp
