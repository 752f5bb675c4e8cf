#include "compiled.h"

#include <cstdio>

namespace meld::retraction {

Result<Module> compiled(const std::string& name, const std::string& options) {
    const std::string command = "'" CLAYMELD_MELDC "' compile '" CLAYMELD_PROGRAMS "/" + name + ".meld' " + options;
    std::FILE* pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) return fail("cannot start " + command);
    std::string output;
    char buffer[4096];
    for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
    if (pclose(pipe) != 0) return fail(command + " failed");
    while (!output.empty() && output.back() == '\n') output.pop_back();
    return load_module(output, kAbiVersion);
}

}  // namespace meld::retraction
