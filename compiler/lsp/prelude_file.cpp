// The cache is that of compiled modules. The file is made anew for every version of the text.
#include "compiler/lsp/prelude_file.h"

#include "compiler/build/module_cache.h"
#include "compiler/front/embedded.h"
#include "runtime/base/files/input_file.h"

namespace meld::lsp {

namespace {

std::string written_path() {
    const std::string folder = default_cache_dir();
    if (!make_cache_dir(folder)) return "";
    const std::string path = folder + "/prelude.meld";
    const std::string text = front::kPrelude;
    if (read_input(path, text.size()) == text) return path;
    TemporaryFile file(folder, ".prelude");
    return file.write(text) && file.publish(path) ? path : "";
}

}  // namespace

std::string prelude_path() {
    static const std::string path = written_path();
    return path;
}

bool is_prelude_file(const std::string& path) { return path == prelude_path() || path.ends_with("/stdlib/prelude.meld"); }

}  // namespace meld::lsp
