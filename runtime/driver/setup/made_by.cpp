#include "runtime/driver/setup/made_by.h"

#include <string>

#include "runtime/base/version.h"
#include "runtime/comm/transport/mpi_version.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/module/abi/module_note.h"

namespace meld::driver {

nlohmann::ordered_json made_by() {
    return {{"claymeld", kVersion},
            {"module_abi", kAbiVersion},
            {"compiler", "Clang " CLAYMELD_LLVM_VERSION},
            {"mpi", comm::mpi_version()},
            {"processor", host_target()}};
}

}  // namespace meld::driver
