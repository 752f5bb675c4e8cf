// A compiled program, opened in this process.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "runtime/base/error.h"
#include "runtime/module/abi/module_note.h"

namespace meld {

// Owns an opened module; everything reached through table() is destroyed with it.
class Module {
  public:
    // The value returned by the module's claymeld_module(), never null; runtime/module/abi/module_abi.h describes it.
    const void* table() const { return table_; }
    const ModuleNote& note() const { return note_; }
    const std::string& path() const { return path_; }

  private:
    struct Close {
        void operator()(void* handle) const;
    };
    Module() = default;
    friend Result<Module> load_module(const std::string& path, std::uint32_t expected_abi_version);

    std::unique_ptr<void, Close> handle_;
    const void* table_ = nullptr;
    ModuleNote note_;
    std::string path_;
};

// Reads and checks the module's note and checksum and only then opens it, so that a module of another layout, compiler or
// processor never executes an instruction. Errors: ExitCode::ModuleRefused, or UsageOrWorld if the file cannot be read.
Result<Module> load_module(const std::string& path, std::uint32_t expected_abi_version);

}  // namespace meld
