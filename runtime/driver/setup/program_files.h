// Notices that the files of a program have changed.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "runtime/module/abi/module_abi.h"

namespace meld::driver {

class ProgramFiles {
  public:
    // Whether any file of the program that runs now has changed since the last call, and none since the one before: whoever writes one may
    // not be at its end. The first call knows of no change. `program` is one of its files.
    bool changed(const ModuleInfo& module, const std::string& program);

  private:
    struct Stamp {
        std::int64_t seconds = 0, nanoseconds = 0, bytes = 0;
        std::uint64_t inode = 0;
        bool operator==(const Stamp&) const = default;
    };
    using Stamps = std::map<std::string, Stamp>;
    static Stamps look(const ModuleInfo& module, const std::string& program);

    const ModuleInfo* module_ = nullptr;
    Stamps known_, last_;
};

}  // namespace meld::driver
